#pragma once

#include "engine-bridge/pipeline/HologramThread.h"
#include "haptics/base/text/MessageLog.h"
#include "plugin/engine/LatencyStatistics.h"
#include "plugin/engine/SceneOwners.h"
#include "plugin/hands/HandTracker.h"
#include "plugin/scene/SceneCollector.h"

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

namespace osgMidair
{

class HapticScene;

/// What a HapticScene does: collects what is under a root into snapshots, hands them to a hologram
/// thread, keeps the books.
///
/// update() and silence() belong to the thread that updates the scene; the rest may be called from
/// any.
class HapticEngine : public osg::Referenced
{
public:
    /// \a root, a HapticScene or a node with another owner, and \a settings are looked at as long
    /// as \a root lives. Where an owner is further out it opens nothing: that one plays what is
    /// under \a root.
    HapticEngine(osg::Node& root, const HapticSettings& settings, OwnerKind kind);

    /// Where nothing under the root is haptic, the whole of it is felt so.
    void setDefaultProperty(const HapticProperty& property)
    {
        _collector.setDefaultProperty(property);
    }

    /// Changes what the settings come to, before each new pipeline: an application's own solver or
    /// device, limits.
    void setOptionsFilter(std::function<void(midair::bridge::HologramOptions&)> filter)
    {
        _filter = std::move(filter);
    }

    /// Follows the viewer behind \a adapter from now on: update() runs after each of its update
    /// traversals, once a frame however many of its views show the root; silent while none does.
    /// Without an osgViewer nothing happens. False when \a adapter is the one of the last call:
    /// nothing to do.
    bool follow(osgGA::GUIActionAdapter* adapter);
    void follow(osgViewer::ViewerBase& viewer);

    /// Null when the root is gone.
    osg::ref_ptr<osg::Node> root() const;

    /// Tags under the root are looked for with the next update.
    void dirtyTags()
    {
        _collector.dirtyTags();
        lookNext();
    }

    /// Whether there is nothing to do in this frame, which counts as one then: for kRest_s nothing
    /// has changed, less than kLook_s ago everything was looked at, and the bound of \a root says
    /// that since then nothing under it has moved. Changes that no bound shows (masks, vertices,
    /// properties) are seen with the next look. Only for a root that calls noteBound() whenever its
    /// bound is made, and that no transform is above.
    bool rests(const osg::Node& root);
    void noteBound() { ++_rest.bounds; }
    static constexpr double kRest_s = 0.5;
    static constexpr double kLook_s = 0.1;

    /// One frame: what is active under \a root, the engine's own, whose parent is at \a world, is
    /// to be felt from now on. \a age_s: seconds since the frame's stamp. Touch callbacks are
    /// called last.
    void update(osg::Node& root,
                const osg::Matrixd& world,
                unsigned int frame,
                double age_s,
                double simulationTime_s);

    /// Of the update thread.
    HandTracker& hands() { return _hands; }

    /// The next frame looks at everything, at rest or not.
    void lookNext() { _rest.lookTime_s = 0.0; }

    /// Nothing is to be felt.
    void silence();

    std::shared_ptr<const midair::bridge::HologramResult> latestResult() const;
    HapticStatistics statistics() const;
    std::shared_ptr<const midair::haptics::TransducerArray> array() const;
    midair::haptics::Medium medium() const;

protected:
    ~HapticEngine()
        override; ///< the array is silent when it returns; writes the report if one is asked for

private:
    /// An array that the hologram thread loads.
    struct LoadedArray
    {
        std::mutex mutex;
        std::shared_ptr<const midair::haptics::TransducerArray> array;
    };

    std::string name() const;
    bool standsBack();
    void openHands();
    void tellTouches();
    bool collect(osg::Node& root, const osg::Matrixd& world);
    void configure(const HapticSettings& settings);
    void readSettings(const HapticSettings& given);
    void keepInnerLimits();
    midair::bridge::HologramOptions hologramOptions() const;
    void startThread();
    /// \a objectsToo: they may have; else only what is around them is compared.
    bool changedSinceSubmitted(bool objectsToo) const;
    void submit();
    void takeResult();
    void say(const std::string& message);

    osg::observer_ptr<osg::Node> _root;
    const SceneOwner _owner;
    const OwnerKind _kind;
    const HapticSettings* const _given; ///< valid while _root is
    std::function<void(midair::bridge::HologramOptions&)> _filter;
    std::vector<osg::observer_ptr<osg::Operation>> _followers; ///< in viewers
    osgGA::GUIActionAdapter* _adapter = nullptr;               ///< of the last follow(): _view
    osg::observer_ptr<osgViewer::View> _view;
    osgViewer::ViewerBase* _viewer = nullptr; ///< then that of _view
    SceneCollector _collector;
    HandTracker _hands;
    midair::bridge::SceneSnapshot _snapshot;              ///< being filled
    std::vector<midair::bridge::HapticObject> _submitted; ///< as last handed over
    midair::bridge::HandsAndObstacles _submittedAround;
    bool _submittedAny = false;
    std::uint64_t _resultsSeen = 0;
    /// What rests() asks in every frame, when no cache holds any of it: in one line of memory.
    struct alignas(64) Rest
    {
        std::atomic<unsigned int> bounds{0}; ///< made; a cull may do that
        unsigned int boundsSeen = 0;         ///< by the last update()
        bool possible = false;               ///< something was submitted, and no hand may come
        double lookTime_s = 0.0;             ///< of the last update()
        double submitTime_s = 0.0;
        std::atomic<std::uint64_t> frames{0}; ///< that rested
    };
    Rest _rest;
    Eigen::Isometry3d _worldToArray = Eigen::Isometry3d::Identity(); ///< world in metres -> array
    Eigen::Matrix4d _toArray = Eigen::Matrix4d::Identity(); ///< world in scene units -> array
    HapticSettings _settings;                               ///< as configured, repaired
    HapticSettings _raw;                                    ///< as given
    bool _configured = false;
    bool _isStale = true; ///< the thread's pipeline is one of other settings, or there is none
    std::string _outer;   ///< what plays this scene in its place
    double _innerPressure_Pa = 0.0; ///< the strictest cap of scenes inside this one; 0: none
    double _innerAmplitude = 1.0;

    mutable std::mutex _mutex; ///< of what follows
    std::unique_ptr<midair::bridge::HologramThread> _thread;
    std::shared_ptr<LoadedArray> _array;
    midair::haptics::Medium _medium;
    midair::base::MessageLog _messages;
    HapticStatistics _statistics; ///< the engine's own share
    LatencyStatistics _latencies;
    std::shared_ptr<const midair::bridge::HologramResult> _seen;
};

} // namespace osgMidair
