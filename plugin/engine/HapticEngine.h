#pragma once

#include "device/limits/UserLimits.h"
#include "engine-bridge/air/AirTemperature.h"
#include "engine-bridge/pipeline/HologramThread.h"
#include "haptics/base/text/LineLimit.h"
#include "haptics/base/text/MessageLog.h"
#include "plugin/engine/FieldOfResult.h"
#include "plugin/engine/JoinedScene.h"
#include "plugin/engine/LatencyStatistics.h"
#include "plugin/engine/SceneOwners.h"
#include "plugin/hands/HandTracker.h"
#include "plugin/scene/SceneCollector.h"

#include <osgMidair/DeviceCallback>
#include <osgMidair/HapticSettings>
#include <osgMidair/HapticStatistics>

#include <osg/OperationThread>
#include <osg/Referenced>
#include <osg/observer_ptr>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace osgGA
{
class GUIActionAdapter;
}
namespace osgViewer
{
class View;
class ViewerBase;
} // namespace osgViewer

namespace midair::haptics
{
class ArrayFileWatch;
}

namespace osgMidair
{

class HapticScene;

/// Does the work of a HapticScene: collects the scene below a root into snapshots, hands them to a
/// hologram thread and keeps the statistics.
///
/// Only latestResult(), field(), statistics(), array(), medium(), root() and setMuted() may be
/// called from any thread, and noteBound() from a cull; all others belong to the thread that
/// updates the scene.
class HapticEngine : public osg::Referenced
{
public:
    /// \a root: a HapticScene, or a node with another owner. \a root and \a settings are used as
    /// long as \a root lives. If there is an owner further out, this engine opens nothing: that
    /// owner plays the scene.
    HapticEngine(osg::Node& root, const HapticSettings& settings, OwnerKind kind);

    /// Sets how the whole scene is felt if nothing below the root is marked as haptic.
    void setUnmarkedProperty(const HapticProperty& property)
    {
        _collector.setUnmarkedProperty(property);
    }

    /// Sets a function that changes the options of each new pipeline: to use an application's own
    /// solver or device, or other limits.
    void setOptionsFilter(std::function<void(midair::bridge::HologramOptions&)> filter)
    {
        _filter = std::move(filter);
    }

    /// From now on update() runs after each update traversal of the viewer behind \a adapter, once
    /// per frame even if several of its views show the root; while none does, the array is silent.
    /// Does nothing without an osgViewer. Returns false if nothing changed, as \a adapter is that
    /// of the last call.
    bool follow(osgGA::GUIActionAdapter* adapter);
    void follow(osgViewer::ViewerBase& viewer);

    /// The same for the viewer whose camera is above \a node, for loops that run no event
    /// traversal. Returns its view, or null if none is above or one is followed already.
    osgGA::GUIActionAdapter* followAbove(const osg::Node& node);

    /// \{ For an owner that frames come by (a callback, a device): each visit is noted, and \a
    /// isInPlace says of the root whether the owner still is where it was put, for loops that don't
    /// always come by.
    void noteVisit() { ++_visits; }
    void setPlace(std::function<bool(const osg::Node&)> isInPlace)
    {
        _isInPlace = std::move(isInPlace);
    }
    /// \}
    /// Returns false if nobody leads it any more: its owner is no longer in its place, and no frame
    /// has come by since \a visitsSeen, which is counted on. A scene is led by its graph. On the
    /// update thread.
    bool isLed(const osg::Node& root, unsigned int& visitsSeen);
    /// Who collects it, which only is compared: the last one silences it when it does no longer. On
    /// the update thread.
    void setCollectedBy(const void* who) { _collectedBy = who; }
    const void* collectedBy() const { return _collectedBy; }

    /// Returns the root, or null if it is gone.
    osg::ref_ptr<osg::Node> root() const;

    /// The next update looks for new tags below the root.
    void dirtyTags()
    {
        _collector.dirtyTags();
        lookNext();
    }

    /// Returns true if there is nothing to do in this frame, and then counts it: nothing has
    /// changed for kRest_s, everything was looked at less than kLook_s ago, and the bound of \a
    /// root shows that nothing below it has moved since. Changes that no bound shows (masks,
    /// vertices, tags) are found by the next look. Only for a root that calls noteBound()
    /// whenever its bound is computed, and that has no transform above it.
    bool rests(const osg::Node& root);
    void noteBound() { ++_rest.bounds; }
    static constexpr double kRest_s = 0.5;
    static constexpr double kLook_s = 0.1;

    /// Collects one frame: the active haptic objects below \a roots (the engine's own root, and
    /// those of its guests) are felt from now on. \a age_s: time since the frame's stamp. Touch
    /// callbacks are called last.
    void update(const std::vector<SceneRoot>& roots,
                unsigned int frame,
                double age_s,
                double simulationTime_s);

