#pragma once

#include "engine-bridge/pipeline/HologramResult.h"
#include "engine-bridge/player/ScenePlayer.h"
#include "engine-bridge/player/SceneSolve.h"
#include "haptics/base/threads/Forks.h"
#include "haptics/base/threads/Mutex.h"
#include "plugin/engine/SceneOwners.h"
#include "plugin/hands/TouchTeller.h"
#include "plugin/scene/SceneCollector.h"

#include <osgMidair/DeviceCallback>
#include <osgMidair/FieldCallback>
#include <osgMidair/HandSource>
#include <osgMidair/HapticField>
#include <osgMidair/HapticMessage>
#include <osgMidair/HapticSettings>
#include <osgMidair/HapticStatistics>
#include <osgMidair/HeadSource>

#include <osg/OperationThread>
#include <osg/Referenced>
#include <osg/observer_ptr>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{
class HandBodies;
} // namespace midair::bridge
namespace osgGA
{
class GUIActionAdapter;
}
namespace osgViewer
{
class View;
class ViewerBase;
} // namespace osgViewer

namespace osgMidair
{

class HapticScene;

/// The OSG side of a HapticScene: collects the scene below a root into snapshots for a ScenePlayer,
/// follows viewers, and reports touches and states to callbacks.
///
/// Only functions marked so may be called from any thread, and noteBound() from a cull traversal;
/// all others belong to the scene's update thread.
class HapticEngine : public osg::Referenced
{
public:
    /// \a root: a HapticScene, or a node with another owner. \a root and \a settings are used as
    /// long as \a root lives. If there is an outer owner, this engine opens nothing, because that
    /// owner plays the scene.
    HapticEngine(osg::Node& root, const HapticSettings& settings, OwnerKind kind);

    /// Sets the property for the whole scene if nothing below the root is tagged as haptic.
    void setUnmarkedProperty(const HapticProperty& property)
    {
        _collector.setUnmarkedProperty(property);
    }

    /// Sets a function that changes the options of each new pipeline, e.g. to use an application's
    /// own solver, device or limits.
    void setOptionsFilter(std::function<void(midair::bridge::HologramOptions&)> filter)
    {
        _player->setFilter(std::move(filter));
    }

    /// From now on update() runs after each update traversal of the viewer behind \a adapter, once
    /// per frame even if several of its views show the root; while none does, the array is silent.
    /// Does nothing without an osgViewer. Returns false if nothing changed because \a adapter is
    /// that of the last call.
    bool follow(osgGA::GUIActionAdapter* adapter);
    void follow(osgViewer::ViewerBase& viewer);

    /// The same for the viewer whose camera is above \a node, for loops without an event traversal.
    /// Returns its view, or null if there is none above or one is followed already.
    osgGA::GUIActionAdapter* followAbove(const osg::Node& node);

    /// \{ For an owner that frames visit (a callback, a device): each visit is noted, and \a
    /// isInPlace tells whether the owner is still attached to the root, for loops that don't always
    /// visit it.
    void noteVisit() { ++_lead.visits; }
    void setPlace(std::function<bool(const osg::Node&)> isInPlace)
    {
        _lead.isInPlace = std::move(isInPlace);
    }
    /// \}
    /// Returns false if the scene has lost its owner: the owner is detached and no frame has
    /// visited it since \a visitsSeen, which is updated. A HapticScene is always led by its graph.
    /// On the update thread.
    bool isLed(const osg::Node& root, unsigned int& visitsSeen);
    /// The collector's identity, used only for comparison: the last collector silences the scene
    /// when it stops. On the update thread.
    void setCollectedBy(const void* who) { _lead.collectedBy = who; }
    const void* collectedBy() const { return _lead.collectedBy; }

    /// Returns the root, or null if it is gone. From any thread.
    osg::ref_ptr<osg::Node> root() const;

    /// Makes the next update look for new tags below the root.
    void dirtyTags()
    {
        _collector.dirtyTags();
        lookNext();
    }

    /// Returns true if this frame has nothing to do, and then counts it: nothing has changed for
    /// kRest_s, everything was checked less than kLook_s ago, and the bound of \a root shows that
    /// nothing below it has moved since. Changes that no bound shows (masks, vertices, tags) are
    /// found by the next check. Only for a root that calls noteBound() whenever its bound is
    /// computed, and that has no transform above it.
    bool rests(const osg::Node& root);
    /// The same for a loop that collects \a root itself, whatever is above it: the last frame had
    /// only this root, in the same place.
    bool rests(const SceneRoot& root);
    void noteBound() { ++_rest.bounds; }
    static constexpr double kRest_s = 0.5;
    static constexpr double kLook_s = 0.1;

