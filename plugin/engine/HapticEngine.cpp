#include "plugin/engine/HapticEngine.h"

#include "device/DeviceUri.h"
#include "device/limits/GuardedDevice.h"
#include "device/opening/DeviceRegistry.h"
#include "device/opening/MultiDevice.h"
#include "engine-bridge/bodies/HandBodies.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/heads/HeadTracker.h"
#include "engine-bridge/scene/Convert.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/settings/Setting.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/extending/ArrayConversion.h"
#include "plugin/hands/KitHands.h"
#include "plugin/hands/MouseSource.h"
#include "plugin/heads/KitHead.h"
#include "plugin/heads/MouseHead.h"
#include "plugin/report/Report.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/Grants.h"
#include "plugin/settings/UserOptions.h"

#include <osgMidair/HapticScene>

#include <osg/Notify>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace osgMidair
{

using midair::base::Message;
using midair::base::MessageCode;

namespace
{

/// Returns an error text for \a device; empty: the program knows all its kinds.
std::string unknownDevice(const std::string& device)
{
    try
    {
        for (const std::string& one : midair::device::splitDeviceList(device))
        {
            const midair::device::DeviceUri uri(one);
            if (!midair::device::isKnownScheme(uri.scheme()))
                return uri.error("unknown kind \"" + uri.scheme() + ":\"").what();
        }
    }
    catch (const std::runtime_error& error)
    {
        return error.what();
    }
    return {};
}

void notify(const midair::base::MessageLog::Line& line)
{
    const bool isNotice = line.severity == midair::base::Severity::NOTICE;
    osg::notify(isNotice ? osg::NOTICE : osg::WARN) << "osgMidair: " << line.text << std::endl;
}

/// \a isFirst: false in the child of a fork, where nothing is opened.
std::unique_ptr<midair::bridge::ScenePlayer> makePlayer(bool isFirst)
{
    auto player = std::make_unique<midair::bridge::ScenePlayer>(
        midair::bridge::ScenePlayer::Host{notify, openSceneHands, {}, openSceneHead});
    if (isFirst) return player;
    player->keepClosed();
    player->log().say({MessageCode::SCENE_CLOSED, midair::base::kForked});
    return player;
}

/// Replaces hardware in \a settings: devices by the simulated one, tracked hands and heads by none.
/// Returns errors in their names, because nobody tries to open them.
std::vector<Message> rehearse(HapticSettings& settings)
{
    std::vector<Message> wrong;
    if (!Grants::isHarmlessDevice(settings.device))
    {
        const std::string why = unknownDevice(settings.device);
        if (!why.empty())
            wrong.emplace_back(MessageCode::DEVICE_OPEN, why + "; sim: is used instead");
        settings.device = "sim:";
    }
    if (!midair::bridge::RecordedUri::parse(settings.hands))
    {
        const std::string why = unknownSceneHands(settings.hands);
        if (!why.empty()) wrong.emplace_back(MessageCode::HANDS_OPEN, why);
        settings.hands.clear();
    }
    if (!midair::bridge::RecordedUri::parse(settings.heads) &&
        settings.heads.rfind("fixed ", 0) != 0)
    {
        const std::string why = unknownSceneHead(settings.heads);
        if (!why.empty()) wrong.emplace_back(MessageCode::HANDS_OPEN, why);
        settings.heads.clear();
    }
    return wrong;
}

// The tolerance of calibrate() for a tracker (CalibrationOptions::scaleTolerance); documented in
// HapticSettings.
constexpr double kCalibrationTolerance = 0.02;

/// Returns true if both or neither are requests, by the setting's row, with the same value beside
/// the same file.
bool haveSameWishes(const HapticWishes& a, const HapticWishes& b)
{
    bool isAny = false;
    for (const Setting<HapticSettings>& row : sceneSettings().rows())
    {
        if (!row.isWish || !(row.effect & midair::base::Effect::REOPEN)) continue;
        const auto own = a.asked.find(row.name);
        const auto theirs = b.asked.find(row.name);
        const bool isOwn = own != a.asked.end();
        if (isOwn != (theirs != b.asked.end())) return false;
        if (isOwn && own->second != theirs->second) return false;
        isAny = isAny || isOwn;
    }
    return !isAny || a.folder == b.folder;
}

} // namespace

HapticEngine::HapticEngine(osg::Node& root, const HapticSettings& settings, OwnerKind kind) :
    osg::Referenced(true),
    _root(&root),
    _ownership{
        SceneOwner(root, kind, *this), JoinedScene(*this), PlayingPlace(), kind, std::string()},
    _given{&settings, nullptr, nullptr, {}, {}, {}},
    _collector(kind == OwnerKind::SCENE ? &root : nullptr,
               [this]() -> midair::base::MessageLog& { return _player->log(); }),
    _shown([](bool) { return std::make_unique<Shown>(); }),
    _newest([](bool) { return std::make_unique<Newest>(); }),
    _player(makePlayer)
{
    collectDeviceLines();
}

HapticEngine::~HapticEngine()
{
    if (!_isOurs) return; // the parent plays on
    _player->takeResult();
    _player->log().printDue(midair::base::steadySeconds() + midair::base::MessageLog::kLinePause_s);
    const ReportedScene last{
        statistics(), _settings.used ? *_settings.used : HapticSettings(), field()};
    _player->end().reset(); // waits for the device
    tellDeviceLines();
    if (_settings.isReported) writeReport(this, last);
}

osg::ref_ptr<osg::Node> HapticEngine::root() const
{
    osg::ref_ptr<osg::Node> node;
    _root.lock(node);
    return node;
}

// Returns false if the objects are the same as in the last frame. The snapshot's previous content
// doesn't show that: it is older once another was handed over.
bool HapticEngine::collect(const std::vector<SceneRoot>& roots)
{
    if (mayPlay()) return _collector.collect(roots, _player->snapshot().objects);
    _collector.forget();
    _player->snapshot().objects.clear();
    return true;
}

bool HapticEngine::rests(const osg::Node& root)
{
    if (!_rest.possible) return false;
    const double now_s = midair::base::steadySeconds();
    if (_rest.changesSeen != propertyChanges() || now_s - _rest.submitTime_s < kRest_s ||
        now_s - _rest.lookTime_s > kLook_s || !(*_given.settings == _settings.seen))
        return false;
    // An unknown bound means that something has moved or that it was never computed. For many new
    // objects computing it takes longer than a frame; reading them does it step by step.
    struct Bound : osg::Node
    {
        using osg::Node::_boundingSphereComputed;
    };
    const bool isKnown = root.*&Bound::_boundingSphereComputed;
    const bool wasKnown = std::exchange(_rest.isBoundKnown, isKnown);
    if (!isKnown && wasKnown) return false;
    root.getBound();
    if (_rest.bounds == 0 || _rest.bounds != _rest.boundsSeen) return false;
    ++_rest.frames;
    _rest.isNow = true;
    _player->rest();
    return true;
}

bool HapticEngine::rests(const SceneRoot& root)
{
    return _places.roots == 1 && root.world == _places.ofRoot && rests(*root.node);
}

void HapticEngine::fillSnapshot(unsigned int frame, double time_s, double simulationTime_s)
{
    midair::bridge::SceneSnapshot& snapshot = _player->snapshot();
    snapshot.frame = frame;
    snapshot.time_s = time_s;
    snapshot.simulationTime_s = simulationTime_s;
    fillSnapshot(snapshot, settings().metresPerUnit);
    snapshot.reflectors.clear();
    snapshot.bodies.clear();
    if (mayPlay()) addRealThings(snapshot);
}

void HapticEngine::addRealThings(midair::bridge::SceneSnapshot& snapshot) const
{
    std::vector<midair::bridge::Capsule>& props = snapshot.around.props;
    props.insert(props.end(), _collector.obstacles().begin(), _collector.obstacles().end());
    snapshot.reflectors = _collector.reflectors();
    snapshot.bodies = _collector.bodies();
}

// The parts that depend on the pose, without hands and ears.
void HapticEngine::fillSnapshot(midair::bridge::SceneSnapshot& snapshot, double metresPerUnit) const
{
    snapshot.metresPerUnit = metresPerUnit;
    snapshot.worldToArray = _places.toArray;
    std::vector<midair::bridge::Capsule>& props = snapshot.around.props;
    props.clear();
    for (const Obstacle& obstacle : _given.obstacles)
        props.push_back({_places.worldToArray * midair::bridge::toEigen(obstacle.a),
                         _places.worldToArray * midair::bridge::toEigen(obstacle.b),
                         obstacle.radius});
}

void HapticEngine::update(const std::vector<SceneRoot>& roots,
                          unsigned int frame,
                          double age_s,
                          double simulationTime_s)
{
    if (!_isOurs) return;                         // the child of a fork: the parent plays on
    const osg::ref_ptr<HapticEngine> keep = this; // keeps the engine alive during callbacks
    const double start_s = midair::base::steadySeconds();
    _places.roots = roots.size();
    if (!roots.empty()) _places.ofRoot = roots.front().world;
    _rest.isNow = false;
    _rest.lookTime_s = start_s;
    _rest.boundsSeen = _rest.bounds;
    _rest.changesSeen = propertyChanges();
    tellDeviceLines();
    _player->log().printDue(start_s);
    if (isPlayedByOuterOwner())
    {
        countTime(start_s);
        return tellState();
    }
    if (_settings.isCrowded && _ownership.place.take())
        _settings.isRead = false; // there is one now
    configure(*_given.settings);
    const bool isFresh = collect(roots);
    keepInnerLimits();
    fillSnapshot(frame, start_s - age_s, simulationTime_s);
    attachMouse();
    takePresses();
    _player->locateHead(simulationTime_s);
    listen(_player->snapshot().ears, settings().earCamera);
    const bool isHead = settings().earCamera || _player->heads().active();
    const int beingRead = mayPlay() ? _collector.beingRead() : 0;
    _player->play(_places.worldToArray, isFresh);
    _rest.submitTime_s = _player->submitted_s();
    _rest.possible =
        _player->hasSubmitted() && !_player->hands().active() && beingRead == 0 && !isHead;
    countCollected(beingRead);
    countTime(start_s);
    if (_settings.isReported && isReportDue(this))
        keepReport(this, {statistics(), settings(), field()});
    tellTouches();
    tellState();
    tellField();
}

void HapticEngine::countCollected(int beingRead)
{
    const midair::base::Lock lock(_shown->mutex);
    _shown->collected.meshesRead = _collector.extractions();
    _shown->collected.objectsBeingRead = beingRead;
    _shown->collected.objects = mayPlay() ? _collector.instances() : 0;
}

void HapticEngine::countTime(double start_s)
{
    const midair::base::Lock lock(_shown->mutex);
    _shown->collected.collect_ms = (midair::base::steadySeconds() - start_s) * 1e3;
}

void HapticEngine::tellTouches()
{
    const midair::bridge::HandProximity& touched = _player->hands().proximity();
    if (touched.events().empty() && touched.ongoing().empty()) return;
    const Eigen::Affine3d arrayToScene(Eigen::Matrix4d(_places.toArray.inverse()));
    const auto told = _touches.gather(
        touched, [this](std::uint64_t id) { return _collector.nodeOf(id); }, arrayToScene);
    {
        const midair::base::Lock lock(_shown->mutex);
        _shown->touches = _touches.current();
    }
    for (Message& message : _touches.tell(told))
        say(std::move(message));
}

// A callback may do anything, so it is called last.
void HapticEngine::tellState()
{
    tellMessages();
    DeviceChange change;
    change.before = _told.state;
    const midair::bridge::ArrayReading reading = _player->reading();
    const bool isOpening = _player->state() == ArrayState::OPENING;
    change.now = isOpening ? ArrayState::OPENING : reading.state;
    if (change.now == change.before) return;
    _told.state = change.now;
    change.status = reading.status;
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

// A callback that throws gets no message about it, because it would throw again.
void HapticEngine::tellMessages()
{
    const osg::ref_ptr<MessageCallback> keep = _told.messageCallback;
    if (!keep) return;
    bool hasThrown = false;
    for (const Message& message : _player->log().changedSince(_told.messages))
    {
        const std::string thrown = midair::base::thrownBy([&] { keep->told(toPublic(message)); });
        if (thrown.empty()) continue;
        hasThrown = true;
        say({MessageCode::CALLBACK_THREW, "the message callback has thrown " + thrown});
    }
    if (hasThrown) _told.messages = _player->log().changes();
}

void HapticEngine::setMessageCallback(MessageCallback* callback)
{
    if (callback != _told.messageCallback.get()) _told.messages = 0;
    _told.messageCallback = callback;
}

void HapticEngine::silence()
{
    lookNext();
    if (_player->isClosed()) return;
    _collector.forget();
    _player->silence();
    tellTouches();
    tellState();
}

void HapticEngine::setHandSource(HandSource* source)
{
    _given.hands = source;
    _player->setHandSource(source ? std::make_shared<KitHands>(source) : nullptr);
}

void HapticEngine::setHeadSource(HeadSource* source)
{
    _given.head = source;
    _player->setHeadSource(source ? std::make_shared<KitHead>(source) : nullptr);
}

bool HapticEngine::head(Head& head) const
{
    const midair::bridge::Head& last = _player->heads().head();
    if (last.isTracked) head = fromBridge(last);
    return last.isTracked;
}

// The hand starts in the middle of the workspace, the head at the camera.
void HapticEngine::attachMouse()
{
    if (!_followed.view.valid()) return;
    if (auto* head = dynamic_cast<MouseHead*>(KitHead::of(_player->heads().active().get())))
        head->attach(*_followed.view, settings().metresPerUnit);
    auto* mouse = dynamic_cast<MouseSource*>(KitHands::of(_player->hands().active().get()));
    if (!mouse) return;
    const Eigen::Vector3d middle = _places.toArray.inverse().topRightCorner<3, 1>();
    mouse->attach(*_followed.view, settings().metresPerUnit, midair::bridge::toOsg(middle));
}

// Objects that the hands' bodies push count as touched, wherever Bullet keeps them.
void HapticEngine::takePresses()
{
    std::vector<midair::bridge::HandPress> presses;
    auto& all = _given.bodies;
    for (auto one = all.begin(); one != all.end();)
    {
        const std::shared_ptr<midair::bridge::HandBodies> bodies = one->lock();
        one = bodies ? std::next(one) : all.erase(one);
        if (!bodies) continue;
        const std::vector<midair::bridge::HandPress> its = bodies->presses();
        presses.insert(presses.end(), its.begin(), its.end());
    }
    _player->setPresses(std::move(presses));
}

// A lost head counts at its last position. Before it is first seen the camera counts, as without a
// source.
void HapticEngine::listen(Eigen::Matrix3Xd& ears, bool hasHead) const
{
    const Eigen::Affine3d toArray(_places.toArray);
    const auto given = static_cast<Eigen::Index>(_given.ears.size());
    ears.resize(3, given);
    for (Eigen::Index l = 0; l < given; ++l)
        ears.col(l) = toArray * midair::bridge::toEigen(_given.ears[static_cast<std::size_t>(l)]);
    if (!hasHead) return;
    Eigen::Isometry3d head = Eigen::Isometry3d::Identity();
    if (const auto& last = _player->heads().lastPlace())
        head = _places.worldToArray * *last;
    else if (!findCamera(head))
        return;
    ears.conservativeResize(3, given + 2);
    ears.rightCols<2>() = midair::bridge::earsOf(head);
}

// Stores the camera's pose, with x to its right, in \a head, array frame. Its own frame is the
// scene's world in scene units, as for the ears. Returns false if there is none.
bool HapticEngine::findCamera(Eigen::Isometry3d& head) const
{
    const osg::Camera* camera = _followed.view.valid() ? _followed.view->getCamera() : nullptr;
    if (!camera) return false;
    const Eigen::Affine3d toArray(_places.toArray);
    const osg::Matrixd toWorld = camera->getInverseViewMatrix();
    const osg::Vec3d right(toWorld(0, 0), toWorld(0, 1), toWorld(0, 2));
    head.translation() = toArray * midair::bridge::toEigen(toWorld.getTrans());
    head.linear().col(0) = (toArray.linear() * midair::bridge::toEigen(right)).stableNormalized();
    return head.matrix().allFinite(); // false for a camera with an undefined position
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
        const midair::base::Lock lock(_shown->mutex);
        touches = _shown->touches;
    }
    // It may have been muted or lost since the frame.
    if (_player->reading().state != ArrayState::PLAYING)
        for (Touch& touch : touches)
            touch.force = 0.0;
    return touches;
}

HapticStatistics HapticEngine::statistics() const
{
    HapticStatistics all;
    {
        const midair::base::Lock lock(_shown->mutex);
        all = _shown->collected;
    }
    midair::base::assignPart<midair::bridge::SceneStatistics>(all, _player->statistics());
    for (const Message& message : _player->log().messages())
        all.told.push_back(toPublic(message));
    if (_rest.isNow) all.collect_ms = 0.0;
    all.restingFrames = _rest.frames;
    all.frames += all.restingFrames;
    all.idleFrames += all.restingFrames;
    return all;
}

// Applies the environment and the user's grants to the given settings, without the user's caps, and
// repairs values out of range.
HapticSettings HapticEngine::granted(std::vector<Message>& messages) const
{
    std::vector<std::string> wrong;
    HapticSettings settings = Environment::replace(*_given.settings, wrong);
    settings = Grants::ofUser(messages).apply(settings, name(), messages);
    const std::vector<std::string> repaired = settings.repair();
    const std::vector<std::string>& why = settings.whySilenced;
    for (const std::vector<std::string>* all : {&std::as_const(wrong), &repaired})
        for (const std::string& what : *all)
            if (std::find(why.begin(), why.end(), what) == why.end())
                messages.push_back({MessageCode::SETTINGS_INVALID, what});
    return settings;
}

HapticSettings HapticEngine::grantedSettings() const
{
    if (!_settings.isRead) return *_given.settings;
    std::vector<Message> ignored; // already logged when the settings were read
    HapticSettings settings = Environment::restrict(granted(ignored));
    if (settings.isSilenced || _settings.isCrowded) settings.enabled = false;
    return settings;
}

// Removes hardware in a rehearsal, and disables the scene if a limit is invalid.
HapticSettings HapticEngine::usable(std::vector<Message>& messages)
{
    HapticSettings settings = granted(messages);
    _settings.isArrayRefused = std::any_of(messages.begin(),
                                           messages.end(),
                                           [](const Message& message)
                                           { return message.code == MessageCode::ARRAY_REFUSED; });
    if (_settings.isRehearsed)
        for (Message& message : rehearse(settings))
            messages.push_back(std::move(message));
    if (!settings.isSilenced) return settings;
    settings.enabled = false;
    for (const std::string& what : settings.whySilenced)
        messages.push_back({MessageCode::SETTINGS_SILENCED, what});
    if (settings.whySilenced.empty())
        messages.push_back(
            {MessageCode::SETTINGS_SILENCED, "isSilenced is set; nothing is played"});
    return settings;
}

// Compares the given settings: granted and repaired are then equal too, because the grants are.
bool HapticEngine::suits(const HapticEngine& other) const
{
    const osg::ref_ptr<osg::Node> alive = root(); // and thereby the settings
    if (!alive || !_given.settings->enabled || isRehearsed() != other.isRehearsed()) return false;
    const HapticSettings& a = *_given.settings;
    const HapticSettings& b = *other._given.settings;
    if (sceneSettings().effects(a, b) & (midair::base::Effect::REOPEN | midair::base::Effect::MOVE))
        return false;
    return a.arrayDescription == b.arrayDescription && haveSameWishes(a.wishes, b.wishes) &&
           _ownership.owner.outer().empty();
}

void HapticEngine::setJoined(bool joined)
{
    _ownership.joined.setJoined(joined);
    if (joined && _followed.viewer) _ownership.joined.follow(*_followed.viewer);
}

void HapticEngine::setRehearsed(bool rehearsed)
{
    _settings.isRehearsed = rehearsed;
    _settings.isRead = false;
    lookNext();
}

std::vector<FoundObject> HapticEngine::found() const
{
    return mayPlay() ? _collector.found() : std::vector<FoundObject>();
}

// A disabled scene opens no new hand source but keeps an open one, because it may be enabled again
// soon.
void HapticEngine::openHands(const HapticSettings& settings)
{
    const bool isOpen =
        !_settings.isBaked && (mayPlay() || settings.hands == _player->hands().named());
    _player->openHands(isOpen ? settings.hands : ""); // errors are reported with the hands
    const bool isHeadOpen =
        !_settings.isBaked && (mayPlay() || settings.heads == _player->heads().named());
    _player->openHead(isHeadOpen ? settings.heads : "");
}

midair::bridge::PlayedOn HapticEngine::playedOn(const HapticSettings& settings) const
{
    midair::bridge::PlayedOn on;
    on.array = settings.array;
    on.described = settings.arrayDescription;
    if (settings.arrayDescription)
        on.make = [described = settings.arrayDescription] { return arrayOf(*described); };
    on.isRefused = _settings.isArrayRefused;
    on.device = settings.device;
    return on;
}

// Returns false if the calibration is invalid.
bool HapticEngine::setPlaces(const HapticSettings& settings)
{
    midair::bridge::PoseAndStretch parts;
    const bool isRigid =
        midair::bridge::decompose(midair::bridge::toEigen(settings.calibration), parts) &&
        parts.stretch.isIdentity(kCalibrationTolerance);
    if (!isRigid) parts = {};
    _places.worldToArray = parts.pose;
    _places.toArray = parts.pose.matrix();
    _places.toArray.topLeftCorner<3, 3>() *= settings.metresPerUnit;
    return isRigid;
}

void HapticEngine::configure(const HapticSettings& given)
{
    if (_settings.isRead && given == _settings.seen)
    {
        _player->refresh();
        return;
    }
    _settings.seen = given;
    std::vector<Message> messages;
    auto used = std::make_shared<HapticSettings>(usable(messages));
    if (!setPlaces(*used))
    {
        messages.push_back(
            {MessageCode::SETTINGS_CALIBRATION,
             "calibration is not rigid (a scene unit is set by metresPerUnit); nothing is "
             "played"});
        used->enabled = false;
    }
    if (!takePlace(used->enabled))
    {
        used->enabled = false;
        messages.push_back(
            {MessageCode::SCENE_LIMIT,
             fmt::format("{} is not played: this program plays {} scenes already, the most at a "
                         "time; put scenes that share an array into one HapticScene",
                         name(),
                         PlayingPlace::kMost)});
    }
    _player->log().sayNow({MessageCode::SETTINGS_INVALID}, messages);
    _settings.isReported = _settings.isReported || (given.enabled && !_settings.isBaked);
    _settings.used = used;
    _settings.isRead = true;
    _collector.configure(_places.toArray, used->shadows, used->wishes.folder.value_or(""));
    _player->configure(used, playedOn(*used), name());
    openHands(*used);
}

// A scene that plays takes one of the process's places; without a place it opens nothing.
bool HapticEngine::takePlace(bool isEnabled)
{
    const bool isWanted = isEnabled && !_settings.isBaked;
    _settings.isCrowded = isWanted && !_ownership.place.take();
    if (!isWanted && _player->isClosed()) _ownership.place.leave();
    return !_settings.isCrowded;
}

void HapticEngine::keepInnerLimits()
{
    _player->setInnerLimits(innerLimits());
}

// Scenes inside this one may lower its limits, but never raise them.
midair::device::UserCaps HapticEngine::innerLimits()
{
    midair::device::UserCaps limits;
    std::vector<Message> told;
    limits.isSilencing = _collector.isSilenced();
    for (const HapticScene* inner : _collector.innerScenes())
    {
        if (inner->getSettings().isSilenced)
        {
            told.push_back(
                {MessageCode::SCENE_LIMIT,
                 "the HapticScene \"" + inner->getName() + "\" is invalid: nothing is played"});
            for (const std::string& reason : inner->getSettings().whySilenced)
                told.push_back({MessageCode::SETTINGS_SILENCED, reason});
            limits.isSilencing = true;
        }
        if (!HapticSettings::isLimit(
                inner->getMaxPressure(), inner->getMaxAmplitude(), inner->getEarLimit()))
        {
            told.push_back({MessageCode::SCENE_LIMIT,
                            "the HapticScene \"" + inner->getName() +
                                "\" has a cap that is out of range: nothing is played"});
            limits.isSilencing = true;
            continue;
        }
        midair::device::UserCaps its;
        its.maxPressure_Pa = inner->getMaxPressure();
        its.maxAmplitude = inner->getMaxAmplitude();
        its.earLimit_dB = inner->getEarLimit();
        limits = midair::device::stricter(limits, its);
    }
    if (limits.isSilencing) limits.maxAmplitude = 0.0;
    _player->log().sayNow({MessageCode::SCENE_LIMIT}, told);
    return limits;
}

// Functions for a FieldBaker, which solves the frames itself.

// Objects are read completely.
void HapticEngine::collectWhole(const SceneRoot& root,
                                std::vector<midair::bridge::HapticObject>& objects)
{
    _collector.collect({root}, objects);
    for (int more = 0; _collector.beingRead() > 0; ++more)
    {
        if (more > 0) std::this_thread::sleep_for(std::chrono::microseconds(100));
        _collector.collect({root}, objects);
    }
}

// Opens no hardware. Making the pipeline reads the array.
HapticEngine::Baked
HapticEngine::collectForBaking(const SceneRoot& root, unsigned int frame, double simulationTime_s)
{
    if (!_settings.isBaked) _settings.isRead = false; // discards what was open
    _settings.isBaked = true;
    _player->keepClosed();
    if (isPlayedByOuterOwner()) return {};
    configure(*_given.settings);
    // Looks for tags in each frame, so that the result doesn't depend on the first one.
    _collector.dirtyTags();
    if (mayPlay())
        collectWhole(root, _player->snapshot().objects);
    else
        collect({root});
    keepInnerLimits();
    fillSnapshot(frame, midair::base::steadySeconds(), simulationTime_s);
    listen(_player->snapshot().ears, false); // there is no camera
    _player->locateHands(_places.worldToArray);
    return {&_player->snapshot(), _player->changes()};
}

} // namespace osgMidair