    /// As HapticScene::setJoined().
    void setJoined(bool joined);
    bool isJoined() const { return _joined.isJoined(); }
    /// The engine of a joined scene that plays this one's; null: none does. On the update thread.
    osg::ref_ptr<HapticEngine> host() const { return _joined.host(); }
    /// Puts the engines whose host this one is into \a guests. On the update thread.
    void findGuests(std::vector<osg::ref_ptr<HapticEngine>>& guests) const
    {
        _joined.findGuests(guests);
    }
    /// Returns true if this engine plays at all, and on the array and at the place that \a other
    /// asks for, so that it can play for that. On the update thread of both.
    bool suits(const HapticEngine& other) const;

    /// What a FieldBaker solves by itself, see collectForBaking().
    struct Baked
    {
        const midair::bridge::SceneSnapshot* snapshot = nullptr; ///< null: another engine plays it
        /// Counts changes of the settings that fields are played with.
        std::uint64_t settings = 0;
    };
    /// Collects one frame as update() does, for a caller that solves by itself: no device, no hand
    /// source and no thread are opened, from the first call on. Objects are read to their end. The
    /// snapshot is valid until the next call.
    Baked collectForBaking(const SceneRoot& root, unsigned int frame, double simulationTime_s);
    /// The options, and what makes a pipeline of these with the scene's array, as the last
    /// collectForBaking() found them. The function throws what is wrong with the array.
    midair::bridge::HologramOptions optionsForBaking() const { return hologramOptions(); }
    std::unique_ptr<midair::bridge::HologramPipeline>
    makePipeline(const midair::bridge::HologramOptions& options) const
    {
        return pipelineMaker(options)();
    }

    /// Adds \a message, or counts it if it is there, and passes it on to osg::notify() once; of one
    /// code and path no more than a LineLimit lets through.
    void say(midair::base::Message message);

    /// Returns the touches that have begun and not ended. From any thread.
    std::vector<Touch> touches() const;

    /// As HapticScene::setRehearsed().
    void setRehearsed(bool rehearsed);
    bool isRehearsed() const { return _isRehearsed; }
    /// As HapticScene::getGrantedSettings() and getFoundObjects(). For the update thread only.
    HapticSettings grantedSettings() const { return _configured ? _granted : *_given; }
    std::vector<FoundObject> found() const;

    /// For the update thread only.
    HandTracker& hands() { return _hands; }
    const HandTracker& hands() const { return _hands; }

    /// The next frame looks at everything, even at rest.
    void lookNext() { _rest.lookTime_s = 0.0; }

    /// Silences the array until the next update() and ends all touches.
    void silence();

    /// Silences the array, and closes device and hands until the next update(). Doesn't wait for
    /// the device: the thread ends at a later call.
    void close();

    /// Silences the array at once, with the device open and hands and touches going on, until
    /// setMuted(false). Any thread.
    void setMuted(bool muted);
    bool isMuted() const { return _muted; }

    /// Returns true if another owner, further out or beside it, plays the scene. For the update
    /// thread only.
    bool isPlayedByAnother() const { return !_outer.empty(); }
    /// Returns the settings as they are used; before the first update() as they were given. For the
    /// update thread only, while the root lives.
    const HapticSettings& settings() const { return _configured ? _settings : *_given; }

    /// For the update thread only.
    void setDeviceCallback(DeviceCallback* callback) { _deviceCallback = callback; }
    DeviceCallback* deviceCallback() const { return _deviceCallback.get(); }

    std::shared_ptr<const midair::bridge::HologramResult> latestResult() const;
    /// The public form of the newest result; null before the first field.
    osg::ref_ptr<const HapticField> field() const { return _newest.get(latestResult()); }
    HapticStatistics statistics() const;
    /// What a simulated device has played in the last \a duration_s (0 .. 0.1). Any thread.
    midair::bridge::PlayedDrives playedOfLate(double duration_s) const;
    std::shared_ptr<const midair::haptics::TransducerArray> array() const;
    midair::haptics::Medium medium() const;

protected:
    /// Silences the array before it returns; writes the report if there is to be one.
    ~HapticEngine() override;

private:
    /// The array, which the hologram thread loads.
    struct LoadedArray
    {
        std::mutex mutex;
        std::shared_ptr<const midair::haptics::TransducerArray> array;
        std::uint64_t rereads = 0; ///< how often its file has changed and was right then
    };

    std::string name() const;
    bool standsBack();
    void takePlace();
    void openHands();
    void attachMouse();
    void listenAtCamera();
    void followThermometer();
    void tellTouches();
    bool collect(const std::vector<SceneRoot>& roots);
    void configure(const HapticSettings& settings);
    void readSettings(const HapticSettings& given);
    void keepInnerLimits();
    midair::bridge::HologramOptions hologramOptions() const;
    std::function<std::unique_ptr<midair::bridge::HologramPipeline>()>
    pipelineMaker(const midair::bridge::HologramOptions& options) const;
    void applyToThread();
    void noteForBaking(bool isSame);
    void startThread();
    void endThread();
    bool mayTouch() const;
    /// Returns true if the snapshot differs from the last submitted one. \a objectsToo: false
    /// compares only hands and obstacles.
    bool changedSinceSubmitted(bool objectsToo) const;
    void submit();
    void takeResult();
    void tellState();
    void keep(midair::base::Message message, bool isCounted);
    void takeMessages(const midair::bridge::HologramResult& result);
    void tellSlowSolver(double now_s);
    void tellLines(double now_s);