    /// Collects one frame: from now on plays the active haptic objects below \a roots (the engine's
    /// own root, and those of its guests). \a age_s: time since the frame's stamp. Calls touch
    /// callbacks last.
    void update(const std::vector<SceneRoot>& roots,
                unsigned int frame,
                double age_s,
                double simulationTime_s);

    /// As HapticScene::setJoined().
    void setJoined(bool joined);
    bool isJoined() const { return _ownership.joined.isJoined(); }
    /// The engine of a joined scene that plays this one; null: none. On the update thread.
    osg::ref_ptr<HapticEngine> host() const { return _ownership.joined.host(); }
    /// Stores the engines whose host this one is in \a guests. On the update thread.
    void findGuests(std::vector<osg::ref_ptr<HapticEngine>>& guests) const
    {
        _ownership.joined.findGuests(guests);
    }
    /// Returns true if this engine plays, with the same array and placement as \a other, so that it
    /// can play for it. On the update thread of both.
    bool suits(const HapticEngine& other) const;

    /// Input of a FieldBaker, see collectForBaking().
    struct Baked
    {
        const midair::bridge::SceneSnapshot* snapshot = nullptr; ///< null: another engine plays it
        /// Counts changes of the settings used for playing.
        std::uint64_t settings = 0;
    };
    /// Collects one frame as update() does, for a caller that solves itself: from the first call on
    /// no device, hand source or thread is opened. Objects are read completely. The snapshot is
    /// valid until the next call.
    Baked collectForBaking(const SceneRoot& root, unsigned int frame, double simulationTime_s);
    /// The options, and a factory for pipelines with these and the scene's array, as of the last
    /// collectForBaking(). The factory throws if the array is invalid.
    midair::bridge::HologramOptions optionsForBaking() const { return _player->options(); }
    std::unique_ptr<midair::bridge::HologramPipeline>
    makePipeline(const midair::bridge::HologramOptions& options) const
    {
        return _player->pipelineMaker(options)();
    }

    /// Adds \a message or increments its count, and passes it to osg::notify() once; for one code
    /// and path at most as often as a MessageLog prints.
    void say(midair::base::Message message) { _player->log().say(std::move(message)); }
    /// As of MessageLog.
    void sayNow(const midair::base::Topic& topic, const std::vector<midair::base::Message>& all)
    {
        _player->log().sayNow(topic, all);
    }

    /// Returns the current touches. From any thread.
    std::vector<Touch> touches() const;

    /// As HapticScene::setRehearsed().
    void setRehearsed(bool rehearsed);
    bool isRehearsed() const { return _settings.isRehearsed; }
    /// As HapticScene::getGrantedSettings() and getFoundObjects().
    HapticSettings grantedSettings() const;
    std::vector<FoundObject> found() const;

    /// \{ As of HapticScene.
    void setHandSource(HandSource* source);
    HandSource* handSource() const { return _given.hands; }
    void setHeadSource(HeadSource* source);
    HeadSource* headSource() const { return _given.head; }
    bool head(Head& head) const;
    void setDisplayTime(double steady_s) { _player->setDisplayTime(steady_s); }
    /// As ScenePlayer::setViewing().
    void setViewing(midair::bridge::Viewing viewing) { _player->setViewing(std::move(viewing)); }
    /// The hands of \a bodies belong to this scene as long as it lives: what they push counts as
    /// touched.
    void addBodies(std::weak_ptr<midair::bridge::HandBodies> bodies)
    {
        _given.bodies.push_back(std::move(bodies));
    }
    void setTouchCallback(TouchCallback* callback) { _touches.setCallback(callback); }
    TouchCallback* touchCallback() const { return _touches.callback(); }
    void setObstacles(const std::vector<Obstacle>& obstacles) { _given.obstacles = obstacles; }
    const std::vector<Obstacle>& obstacles() const { return _given.obstacles; }
    void setEars(const std::vector<osg::Vec3d>& ears) { _given.ears = ears; }
    const std::vector<osg::Vec3d>& ears() const { return _given.ears; }
    void setFieldCallback(FieldCallback* callback);
    FieldCallback* fieldCallback() const { return _told.fieldCallback.get(); }
    /// \}

