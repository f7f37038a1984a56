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

/// Reads a file with the registry's read callback if there is one, else with
/// osgMidair::readModel().
osgDB::ReaderWriter::ReadResult readSafely(const std::string& file, const osgDB::Options* options);

/// Loads the children of all PagedLODs and ProxyNodes at and below \a root, level by level, because
/// nothing is drawn here and so no pager runs. Reads at most kMostPagedFiles files. Returns a
/// sentence for each file that was not read.
std::vector<std::string> readPagedFiles(osg::Node& root);
constexpr int kMostPagedFiles = 256;

/// Collects the notices of OSG and its plugins instead of printing them to stderr.
class NoticeKeeper : public osg::NotifyHandler
{
public:
    void notify(osg::NotifySeverity severity, const char* message) override;

    /// While paused, notices are dropped.
    void setPaused(bool isPaused);

    struct Line
    {
        std::string text; ///< without the prefix "osgMidair: "
        bool isOurs;      ///< written by the kit
        bool isNote;      ///< has no effect on the haptics
    };

    /// Returns OSG's notices of level WARN or worse and the kit's of level NOTICE or worse, without
    /// duplicates.
    std::vector<Line> lines() const;

private:
    mutable base::Mutex _mutex;
    std::vector<Line> _lines MIDAIR_GUARDED_BY(_mutex);
    bool _isPaused MIDAIR_GUARDED_BY(_mutex) = false;
};

/// A scene file with all its HapticScenes in rehearsal, so that no hardware is opened. A file
/// without a HapticScene gets one, as from a viewer's --device or MODEL.haptic.
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

    /// Returns what hides \a node from a viewer, e.g. "the node mask of Group 'room'"; empty if
    /// nothing does.
    static std::string hiddenBy(const osg::Node& node);

    /// Transform from the frame of the node's parent to the world.
    static osg::Matrixd worldAbove(osg::Node& node);

    /// Returns \a message with the line of the file that defines its node, if that is known.
    CheckedMessage located(const osgMidair::HapticMessage& message) const;

    /// Returns the notices that are not among the messages of \a scenes.
    std::vector<CheckedMessage> notices(const std::vector<CheckedScene>& scenes) const;

private:
    void wrap(const CheckOptions& options, osg::Node& node);
    void readLines();

    std::string _file;
    std::string _wrapped;
    std::vector<std::string> _notRead; ///< sentences about files that are missing, and about tags
    osg::ref_ptr<NoticeKeeper> _keeper;
    osg::ref_ptr<osg::NotifyHandler> _before;
    osg::ref_ptr<osg::Group> _root;
    std::vector<Scene> _scenes;
    std::vector<std::pair<std::string, int>> _names; ///< node names and their lines
};

} // namespace midair::samples
