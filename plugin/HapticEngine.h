#pragma once

#include "CollectHapticSurfacesVisitor.h"
#include "HandTracker.h"
#include "LatencyStatistics.h"
#include "TaggedObstacles.h"
#include "engine-bridge/HologramThread.h"
#include "engine-bridge/MeshCache.h"
#include "engine-bridge/MessageLog.h"

#include <osgMidair/HapticSettings>
#include <osgMidair/HapticStatistics>

#include <osg/OperationThread>
#include <osg/Referenced>
#include <osg/observer_ptr>

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
class ViewerBase;
}

namespace osgMidair
{

/// What a HapticScene does: collects what is under a root into snapshots, hands them to a hologram thread, keeps the books.
///
/// update() and silence() belong to the thread that updates the scene; the rest may be called from any.
class HapticEngine : public osg::Referenced
{
public:
    /// \a root and \a settings are looked at as long as \a root lives.
    HapticEngine(osg::Node* root, const HapticSettings* settings);

    /// Where nothing under the root is haptic, the whole of it is felt so.
    void setDefaultProperty(const HapticProperty& property) { _default = property; }

    /// Changes what the settings come to, before each new pipeline: an application's own solver or device, limits.
    void setOptionsFilter(std::function<void(midair::bridge::HologramOptions&)> filter)
    {
        _filter = std::move(filter);
    }

    /// Follows the viewer behind \a adapter from now on: update() runs after each of its update traversals, once a frame
    /// however many of its views show the root; silent while none does. Without an osgViewer nothing happens.
    void follow(osgGA::GUIActionAdapter* adapter);
    void follow(osgViewer::ViewerBase& viewer);

    /// Null when the root is gone.
    osg::ref_ptr<osg::Node> root() const;

    /// Tags under the root are looked for with the next update, not only every kTagFrames frames.
    void dirtyTags() { _tagFrame = 0; }
    static constexpr unsigned int kTagFrames = 60;

    /// One frame: what is active under the root, whose parent is at \a world, is to be felt from now on.
    /// \a age_s: seconds since the frame's stamp. Touch callbacks are called last.
    void
    update(const osg::Matrixd& world, unsigned int frame, double age_s, double simulationTime_s);

    /// Of the update thread.
    HandTracker& hands() { return _hands; }

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
    /// What is remembered of an instance from frame to frame.
    struct Known
    {
        osg::observer_ptr<osg::Node> node;
        std::string path;
        std::string tag;
        HapticProperty raw;      ///< as the node has it
        HapticProperty property; ///< with what was out of range repaired
        unsigned int seen = 0;
    };

    void tellTouches();
    void collect(osg::Node& root, const osg::Matrixd& world);
    void fillObstacle(const HapticInstance& instance);
    void configure(const HapticSettings& settings);
    void startThread();
    Known& know(const HapticInstance& instance, bool& fresh);
    void fill(const HapticInstance& instance);
    void
    fillPart(std::uint64_t instance, const Known& known, const midair::bridge::CachedMesh& part);
    bool changedSinceSubmitted() const;
    void submit();
    void takeResult();
    void say(const std::string& message);

    osg::observer_ptr<osg::Node> _root;
    const HapticSettings* const _given; ///< valid while _root is
    std::optional<HapticProperty> _default;
    std::function<void(midair::bridge::HologramOptions&)> _filter;
    std::vector<osg::observer_ptr<osg::Operation>> _followers; ///< in viewers
    unsigned int _tagFrame = 0;                                ///< frames until tags are looked for
    CollectHapticSurfacesVisitor _collector;
    midair::bridge::MeshCache _meshes;
    midair::bridge::ExtractOptions _extract;
    HandTracker _hands;
    TaggedObstacles _obstacles;
    std::unordered_map<std::uint64_t, Known> _known;
    std::vector<std::string> _warnings;
    std::vector<midair::bridge::CachedMesh> _parts;       ///< of the instance being filled in
    midair::bridge::SceneSnapshot _snapshot;              ///< being filled
    std::vector<midair::bridge::HapticObject> _submitted; ///< as last handed over
    midair::bridge::Surroundings _submittedAround;
    std::size_t _objects = 0; ///< filled into _snapshot: parts of instances
    int _instances = 0;       ///< that can be felt
    unsigned int _frame = 0;
    bool _submittedAny = false;
    double _submitTime_s = 0.0;
    Eigen::Isometry3d _worldToArray = Eigen::Isometry3d::Identity(); ///< world in metres -> array
    Eigen::Matrix4d _toArray = Eigen::Matrix4d::Identity(); ///< world in scene units -> array
    HapticSettings _settings;                               ///< as configured, repaired
    HapticSettings _raw;                                    ///< as given
    bool _configured = false;

    mutable std::mutex _mutex; ///< of what follows
    std::unique_ptr<midair::bridge::HologramThread> _thread;
    std::shared_ptr<const midair::haptics::TransducerArray> _array;
    midair::haptics::Medium _medium;
    midair::bridge::MessageLog _messages;
    HapticStatistics _statistics; ///< the engine's own share
    LatencyStatistics _latencies;
    std::shared_ptr<const midair::bridge::HologramResult> _seen;
};

} // namespace osgMidair
