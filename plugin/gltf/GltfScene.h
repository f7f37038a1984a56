#pragma once

#include <osg/Node>
#include <osg/ref_ptr>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace osgMidair
{

/// An unreadable glTF file; what() names the error and what would be valid.
class GltfError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// Throws a GltfError.
template<typename... Values>
[[noreturn]] void failGltf(fmt::format_string<Values...> what, Values&&... values)
{
    throw GltfError(fmt::format(what, std::forward<Values>(values)...));
}

/// Messages about one file, each once, up to kMost: those that concern what is played, and those
/// that concern only the picture.
class GltfMessages
{
public:
    static constexpr std::size_t kMost = 20;

    void say(const std::string& message) { add(_all, message); }
    void sayOfPicture(const std::string& message) { add(_ofPicture, message); }
    /// For an ignored extra that might have made it quieter.
    void sayUnfollowed(const std::string& message)
    {
        say(message);
        add(_unfollowed, message);
    }
    /// Adds a HapticScene's setting from the scene's extras, as an assignment.
    void addSetting(const std::string& assignment) { _settings += assignment + "\n"; }
    const std::vector<std::string>& all() const { return _all; }
    const std::vector<std::string>& ofPicture() const { return _ofPicture; }
    const std::vector<std::string>& unfollowed() const { return _unfollowed; }
    const std::string& settings() const { return _settings; }

private:
    static void add(std::vector<std::string>& to, const std::string& message)
    {
        if (to.size() < kMost && std::find(to.begin(), to.end(), message) == to.end())
            to.push_back(message);
    }

    std::vector<std::string> _all;
    std::vector<std::string> _ofPicture;
    std::vector<std::string> _unfollowed;
    std::string _settings;
};

/// Reads a glTF 2.0 model, .gltf or .glb: nodes, meshes, base colours, textures, skins, animations,
/// and the extras of nodes, meshes and the scene as tags; metres, turned from y up to OSG's z up.
/// Throws GltfError; \a messages get the parts left out.
osg::ref_ptr<osg::Node> readGltf(const std::string& path, GltfMessages& messages);

/// The same for a file's bytes, which reference no other file.
osg::ref_ptr<osg::Node> readGltfBytes(const std::string& bytes, GltfMessages& messages);

/// The same, and also logs the messages as OSG's warnings and notices; null, with the reason in \a
/// error, on failure.
osg::ref_ptr<osg::Node>
readGltfAndTell(const std::string& path, GltfMessages& messages, std::string& error);
/// The same for callers that ignore the scene's settings of the array: warns about these, too.
osg::ref_ptr<osg::Node> readGltfAndTell(const std::string& path, std::string& error);

} // namespace osgMidair