    /// As HapticScene::solve().
    osg::ref_ptr<const HapticField> solve(const SceneRoot& root, std::string& error);
    const midair::bridge::HandTracker& hands() const { return _player->hands(); }

    /// Makes the next frame check everything, even at rest.
    void lookNext() { _rest.lookTime_s = 0.0; }

    /// Silences the array until the next update() and ends all touches.
    void silence();

    /// Silences the array, and closes device and hands until the next update(). Doesn't wait for
    /// the device: the thread ends at a later call.
    void close();

    /// Silences the array at once until setMuted(false); the device stays open, and hands and
    /// touches go on. Any thread.
    void setMuted(bool muted) { _player->setMuted(muted); }
    bool isMuted() const { return _player->isMuted(); } ///< any thread

    /// Returns true if another owner, an outer or joined one, plays the scene.
    bool isPlayedByAnother() const { return !_ownership.outer.empty(); }
    /// Returns the settings in effect, without caps of other scenes; before the first update() the
    /// given ones. Valid while the root lives.
    const HapticSettings& settings() const
    {
        return _settings.isRead ? *_settings.used : *_given.settings;
    }
    /// Returns false if the settings or the user's caps forbid playing.
    bool mayPlay() const
    {
        return _settings.isRead ? _player->mayPlay() : _given.settings->enabled;
    }

    void setDeviceCallback(DeviceCallback* callback) { _told.callback = callback; }
    DeviceCallback* deviceCallback() const { return _told.callback.get(); }
    void setMessageCallback(MessageCallback* callback);
    MessageCallback* messageCallback() const { return _told.messageCallback.get(); }
    void clearMessages() { _player->log().forgetEnded(); } ///< any thread

    /// \{ Any thread.
    std::shared_ptr<const midair::bridge::HologramResult> latestResult() const
    {
        return _player->latestResult();
    }
    /// The public form of the newest result; null before the first field. Calls for the same result
    /// return the same object.
    osg::ref_ptr<const HapticField> field() const;
    /// As HapticScene::waitForField().
    osg::ref_ptr<const HapticField> awaitField(double timeout_s, std::string& error) const;
    HapticStatistics statistics() const;
    /// Drives that a simulated device has played in the last \a duration_s (0 .. 0.1).
    midair::bridge::PlayedDrives playedOfLate(double duration_s) const
    {
        return _player->playedOfLate(duration_s);
    }
    std::shared_ptr<const midair::haptics::TransducerArray> array() const
    {
        return _player->array();
    }
    midair::haptics::Medium medium() const { return _player->medium(); }
    /// \}

protected:
    /// Silences the array before it returns; writes the report if one was requested.
    ~HapticEngine() override;

private:
    /// Owner and player of the scene.
    struct Ownership
    {
        SceneOwner owner;
        JoinedScene joined;
        PlayingPlace place; ///< held while there is a thread, or it waits for one
        const OwnerKind kind;
        std::string outer; ///< name of the owner that plays this scene instead; empty: none
    };
    /// Objects set by the application.
    struct Given
    {
        const HapticSettings* const settings; ///< valid while the root lives
        osg::ref_ptr<HandSource> hands;
        osg::ref_ptr<HeadSource> head;
        std::vector<Obstacle> obstacles;
        std::vector<std::weak_ptr<midair::bridge::HandBodies>> bodies;
        std::vector<osg::Vec3d> ears; ///< world frame, scene units
    };
    /// State and field as last reported.
    struct Told
    {
        osg::ref_ptr<DeviceCallback> callback;
        osg::ref_ptr<MessageCallback> messageCallback;
        std::uint64_t messages = 0; ///< newest reported change
        ArrayState state = ArrayState::CLOSED;
        osg::ref_ptr<FieldCallback> fieldCallback;
        osg::ref_ptr<const HapticField> field;
    };
    /// The leader of the scene.
    struct Lead
    {
        std::atomic<unsigned int> visits{0};
        std::function<bool(const osg::Node&)> isInPlace; ///< none: unknown
        const void* collectedBy = nullptr;
    };
    /// The viewers that show the scene.
    struct Followed
    {
        std::vector<osg::observer_ptr<osg::Operation>> operations; ///< in viewers
        /// argument of the last follow(); same object as view
        osgGA::GUIActionAdapter* adapter = nullptr;
        osg::observer_ptr<osgViewer::View> view;
        osgViewer::ViewerBase* viewer = nullptr; ///< viewer of view at that time
    };
    /// The settings as last read, and those in effect: granted and repaired.
    struct Settings
    {
        HapticSettings seen;
        std::shared_ptr<const HapticSettings> used;
        bool isRead = false;         ///< used is derived from seen
        bool isRehearsed = false;    ///< no hardware is opened
        bool isBaked = false;        ///< by a FieldBaker: no hardware is opened
        bool isCrowded = false;      ///< no place was free
        bool isReported = false;     ///< a report is due because it was meant to play
        bool isArrayRefused = false; ///< the user's grants refused it and have logged this
    };
    struct Places
    {
        Eigen::Isometry3d worldToArray = Eigen::Isometry3d::Identity(); ///< world in metres
        Eigen::Matrix4d toArray = Eigen::Matrix4d::Identity();          ///< world in scene units
        osg::Matrixd ofRoot;   ///< world of the first root of the last frame
        std::size_t roots = 0; ///< of the last frame
    };
    /// State that rests() reads in every frame, usually from a cold cache: kept in one cache line.
    struct alignas(64) Rest
    {
        /// number of computations of the bound, also in a cull traversal
        std::atomic<unsigned int> bounds{0};
        bool isBoundKnown = true;     ///< in the last rests()
        unsigned int boundsSeen = 0;  ///< value of bounds in the last update()
        unsigned int changesSeen = 0; ///< value of propertyChanges() then
        /// something was submitted, nothing waits, and there is no hand or head source
        bool possible = false;
        std::atomic<bool> isNow{false}; ///< of the last frame
        double lookTime_s = 0.0;        ///< time of the last update()
        double submitTime_s = 0.0;
        std::atomic<std::uint64_t> frames{0}; ///< number of frames at rest
    };
    /// State for other threads.
    struct Shown
    {
        mutable midair::base::Mutex mutex;
        /// counters of the collection
        HapticStatistics collected MIDAIR_GUARDED_BY(mutex);
        /// current touches
        std::vector<Touch> touches MIDAIR_GUARDED_BY(mutex);
    };

