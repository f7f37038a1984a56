#include "plugin/engine/HapticEngine.h"

#include "engine-bridge/scene/Convert.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/settings/Setting.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/engine/PublicMessage.h"
#include "plugin/hands/KitHands.h"
#include "plugin/hands/MouseSource.h"
#include "plugin/report/Report.h"
#include "plugin/settings/Grants.h"
#include "plugin/settings/PropertyChanges.h"

#include <osg/Notify>
#include <osgViewer/View>

#include <algorithm>
#include <utility>

namespace osgMidair
{

using midair::base::Message;
using midair::base::MessageCode;

namespace
{

void notify(const midair::bridge::SceneMessages::Line& line)
{
    const bool isNotice = line.severity == midair::base::Severity::NOTICE;
    osg::notify(isNotice ? osg::NOTICE : osg::WARN) << "osgMidair: " << line.text << std::endl;
}

} // namespace

HapticEngine::HapticEngine(osg::Node& root, const HapticSettings& settings, OwnerKind kind) :
    osg::Referenced(true),
    _root(&root),
    _ownership{
        SceneOwner(root, kind, *this), JoinedScene(*this), PlayingPlace(), kind, std::string()},
    _given{&settings, nullptr, {}},
    _collector(kind == OwnerKind::SCENE ? &root : nullptr,
               [this](const Message& message) { say(message); }),
    _player({notify, openSceneHands})
{
    collectDeviceLines();
}

HapticEngine::~HapticEngine()
{
    _player.takeResult();
    _player.messages().printDue(midair::base::steadySeconds() + midair::base::LineLimit::kPause_s);
    const ReportedScene last{
        statistics(), _settings.used ? *_settings.used : HapticSettings(), field()};
    _player.end().reset(); // waits for the device
    tellDeviceLines();
    if (_settings.isReported) writeReport(this, last);
}

osg::ref_ptr<osg::Node> HapticEngine::root() const
{
    osg::ref_ptr<osg::Node> node;
    _root.lock(node);
    return node;
}

// Returns false if the objects are the same as in the last frame. What the snapshot held before
// says nothing of that: it is an older one once another has been handed over.
bool HapticEngine::collect(const std::vector<SceneRoot>& roots)
{
    if (mayPlay()) return _collector.collect(roots, _player.snapshot().objects);
    _collector.forget();
    _player.snapshot().objects.clear();
    return true;
}

bool HapticEngine::rests(const osg::Node& root)
{
    if (!_rest.possible) return false;
    root.getBound(); // recomputed if something below has moved
    const double now_s = midair::base::steadySeconds();
    if (_rest.bounds == 0 || _rest.bounds != _rest.boundsSeen ||
        _rest.changesSeen != propertyChanges() || !(*_given.settings == _settings.seen) ||
        now_s - _rest.submitTime_s < kRest_s || now_s - _rest.lookTime_s > kLook_s)
        return false;
    ++_rest.frames;
    _player.rest();
    return true;
}

void HapticEngine::fillSnapshot(unsigned int frame, double time_s, double simulationTime_s)
{
    midair::bridge::SceneSnapshot& snapshot = _player.snapshot();
    snapshot.frame = frame;
    snapshot.time_s = time_s;
    snapshot.metresPerUnit = settings().metresPerUnit;
    snapshot.simulationTime_s = simulationTime_s;
    snapshot.worldToArray = _places.toArray;
    std::vector<midair::bridge::Capsule>& props = snapshot.around.props;
    props.clear();
    for (const Obstacle& obstacle : _given.obstacles)
        props.push_back({_places.worldToArray * midair::bridge::toEigen(obstacle.a),
                         _places.worldToArray * midair::bridge::toEigen(obstacle.b),
                         obstacle.radius});
    if (mayPlay()) _collector.addObstacles(props);
}

void HapticEngine::update(const std::vector<SceneRoot>& roots,
                          unsigned int frame,
                          double age_s,
                          double simulationTime_s)
{
    const double start_s = midair::base::steadySeconds();
    _rest.lookTime_s = start_s;
    _rest.boundsSeen = _rest.bounds;
    _rest.changesSeen = propertyChanges();
    tellDeviceLines();
    _player.messages().printDue(start_s);
    if (isPlayedByOuterOwner()) return tellState();
    if (_settings.isCrowded && _ownership.place.take())
        _settings.isRead = false; // there is one now
    configure(*_given.settings);
    const bool isFresh = collect(roots);
    keepInnerLimits();
    fillSnapshot(frame, start_s - age_s, simulationTime_s);
    attachMouse();
    listenAtCamera();
    const bool isHead = _player.snapshot().ears.cols() > 0;
    const int beingRead = mayPlay() ? _collector.beingRead() : 0;
    if (_player.play(_places.worldToArray, isFresh))
        _collector.forget(); // the snapshot now holds the objects of an older one
    _rest.submitTime_s = _player.submitted_s();
    _rest.possible =
        _player.hasSubmitted() && !_player.hands().active() && beingRead == 0 && !isHead;
    countCollected(beingRead, start_s);
    if (_settings.isReported && isReportDue(this))
        keepReport(this, {statistics(), settings(), field()});
    tellTouches();
    tellState();
}

void HapticEngine::countCollected(int beingRead, double start_s)
{
    const midair::base::Lock lock(_shown.mutex);
    _shown.collected.meshesRead = _collector.extractions();
    _shown.collected.objectsBeingRead = beingRead;
    _shown.collected.objects = mayPlay() ? _collector.instances() : 0;
    _shown.collected.collect_ms = (midair::base::steadySeconds() - start_s) * 1e3;
}

void HapticEngine::tellTouches()
{
    const midair::bridge::HandProximity& touched = _player.hands().proximity();
    if (touched.events().empty() && touched.ongoing().empty()) return;
    const Eigen::Affine3d arrayToScene(Eigen::Matrix4d(_places.toArray.inverse()));
    const auto told = _touches.gather(
        touched, [this](std::uint64_t id) { return _collector.nodeOf(id); }, arrayToScene);
    {
        const midair::base::Lock lock(_shown.mutex);
        _shown.touches = _touches.current();
    }
    for (Message& message : _touches.tell(told))
        say(std::move(message));
}

// A callback may do anything, so this comes last.
void HapticEngine::tellState()
{
    DeviceChange change;
    change.before = _told.state;
    change.now = _player.state();
    if (change.now == change.before) return;
    _told.state = change.now;
    change.status = _player.deviceStatus();
    const auto isTrouble = [](ArrayState state)
    { return state == ArrayState::LOST || state == ArrayState::FAULT; };
    const bool isNews = isTrouble(change.before) || isTrouble(change.now);
    osg::notify(isNews ? osg::NOTICE : osg::INFO)
        << "osgMidair: the array is " << midair::bridge::stateName(change.now) << " (it was "
        << midair::bridge::stateName(change.before) << "): " << printable(change.status)
        << std::endl;
    const osg::ref_ptr<DeviceCallback> keep = _told.callback;
    if (!keep) return;
    const std::string thrown = midair::base::thrownBy([&] { keep->changed(change); });
    if (!thrown.empty())
        say({MessageCode::CALLBACK_THREW, "the device callback has thrown " + thrown});
}

void HapticEngine::silence()
{
    if (_player.isClosed()) return;
    _collector.forget();
    _player.silence();
    tellTouches();
    tellState();
}

void HapticEngine::setHandSource(HandSource* source)
{
    _given.hands = source;
    _player.setHandSource(source ? std::make_shared<KitHands>(source) : nullptr);
}

// The hand begins in the middle of the workspace.
void HapticEngine::attachMouse()
{
    auto* mouse = dynamic_cast<MouseSource*>(KitHands::of(_player.hands().active().get()));
    if (!mouse || !_followed.view.valid()) return;
    const Eigen::Vector3d middle = _places.toArray.inverse().topRightCorner<3, 1>();
    mouse->attach(*_followed.view, settings().metresPerUnit, midair::bridge::toOsg(middle));
}

// The camera's frame is the scene's world in its units, as that of the hands is.
void HapticEngine::listenAtCamera()
{
    constexpr double kEar_m = 0.08;
    Eigen::Matrix3Xd& ears = _player.snapshot().ears;
    ears.resize(3, 0);
    const osg::Camera* camera = _followed.view.valid() ? _followed.view->getCamera() : nullptr;
    if (!settings().earCamera || !camera) return;
    const osg::Matrixd toWorld = camera->getInverseViewMatrix();
    const Eigen::Affine3d toArray(_places.toArray);
    const Eigen::Vector3d eye = toArray * midair::bridge::toEigen(toWorld.getTrans());
    const osg::Vec3d right(toWorld(0, 0), toWorld(0, 1), toWorld(0, 2));
    const Eigen::Vector3d aside =
        kEar_m * (toArray.linear() * midair::bridge::toEigen(right)).stableNormalized();
    ears.resize(3, 2);
    ears << eye - aside, eye + aside;
}

std::string HapticEngine::name() const
{
    const osg::ref_ptr<osg::Node> node = root();
    std::string named = node && !node->getName().empty() ? " \"" + node->getName() + "\"" : "";
    const osg::Group* group = node && named.empty() ? node->asGroup() : nullptr;
    for (unsigned int i = 0; group && named.empty() && i < group->getNumChildren(); ++i)
        if (!group->getChild(i)->getName().empty())
            named = " with \"" + group->getChild(i)->getName() + "\"";
    return _ownership.kind == OwnerKind::SCENE
               ? (named.empty() ? "a HapticScene" : "the HapticScene" + named)
           : _ownership.kind == OwnerKind::CALLBACK ? "a HapticCallback"
                                                    : "the viewer's --device";
}

std::vector<Touch> HapticEngine::touches() const
{
    std::vector<Touch> touches;
    {
        const midair::base::Lock lock(_shown.mutex);
        touches = _shown.touches;
    }
    // It may have been muted or lost since the frame.
    if (_player.reading().state != ArrayState::PLAYING)
        for (Touch& touch : touches)
            touch.force = 0.0;
    return touches;
}

HapticStatistics HapticEngine::statistics() const
{
    HapticStatistics all;
    {
        const midair::base::Lock lock(_shown.mutex);
        all = _shown.collected;
    }
    midair::base::assignPart<midair::bridge::SceneStatistics>(all, _player.statistics());
    for (const Message& message : _player.messages().all())
        all.told.push_back(toPublic(message));
    all.restingFrames = _rest.frames;
    all.frames += all.restingFrames;
    all.idleFrames += all.restingFrames;
    return all;
}

} // namespace osgMidair
