#include "plugin/engine/HapticEngine.h"

#include <osg/Camera>
#include <osg/Notify>
#include <osg/Timer>
#include <osg/Transform>
#include <osg/observer_ptr>
#include <osgViewer/Scene>
#include <osgViewer/View>
#include <osgViewer/ViewerBase>
#include <osgViewer/ViewerEventHandlers>

#include <algorithm>
#include <utility>
#include <vector>

namespace osgMidair
{

namespace
{

struct Line
{
    const char* label;
    const char* attribute;
    double HapticStatistics::*value;
    float multiplier;
};

constexpr Line kLines[] = {
    {"Haptic collect ms", "Haptic collect", &HapticStatistics::collect_ms, 1.0f},
    {"Haptic solve ms", "Haptic solve", &HapticStatistics::solve_ms, 1.0f},
    {"Haptic updates/s", "Haptic updates", &HapticStatistics::updatesPerSecond, 1.0f},
    {"Haptic rms %", "Haptic rms", &HapticStatistics::rms, 100.0f},
    {"Haptic latency ms", "Haptic latency", &HapticStatistics::latency_ms, 1.0f}};

/// Writes the figures of a haptic scene into a viewer's statistics and makes the viewer's `s`
/// display show them.
class ViewerStatistics
{
public:
    /// Writes the figures of frame \a frame; costs nothing while the viewer collects no statistics.
    void show(osgViewer::ViewerBase& viewer,
              const osgViewer::ViewerBase::Views& views,
              const HapticEngine& engine,
              unsigned int frame)
    {
        // The display reads the lines when it is first switched on, so they have to be added
        // before.
        if (!_linesAdded) addLines(views);
        osg::Stats* stats = viewer.getViewerStats();
        _collecting = stats && stats->collectStats("frame_rate");
        if (!_collecting) return;
        const HapticStatistics now = engine.statistics();
        for (const Line& line : kLines)
            stats->setAttribute(frame, line.attribute, now.*line.value);
    }

    bool collecting() const { return _collecting; }

private:
    void addLines(const osgViewer::ViewerBase::Views& views)
    {
        _linesAdded = true;
        const osg::Vec4 color(0.6f, 1.0f, 0.8f, 1.0f);
        for (osgViewer::View* view : views)
            for (const auto& handler : view->getEventHandlers())
            {
                auto* display = dynamic_cast<osgViewer::StatsHandler*>(handler.get());
                if (!display) continue;
                for (const Line& line : kLines)
                    display->addUserStatsLine(line.label,
                                              color,
                                              color,
                                              line.attribute,
                                              line.multiplier,
                                              false,
                                              false,
                                              "",
                                              "",
                                              0.0f);
            }
    }

    bool _linesAdded = false;
    bool _collecting = false;
};

/// Finds a node below another one through active children only. Visits only ancestors of the node.
class ActivePathFinder : public osg::NodeVisitor
{
public:
    explicit ActivePathFinder(osg::Node& target) :
        osg::NodeVisitor(NODE_VISITOR, TRAVERSE_ACTIVE_CHILDREN),
        _target(target)
    {
        addAncestors(target);
        std::sort(_ancestors.begin(), _ancestors.end());
    }

    bool find(osg::Node& root)
    {
        _world.makeIdentity();
        root.accept(*this);
        return _found;
    }

    /// Transform from the frame of the target's parent to the world.
    const osg::Matrixd& world() const { return _foundWorld; }

    void apply(osg::Node& node) override
    {
        if (_found) return;
        if (&node == &_target)
        {
            _found = true;
            _foundWorld = _world;
        }
        else if (std::binary_search(_ancestors.begin(), _ancestors.end(), &node))
            traverse(node);
    }

    void apply(osg::Transform& node) override
    {
        if (&node == &_target)
        {
            // The target's own matrix is not part of its parent's transform.
            apply(static_cast<osg::Node&>(node));
            return;
        }
        const osg::Matrixd outer = _world;
        // Cameras between the view's own and the scene belong to the image, not to the world.
        if (!node.asCamera()) node.computeLocalToWorldMatrix(_world, this);
        apply(static_cast<osg::Node&>(node));
        _world = outer;
    }

private:
    void addAncestors(const osg::Node& node)
    {
        for (unsigned int i = 0; i < node.getNumParents(); ++i)
        {
            const osg::Node* parent = node.getParent(i);
            if (std::find(_ancestors.begin(), _ancestors.end(), parent) != _ancestors.end())
                continue;
            _ancestors.push_back(parent);
            addAncestors(*parent);
        }
    }

