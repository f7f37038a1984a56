#pragma once

#include "haptics/base/threads/Mutex.h"
#include "samples/tools/check/SceneCheck.h"

#include <osg/Group>
#include <osg/Node>
#include <osg/Notify>
#include <osgDB/Options>
#include <osgDB/ReaderWriter>

#include <string>
#include <utility>
#include <vector>

namespace midair::samples
{

/// Reads a file by osgMidair::readModel(), or by the registry's callback, if there is one.
osgDB::ReaderWriter::ReadResult readSafely(const std::string& file, const osgDB::Options* options);

/// Reads the files that PagedLODs and ProxyNodes at and below \a root name, level by level: a
/// viewer's pager does it as it draws, and here nothing is drawn. Reads at most kMostPagedFiles.
/// Returns sentences about what is not read.
std::vector<std::string> readPagedFiles(osg::Node& root);
constexpr int kMostPagedFiles = 256;

/// Keeps what OSG and its plugins say, in place of stderr.
class NoticeKeeper : public osg::NotifyHandler
{
public:
    void notify(osg::NotifySeverity severity, const char* message) override;

    /// What is said while it is paused is dropped.
    void setPaused(bool isPaused);

    struct Line
    {
        std::string text; ///< without the kit's name
        bool isOurs;      ///< the kit says it
        bool isNote;      ///< it is no fault of what is felt
    };

    /// What OSG says with WARN or worse and the kit with NOTICE, each once.
    std::vector<Line> lines() const;

private:
    mutable base::Mutex _mutex;
    std::vector<Line> _lines MIDAIR_GUARDED_BY(_mutex);
    bool _isPaused MIDAIR_GUARDED_BY(_mutex) = false;
};

/// A file's scene with all its HapticScenes set to be rehearsed, so that no hardware is opened.
/// What has none gets one, as a viewer's --device or MODEL.haptic would give it.
class LoadedScene
{
public:
    struct Scene
    {
        osg::ref_ptr<osgMidair::HapticScene> node;
        osgMidair::HapticSettings asked;
    };

    /// Throws std::runtime_error if a file can't be read.
    explicit LoadedScene(const CheckOptions& options);
    ~LoadedScene();

    osg::Group& root() { return *_root; }
    const std::vector<Scene>& scenes() const { return _scenes; }
    const std::string& wrapped() const { return _wrapped; }

    /// Returns what keeps a viewer from coming to \a node: "the node mask of Group 'room'"; empty:
    /// nothing.
    static std::string hiddenBy(const osg::Node& node);

    /// Transform from the frame of the node's parent to the world.
    static osg::Matrixd worldAbove(osg::Node& node);

    /// Returns \a message with the line of the file that names its node, where that is known.
    CheckedMessage located(const osgMidair::HapticMessage& message) const;

    /// Returns what was said by others than \a scenes.
    std::vector<CheckedMessage> notices(const std::vector<CheckedScene>& scenes) const;

private:
    void wrap(const CheckOptions& options, osg::Node& node);
    void readLines();

    std::string _file;
    std::string _wrapped;
    std::vector<std::string> _notRead; ///< files that the scene names, in sentences
    osg::ref_ptr<NoticeKeeper> _keeper;
    osg::ref_ptr<osg::NotifyHandler> _before;
    osg::ref_ptr<osg::Group> _root;
    std::vector<Scene> _scenes;
    std::vector<std::pair<std::string, int>> _names; ///< names of nodes and their lines
};

} // namespace midair::samples