    /// The last result asked for, and its public form.
    struct Newest
    {
        midair::base::Mutex mutex;
        std::shared_ptr<const midair::bridge::HologramResult> result MIDAIR_GUARDED_BY(mutex);
        osg::ref_ptr<const HapticField> field MIDAIR_GUARDED_BY(mutex);
    };

    std::string name() const;
    bool isPlayedByOuterOwner();
    bool takePlace(bool isEnabled);
    void openHands(const HapticSettings& settings);
    void attachMouse();
    void takePresses();
    void listen(Eigen::Matrix3Xd& ears, bool hasHead) const;
    bool findCamera(Eigen::Isometry3d& head) const;
    void tellTouches();
    bool collect(const std::vector<SceneRoot>& roots);
    void fillSnapshot(midair::bridge::SceneSnapshot& snapshot, double metresPerUnit) const;
    void fillSnapshot(unsigned int frame, double time_s, double simulationTime_s);
    void addRealThings(midair::bridge::SceneSnapshot& snapshot) const;
    void countCollected(int beingRead);
    void countTime(double start_s);
    HapticSettings granted(std::vector<midair::base::Message>& messages) const;
    HapticSettings usable(std::vector<midair::base::Message>& messages);
    HapticSettings solvable();
    midair::bridge::SceneSolve solveInput(const SceneRoot& root);
    bool setPlaces(const HapticSettings& settings);
    void collectWhole(const SceneRoot& root, std::vector<midair::bridge::HapticObject>& objects);
    midair::device::UserCaps innerLimits();
    static osg::ref_ptr<const HapticField>
    publicForm(std::shared_ptr<const midair::bridge::HologramResult> result);
    void configure(const HapticSettings& given);
    midair::bridge::PlayedOn playedOn(const HapticSettings& settings) const;
    void keepInnerLimits();
    void tellState();
    void tellMessages();
    void tellField();

    osg::observer_ptr<osg::Node> _root;
    Ownership _ownership;
    Lead _lead;
    Given _given;
    Settings _settings;
    Followed _followed;
    SceneCollector _collector;
    Places _places;
    TouchTeller _touches;
    Rest _rest;
    Told _told;
    const midair::base::MadeHere _isOurs;
    midair::base::OfProcess<Shown> _shown;
    midair::base::OfProcess<Newest> _newest;
    /// last member: its messages refer to those above
    midair::base::OfProcess<midair::bridge::ScenePlayer> _player;
};

} // namespace osgMidair