    osg::Node& _target;
    std::vector<const osg::Node*> _ancestors;
    osg::Matrixd _world;
    osg::Matrixd _foundWorld;
    bool _found = false;
};

/// Returns true if \a target is active below \a root; \a world is then the transform of its parent.
bool findActive(osg::Node& target, osg::Node& root, osg::Matrixd& world)
{
    if (&target == &root) return root.getNodeMask() != 0; // the usual case
    ActivePathFinder finder(target);
    const bool found = finder.find(root);
    world = finder.world();
    return found;
}

double secondsSince(const osgViewer::View& view, const osg::FrameStamp& stamp)
{
    const osg::Timer& timer = *osg::Timer::instance();
    const double age_s =
        timer.delta_s(view.getStartTick(), timer.tick()) - stamp.getReferenceTime();
    // An application may stamp its frames by its own clock.
    return age_s >= 0.0 && age_s < 1.0 ? age_s : 0.0;
}

/// Operation that runs right after a viewer's update traversal, when all matrices are up to date.
class CollectOperation : public osg::Operation
{
public:
    CollectOperation(osgViewer::ViewerBase& viewer, HapticEngine& engine) :
        osg::Operation("osgMidair collect", true),
        _viewer(&viewer),
        _engine(&engine)
    {
    }

    bool follows(const osgViewer::ViewerBase& viewer) const { return _viewer == &viewer; }

    void operator()(osg::Object*) override
    {
        osg::ref_ptr<HapticEngine> engine;
        osg::ref_ptr<osg::Node> root;
        if (_engine.lock(engine)) root = engine->root();
        if (!root)
        {
            setKeep(false);
            return;
        }
        const bool isMine = engine->collectedBy() == this;
        const bool isOthers = !isMine && engine->collectedBy();
        const bool isLed = isOthers || engine->isLed(*root, _visitsSeen);
        engine->findGuests(_guests);
        _viewer->getViews(_views);
        const bool isPlain = isLed && _guests.empty() && !_statistics.collecting();
        if (_direct && isPlain && isShownAlone(*root) && engine->rests(*root)) return;
        const osgViewer::View* view = isLed ? addRoot(*root) : nullptr;
        _direct = view && view->getSceneData() == root;
        for (const osg::ref_ptr<HapticEngine>& guest : _guests)
        {
            const osg::ref_ptr<osg::Node> other = guest->root();
            const osgViewer::View* where = other ? addRoot(*other) : nullptr;
            if (!view) view = where;
        }
        if (view)
        {
            engine->setCollectedBy(this);
            const osg::FrameStamp* stamp = view->getFrameStamp();
            engine->update(_roots,
                           stamp ? stamp->getFrameNumber() : 0,
                           stamp ? secondsSince(*view, *stamp) : 0.0,
                           stamp ? stamp->getSimulationTime() : 0.0);
            _statistics.show(*_viewer, _views, *engine, stamp ? stamp->getFrameNumber() : 0);
        }
        else if (isMine)
            leave(*engine, isLed);
        _collected = view != nullptr;
        _roots.clear();
        _guests.clear();
    }

protected:
    // The viewer is gone or no longer needs this, and nothing else would silence the array.
    ~CollectOperation() override
    {
        osg::ref_ptr<HapticEngine> engine;
        if (!_engine.lock(engine) || engine->collectedBy() != this) return;
        engine->setCollectedBy(nullptr);
        engine->silence();
    }

private:
    // The roots were removed or switched off, or have no leader. Silences only if this viewer
    // collected them last, because another one may show them.
    void leave(HapticEngine& engine, bool isLed) const
    {
        if (_collected) engine.silence();
        // Frees the device if there is no leader, and the playing place if others wait for one.
        if (!isLed || PlayingPlace::isWanted()) engine.close();
    }

    /// Returns true if a view shows \a root itself.
    bool isShownAlone(const osg::Node& root) const
    {
        return root.getNodeMask() != 0 && std::any_of(_views.begin(),
                                                      _views.end(),
                                                      [&root](const osgViewer::View* view)
                                                      { return view->getSceneData() == &root; });
    }

    /// Collects \a root, too, if a view shows it; returns that view, or null.
    const osgViewer::View* addRoot(osg::Node& root)
    {
        for (osgViewer::View* view : _views)
        {
            osg::Node* const shown = view->getSceneData();
            osg::Matrixd world;
            if (!shown || !findActive(root, *shown, world)) continue;
            _roots.push_back({&root, world});
            return view;
        }
        return nullptr;
    }