    osg::observer_ptr<osg::Node> _root;
    SceneOwner _owner;
    JoinedScene _joined;
    PlayingPlace _place; ///< while there is a thread, or it waits for one
    std::atomic<unsigned int> _visits{0};
    std::function<bool(const osg::Node&)> _isInPlace; ///< none: not known
    const void* _collectedBy = nullptr;
    const OwnerKind _kind;
    const HapticSettings* const _given; ///< valid while _root is
    std::function<void(midair::bridge::HologramOptions&)> _filter;
    std::vector<osg::observer_ptr<osg::Operation>> _followers; ///< operations in viewers
    /// argument of the last follow(); same object as _view
    osgGA::GUIActionAdapter* _adapter = nullptr;
    osg::observer_ptr<osgViewer::View> _view;
    osgViewer::ViewerBase* _viewer = nullptr; ///< viewer of _view at that time
    SceneCollector _collector;
    HandTracker _hands;
    midair::bridge::SceneSnapshot _snapshot; ///< being filled
    /// objects of the last snapshot handed over
    std::vector<midair::bridge::HapticObject> _submitted;
    midair::bridge::HandsAndObstacles _submittedAround;
    Eigen::Matrix3Xd _submittedEars = Eigen::Matrix3Xd(3, 0);
    double _handsSeen_s = -1e9; ///< steady clock; when there was a hand
    bool _submittedAny = false;
    std::uint64_t _resultsSeen = 0;
    std::uint64_t _takenUpTo = 0;   ///< newest Message::said of those that the thread has told
    midair::base::LineLimit _lines; ///< of osg::notify()
    double _slowUntil_s = 0.0;      ///< for how long a slow solver is told already; 0: none is
    ArrayState _stateTold = ArrayState::CLOSED;
    osg::ref_ptr<DeviceCallback> _deviceCallback;
    /// State that rests() reads in every frame, usually from a cold cache: kept in one cache line.
    struct alignas(64) Rest
    {
        /// how often the bound was computed, perhaps in a cull
        std::atomic<unsigned int> bounds{0};
        unsigned int boundsSeen = 0;  ///< value of bounds in the last update()
        unsigned int changesSeen = 0; ///< value of propertyChanges() then
        bool possible = false;        ///< something was submitted, and there is no hand source
        double lookTime_s = 0.0;      ///< time of the last update()
        double submitTime_s = 0.0;
        std::atomic<std::uint64_t> frames{0}; ///< number of frames at rest
    };
    Rest _rest;
    Eigen::Isometry3d _worldToArray = Eigen::Isometry3d::Identity(); ///< world in metres -> array
    Eigen::Matrix4d _toArray = Eigen::Matrix4d::Identity(); ///< world in scene units -> array
    HapticSettings _settings;                               ///< as used: granted and repaired
    HapticSettings _raw;                                    ///< as given
    HapticSettings _granted;            ///< as _settings, but for what a rehearsal replaces
    midair::device::UserCaps _userCaps; ///< those that _settings keep
    bool _isRehearsed = false;
    bool _isBaked = false;           ///< by a FieldBaker: nothing is opened
    std::uint64_t _bakedChanges = 0; ///< how often _applied has changed since
    bool _configured = false;
    bool _isOpen = false;     ///< the thread has what _applied says
    bool _isCrowded = false;  ///< no place was free
    bool _isReported = false; ///< it was meant to play
    /// Those of the settings that the thread has: array, device and what its fields are played
    /// with, inner caps included.
    HapticSettings _applied;
    std::shared_ptr<std::atomic<bool>> _begun; ///< there was a pipeline on _begunOn
    std::string _begunOn;                      ///< device
    bool _isArrayRefused = false;              ///< by the user's grants, which have said so
    std::string _outer; ///< name of the owner that plays this scene instead; empty: none
    double _innerPressure_Pa = 0.0; ///< the strictest cap of scenes inside this one; 0: none
    double _innerAmplitude = 1.0;
    double _innerEarLimit_dB = 0.0; ///< likewise; 0: none
    midair::bridge::AirTemperature _air;
    double _air_C = 20.0; ///< temperature that fields are solved for

    NewestField _newest;
    std::atomic<bool> _muted{false};

    mutable std::mutex _mutex; ///< guards the members below
    std::unique_ptr<midair::bridge::HologramThread> _thread;
    std::shared_ptr<const midair::bridge::HologramResult> _closed; ///< that of a thread that ended
    std::shared_ptr<LoadedArray> _array;
    std::shared_ptr<midair::haptics::ArrayFileWatch> _watch; ///< for the hologram thread
    midair::haptics::Medium _medium;
    midair::base::MessageLog _messages;
    HapticStatistics _statistics; ///< the part that the engine counts
    LatencyStatistics _latencies;
    std::vector<Touch> _touches; ///< that have begun and not ended
    std::shared_ptr<const midair::bridge::HologramResult> _seen;
};

} // namespace osgMidair
