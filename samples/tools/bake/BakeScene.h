#pragma once

#include "samples/tools/check/LoadedScene.h"

#include <osgMidair/FieldBaker>

#include <osg/FrameStamp>
#include <osgDB/Registry>
#include <osgUtil/UpdateVisitor>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace midair::samples
{

/// What midair-bake was asked for.
struct BakeArguments
{
    std::string scene;      ///< as osgviewer reads it (MODEL.haptic too)
    std::string settings;   ///< file of settings, as for osgviewer's --device; empty: none
    std::string options;    ///< option string, as for osgviewer's -O
    std::int64_t first = 0; ///< frames first .. end - 1
    std::int64_t end = 0;
    double fps = 60.0; ///< 0.01 .. 40000
    int chunk = 64;    ///< frames between two starts from nothing
    int threads = 1;
    std::string shard = "1/1";
    std::string out;
    bool withoutLive = false; ///< what can't be baked is left out
    bool overwrite = false;
    bool quiet = false;

    std::uint64_t frames() const { return static_cast<std::uint64_t>(end - first); }
    std::uint64_t chunks() const
    {
        const auto size = static_cast<std::uint64_t>(chunk);
        return (frames() + size - 1) / size;
    }
    /// When frame first + \a number begins in the recording, ns.
    std::uint64_t time_ns(std::uint64_t number) const;
};

/// Reads "A:B", frames A .. B - 1. Throws base::InputError.
void parseFrames(const std::string& text, BakeArguments& arguments);

/// Notes which files OSG reads.
class ReadFiles : public osgDB::ReadFileCallback
{
public:
    osgDB::ReaderWriter::ReadResult readObject(const std::string& file,
                                               const osgDB::Options* options) override;
    osgDB::ReaderWriter::ReadResult readImage(const std::string& file,
                                              const osgDB::Options* options) override;
    osgDB::ReaderWriter::ReadResult readNode(const std::string& file,
                                             const osgDB::Options* options) override;

    /// Returns name (from \a folder, if it is in there), size and CRC-32C of each, by name.
    nlohmann::json describe(const std::string& folder) const;

private:
    void note(const std::string& file, const osgDB::Options* options);

    std::vector<std::string> _files;
};

/// A scene whose time goes on frame by frame, from the first one of the arguments.
class BakeScene
{
public:
    /// Reads the scene and looks at its first frame. Throws base::InputError or std::runtime_error
    /// if it can't be read, or has parts that can't be baked and are not to be left out.
    explicit BakeScene(const BakeArguments& arguments);
    ~BakeScene();

    /// All that the recording depends on.
    nlohmann::json work() const;
    unsigned int transducers() const { return _baker->getNumTransducers(); }
    /// Sentences for the user: what was left out, and limits that the player has to keep.
    const std::vector<std::string>& notes() const { return _notes; }

    /// Solves frame first + \a number. Frames before it are passed, so that numbers may only grow.
    /// Throws base::InputError.
    osgMidair::BakedFrame bake(std::uint64_t number);
    void restart() { _baker->restart(); }
    /// Lines with what the scene has told so far.
    std::vector<std::string> messages() const;

private:
    void advanceTo(std::uint64_t number);
    osgMidair::HapticScene& onlyScene() const;

    const BakeArguments& _arguments;
    osg::ref_ptr<ReadFiles> _files;
    std::unique_ptr<LoadedScene> _loaded;
    osg::ref_ptr<osgMidair::HapticScene> _scene;
    osg::ref_ptr<osgMidair::FieldBaker> _baker;
    osg::ref_ptr<osg::FrameStamp> _stamp;
    osgUtil::UpdateVisitor _visitor;
    std::uint64_t _next = 0; ///< number of the frame that the next traversal is for
    std::vector<std::string> _notes;
};

} // namespace midair::samples