    osgViewer::ViewerBase* const _viewer; ///< owns this operation
    osg::observer_ptr<HapticEngine> _engine;
    osgViewer::ViewerBase::Views _views;
    std::vector<osg::ref_ptr<HapticEngine>> _guests; ///< kept to reuse memory, empty
    std::vector<SceneRoot> _roots;                   ///< likewise
    ViewerStatistics _statistics;
    bool _collected = false;      ///< in the last frame
    bool _direct = false;         ///< and a view showed the root itself
    unsigned int _visitsSeen = 0; ///< of the engine's owner
};

/// Returns the viewer's view whose camera is above \a node; null if there is none. \a seen: the
/// nodes visited, to visit each once.
osgViewer::View* viewAbove(const osg::Node& node, std::vector<const osg::Node*>& seen)
{
    for (unsigned int i = 0; i < node.getNumParents(); ++i)
    {
        const osg::Group* parent = node.getParent(i);
        if (std::find(seen.begin(), seen.end(), parent) != seen.end()) continue;
        seen.push_back(parent);
        auto* camera = const_cast<osg::Camera*>(parent->asCamera());
        auto* view = camera ? dynamic_cast<osgViewer::View*>(camera->getView()) : nullptr;
        if (!view || !view->getViewerBase()) view = viewAbove(*parent, seen);
        if (view) return view;
    }
    return nullptr;
}

} // namespace

osgGA::GUIActionAdapter* HapticEngine::followAbove(const osg::Node& node)
{
    if (_followed.adapter && _followed.view.valid() &&
        _followed.view->getViewerBase() == _followed.viewer)
        return nullptr;
    std::vector<const osg::Node*> seen;
    osgGA::GUIActionAdapter* view = viewAbove(node, seen);
    return view && follow(view) ? view : nullptr;
}

bool HapticEngine::follow(osgGA::GUIActionAdapter* adapter)
{
    // Called with every event. A view may be deleted and a new one created at its address, or it
    // may move to another viewer.
    if (adapter == _followed.adapter && _followed.view.valid() &&
        _followed.view->getViewerBase() == _followed.viewer)
        return false;
    auto* view = dynamic_cast<osgViewer::View*>(adapter);
    if (!view || !view->getViewerBase()) return false;
    _followed.adapter = adapter;
    _followed.view = view;
    _followed.viewer = view->getViewerBase();
    follow(*_followed.viewer);
    return true;
}

void HapticEngine::follow(osgViewer::ViewerBase& viewer)
{
    _ownership.joined.follow(viewer);
    for (const auto& follower : _followed.operations)
    {
        const auto* collect = dynamic_cast<const CollectOperation*>(follower.get());
        if (collect && collect->follows(viewer)) return;
    }
    osg::ref_ptr<osg::Operation> operation = new CollectOperation(viewer, *this);
    viewer.addUpdateOperation(operation);
    _followed.operations.emplace_back(operation);
}

// Returns true if another owner plays the scene. This engine then closes its device and hands.
bool HapticEngine::isPlayedByOuterOwner()
{
    std::string outer = _ownership.owner.outer();
    const osg::ref_ptr<HapticEngine> beside = outer.empty() ? host() : nullptr;
    if (beside) outer = beside->name();
    const bool isNew = outer != _ownership.outer;
    _ownership.outer = std::move(outer);
    const midair::base::Topic inside{midair::base::MessageCode::SCENE_INSIDE};
    if (isNew) _player->log().ends(inside);
    if (isNew && !_ownership.outer.empty() && _player->log().begins(inside))
        _player->log().say(inside,
                           {inside.code,
                            name() + (beside ? " is joined with " : " is inside ") +
                                _ownership.outer +
                                ", which plays it; it uses only its own caps and Enabled"});
    if (!_ownership.outer.empty())
        close();
    else if (isNew)
        _settings.isRead = false;
    return !_ownership.outer.empty();
}

bool HapticEngine::isLed(const osg::Node& root, unsigned int& visitsSeen)
{
    if (_ownership.kind == OwnerKind::SCENE) return true;
    const unsigned int visits = _lead.visits;
    const bool isLed =
        std::exchange(visitsSeen, visits) != visits || !_lead.isInPlace || _lead.isInPlace(root);
    _ownership.owner.setLed(isLed);
    return isLed;
}

void HapticEngine::close()
{
    _settings.isRead = false;
    lookNext();
    if (_player->close())
    {
        _collector.forget();
        tellTouches();
        tellState();
    }
    if (_player->isClosed()) _ownership.place.leave();
}

} // namespace osgMidair
