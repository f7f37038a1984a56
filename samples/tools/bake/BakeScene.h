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

/// Options of midair-bake.
struct BakeArguments
{
    std::string scene;      ///< any file that osgviewer reads (MODEL.haptic too)
    std::string settings;   ///< file of settings, as for osgviewer's --device; empty: none
    std::string options;    ///< option string, as for osgviewer's -O
    std::int64_t first = 0; ///< frames first .. end - 1
    std::int64_t end = 0;
    double fps = 60.0; ///< 0.01 .. 40000
    int chunk = 64;    ///< frames per chunk; each chunk starts without a previous field
    int threads = 1;
    std::string shard = "1/1";
    std::string out;
    bool withoutLive = false; ///< leave out what can't be baked
    bool overwrite = false;
    bool quiet = false;

    std::uint64_t frames() const { return static_cast<std::uint64_t>(end - first); }
    std::uint64_t chunks() const
    {
        const auto size = static_cast<std::uint64_t>(chunk);
        return (frames() + size - 1) / size;
    }
    /// Returns the start of frame first + \a number in the recording, ns.
    std::uint64_t time_ns(std::uint64_t number) const;
};

/// Reads "A:B", frames A .. B - 1. Throws base::InputError.
void parseFrames(const std::string& text, BakeArguments& arguments);

/// Records which files OSG reads.
class ReadFiles : public osgDB::ReadFileCallback
{
public:
    osgDB::ReaderWriter::ReadResult readObject(const std::string& file,
                                               const osgDB::Options* options) override;
    osgDB::ReaderWriter::ReadResult readImage(const std::string& file,
                                              const osgDB::Options* options) override;
    osgDB::ReaderWriter::ReadResult readNode(const std::string& file,
                                             const osgDB::Options* options) override;

    /// Returns name (relative to \a folder if inside it), size and CRC-32C of each file.
    nlohmann::json describe(const std::string& folder) const;

private:
    void note(const std::string& file, const osgDB::Options* options);

    std::vector<std::string> _files;
};

/// A scene that advances frame by frame, from the first frame of the arguments.
class BakeScene
{
public:
    /// Reads the scene and updates it to its first frame. Throws base::InputError or
    /// std::runtime_error if it can't be read, or if it has parts that can't be baked and
    /// withoutLive is false.
    explicit BakeScene(const BakeArguments& arguments);
    ~BakeScene();

    /// Returns everything that the recording depends on.
    nlohmann::json work() const;
    unsigned int transducers() const { return _baker->getNumTransducers(); }
    /// Sentences for the user: what was left out, and limits that the player must enforce.
    const std::vector<std::string>& notes() const { return _notes; }

    /// Solves frame first + \a number. Skipped frames can't be baked later, so numbers must
    /// increase. Throws base::InputError.
    osgMidair::BakedFrame bake(std::uint64_t number);
    void restart() { _baker->restart(); }
    /// Returns the scene's messages so far.
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
    std::uint64_t _next = 0; ///< number of the next frame to traverse
    std::vector<std::string> _notes;
};

} // namespace midair::samples
