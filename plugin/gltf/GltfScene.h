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

/// A glTF file that isn't read; what() says what is wrong and what would be right.
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

/// What is told of one file, each once, up to kMost: what concerns how it is felt, and what is only
/// drawn in another way.
class GltfMessages
{
public:
    static constexpr std::size_t kMost = 20;

    void say(const std::string& message) { add(_all, message); }
    void sayOfPicture(const std::string& message) { add(_ofPicture, message); }
    /// For what might have made it quieter, and isn't followed.
    void sayUnfollowed(const std::string& message)
    {
        say(message);
        add(_unfollowed, message);
    }
    /// What the extras of its scene say of a HapticScene, as assignments.
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
/// Throws GltfError, which says what is wrong; what is left out of a model that is read is in \a
/// messages.
osg::ref_ptr<osg::Node> readGltf(const std::string& path, GltfMessages& messages);

/// The same of a file's bytes, which name no other file.
osg::ref_ptr<osg::Node> readGltfBytes(const std::string& bytes, GltfMessages& messages);

/// The same, telling the messages as OSG's warnings and notices, too; null, with the reason in \a
/// error, if it isn't read.
osg::ref_ptr<osg::Node>
readGltfAndTell(const std::string& path, GltfMessages& messages, std::string& error);
/// The same for who follows nothing of what the scene says of the array: that is told, too.
osg::ref_ptr<osg::Node> readGltfAndTell(const std::string& path, std::string& error);

} // namespace osgMidair
