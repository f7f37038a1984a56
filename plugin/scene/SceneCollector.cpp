#include "plugin/scene/SceneCollector.h"

#include "engine-bridge/PoseAndStretch.h"
#include "engine-bridge/hands/Obstacles.h"
#include "engine-bridge/player/SceneOptions.h"
#include "engine-bridge/scene/Convert.h"
#include "engine-bridge/scene/GeometryReader.h"
#include "engine-bridge/scene/drawn/DrawnState.h"
#include "engine-bridge/sensations/SensationLibrary.h"
#include "haptics/base/text/Words.h"
#include "haptics/sequence/ReflectorFigures.h"
#include "plugin/scene/ReflectorTag.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/HapticSurface>

#include <osg/Geode>
#include <osgDB/FileUtils>

#include <algorithm>
#include <cmath>
#include <typeinfo>
#include <utility>

#include <fmt/format.h>

namespace osgMidair
{

using midair::base::about;
using midair::base::MessageCode;
using midair::base::Topic;
using midair::bridge::Capsule;
using midair::bridge::HapticObject;
using midair::bridge::MeshCache;
using midair::bridge::PaintOptions;
using midair::haptics::FlatFace;
using midair::haptics::FlatFaces;

namespace
{

// What a topic of one object is about.
constexpr const char* kCause = "cause";
constexpr const char* kMesh = "mesh";
constexpr const char* kUntouched = "; it isn't felt where it is touched";

/// What a new instance costs besides its mesh, in bytes that take as long to copy.
constexpr std::size_t kInstanceWork = 2048;
/// What looking for tags costs for an instance, likewise.
constexpr std::size_t kTagWork = 512;
/// What it costs to meet an instance for the first time, likewise.
constexpr std::size_t kMeetWork = 256;
constexpr std::size_t kLongestPath = 4096;
/// The meshId of what has none; a MeshCache counts up from 1, PointMeshes from 2^63.
constexpr std::uint64_t kNoMesh = std::uint64_t(1) << 62;

bool isPlain(const osg::Node& node)
{
    const std::type_info& type = typeid(node);
    return type == typeid(osg::Group) || type == typeid(osg::Geode) ||
           type == typeid(HapticSurface);
}

// OSG's own comparison regards a matrix with NaN as equal to any other.
bool isSame(const osg::Matrixd& a, const osg::Matrixd& b)
{
    const auto isAlike = [](double x, double y)
    { return x == y || (std::isnan(x) && std::isnan(y)); };
    return std::equal(a.ptr(), a.ptr() + 16, b.ptr(), isAlike);
}

/// Replaces the name of a sensation's file by its path: in \a folder, or where OSG finds a model.
void locateSensation(const std::string& folder, HapticProperty& property)
{
    const std::string& text = property.sensation;
    const bool isFile = text.size() < kLongestPath && text.find('{') == std::string::npos &&
                        text.substr(0, text.find('?')).find_first_of("./") != std::string::npos;
    if (!isFile) return;
    std::string file = nameBeside(folder, text);
    if (file == text) file = osgDB::findDataFile(text);
    if (!file.empty()) property.sensation = std::move(file);
}

bool isSensation(const HapticProperty& property)
{
    return !midair::base::trimmed(property.sensation).empty();
}

std::vector<Capsule> capsulesOf(const midair::haptics::TriangleMesh& mesh)
{
    return midair::bridge::capsulesOf(mesh);
}

/// A sensation without a surface.
const midair::bridge::SharedMesh& noMesh()
{
    static const midair::bridge::SharedMesh mesh =
        std::make_shared<const midair::haptics::TriangleMesh>();
    return mesh;
}

} // namespace

std::string problemOfMaterial(const HapticProperty& property)
{
    std::string problem = midair::bridge::materialOf(property).problem;
    if (!problem.empty()) problem += kUntouched;
    if (property.material.empty()) return problem;
    for (const std::string& file : midair::bridge::materials().problems())
        problem += (problem.empty() ? "" : "; ") + file;
    return problem;
}

std::string problemOfSensation(const HapticProperty& property)
{
    const midair::bridge::MadeSensation made = midair::bridge::sensationOf(property);
    if (made.problem.empty() || made.properties.pattern) return made.problem;
    return "it is silent: " + made.problem;
}

midair::bridge::HapticProperties forBridge(const HapticProperty& property)
{
    const midair::bridge::ObjectMaterial made = midair::bridge::materialOf(property);
    if (made.problem.empty()) return propertiesOf(property, made.material);
    midair::bridge::HapticMaterial silent;
    silent.mostForce_N = 0.0;
    return propertiesOf(property, silent);
}

PaintOptions paintOf(const HapticProperty& property)
{
    PaintOptions paint;
    static_assert(int(HapticProperty::TEXTURE) == int(PaintOptions::TEXTURE) &&
                      int(HapticProperty::ALPHA) == int(PaintOptions::ALPHA),
                  "the same sources and channels, in one order");
    paint.source = static_cast<PaintOptions::Source>(property.intensity);
    paint.channel = static_cast<PaintOptions::Channel>(property.intensityChannel);
    paint.low = property.intensityLow;
    paint.high = property.intensityHigh;
    return paint;
}

SceneCollector::SceneCollector(const osg::Node* owner, Log log) :
    _log(std::move(log)),
    _visitor(owner),
    _real{{capsulesOf, "it is no obstacle"},
          {midair::haptics::flatFacesOf, "it reflects nothing"},
          {},
          {},
          {}}
{
    _extract.skip = isOwnObject; // nested haptic nodes are separate objects
}

void SceneCollector::configure(const Eigen::Matrix4d& toArray,
                               bool shadows,
                               const std::string& folder)
{
    _places.toArray = toArray;
    _places.shadows = shadows;
    _places.folder = folder;
    _log().ends({MessageCode::OBSTACLE_IDLE});
    forget();
}

bool SceneCollector::collect(const std::vector<SceneRoot>& roots,
                             std::vector<HapticObject>& objects)
{
    _collected.objects = &objects;
    _collected.count = 0;
    _collected.felt = 0;
    _collected.isSilenced = false;
    _collected.beingRead = 0;
    _collected.isChanged = !_frames.isKept;
    _collected.known = 0;
    _frames.calm = std::exchange(_collected.calm, 0);
    ++_frames.now;
    const unsigned int changes = propertyChanges();
    _frames.isAnySet = std::exchange(_frames.changes, changes) != changes;
    if (_frames.isAnySet || _frames.sinceTags == 0) _frames.waiting.clear();
    _meshes.beginFrame();
    const bool isTagFrame = _frames.sinceTags == 0;
    if (isTagFrame) lookForMarks(roots);
    _frames.sinceTags = (_frames.sinceTags + 1) % kTagFrames;
    const bool isUnmarked = _marks.state() == SceneMarks::State::NONE;
    _visitor.collect(roots, _unmarked && isUnmarked ? &*_unmarked : nullptr);
    noteMarks();
    const std::size_t met = _visitor.instances().size();
    const std::size_t before = std::exchange(_frames.instances, met);
    _meshes.spendBefore(kMeetWork * (met - std::min(before, met)) +
                        (isTagFrame ? kTagWork * met : 0));
    _real.props.clear();
    _real.faces.clear();
    _real.bodies.clear();
    _real.obstacles.beginFrame();
    _real.reflectors.beginFrame();
    for (const HapticInstance& instance : _visitor.instances())
        if (instance.isFelt())
            fill(instance);
        else if (instance.kind == HapticInstance::OBSTACLE)
            fillObstacle(instance);
        else
            fillReflector(instance);
    tellHidden(roots);
    endGone();
    _real.obstacles.endFrame();
    _real.reflectors.endFrame();
    _meshes.endFrame();
    _points.endFrame();
    if (std::exchange(_frames.objects, _collected.count) != _collected.count)
        _collected.isChanged = true;
    objects.resize(_collected.count);
    _frames.isKept = true;
    if (_collected.beingRead == 0) _frames.waiting.clear();
    if (_frames.now % MeshCache::kKeptFrames == 0) forgetUnseen();
    return _collected.isChanged;
}

void SceneCollector::lookForMarks(const std::vector<SceneRoot>& roots)
{
    std::vector<const osg::Node*> nodes;
    for (const SceneRoot& root : roots)
    {
        markTags(*root.node);
        nodes.push_back(root.node);
    }
    _marks.look(nodes);
    if (_told.marks == _marks.state() || nodes.empty()) return;
    _told.marks = _marks.state();
    tellMarks(*nodes.front());
}

// Later tags are met first by the visitor, where they are shown.
void SceneCollector::noteMarks()
{
    if (_marks.state() == SceneMarks::State::SOME) return;
    for (const HapticInstance& instance : _visitor.instances())
        if (instance.isFelt() && (!_unmarked || instance.property != &*_unmarked)) _marks.note();
}

// Ends messages about objects that are gone or were disabled.
void SceneCollector::endGone()
{
    for (auto one = _told.realThings.begin(); one != _told.realThings.end();)
    {
        const bool isGone = one->second != _frames.now;
        if (isGone) _log().endsOf(one->first);
        one = isGone ? _told.realThings.erase(one) : std::next(one);
    }
    const bool isAnyGone = _collected.known != _told.known || _collected.isAnyBack;
    _told.known = _collected.known;
    _collected.isAnyBack = false;
    if (!isAnyGone) return;
    for (auto& [id, known] : _known)
        if (known.seen + 1 == _frames.now) _log().endsOf(id);
}

void SceneCollector::forgetUnseen()
{
    for (auto known = _known.begin(); known != _known.end();)
        known = _frames.now - known->second.seen > MeshCache::kKeptFrames ? _known.erase(known)
                                                                          : std::next(known);
}

std::vector<FoundObject> SceneCollector::found() const
{
    std::vector<FoundObject> all;
    for (const auto& [id, known] : _known)
        if (known.seen == _frames.now)
            all.push_back({known.node, known.path, known.property, !known.objects.empty()});
    return all;
}

osg::Node* SceneCollector::nodeOf(std::uint64_t instance) const
{
    const auto known = _known.find(instance);
    return known == _known.end() ? nullptr : known->second.node.get();
}

void SceneCollector::fillObstacle(const HapticInstance& instance)
{
    if (!_places.shadows)
    {
        const Topic idle{MessageCode::OBSTACLE_IDLE};
        if (_log().begins(idle))
            _log().say(idle,
                       about(idle.code,
                             _visitor.path(instance),
                             "is an obstacle, which counts only where the scene's shadows are on"));
        return;
    }
    _warnings.clear();
    const auto take = [this](const std::vector<Capsule>& capsules, const Eigen::Isometry3d& pose)
    {
        for (const Capsule& one : capsules)
            _real.props.push_back({pose * one.a, pose * one.b, one.radius_m});
    };
    if (instance.inWorld)
        _real.obstacles.add(*instance.node,
                            _places.toArray * midair::bridge::toEigen(instance.world),
                            _extract.skip,
                            _warnings,
                            take);
    else
        _warnings.emplace_back("hangs on a camera, not in the world; it is no obstacle");
    tellReal(instance, MessageCode::OBSTACLE_INVALID);
}

namespace
{

/// True of what fields at rest may be solved for as a rigid body.
bool isCorrectable(const ReflectorTag& tag)
{
    return tag.reflection == 1.0 && tag.reflectionPhase == 0.0 &&
           tag.accuracy <= midair::haptics::kMostCorrectedAccuracy_mm;
}

} // namespace

// Of the faces that all reflectors have, one more than a field can have is enough to tell that they
// are too many.
void SceneCollector::fillReflector(const HapticInstance& instance)
{
    std::string text;
    reflectorTag(*instance.node, text);
    _warnings.clear();
    std::vector<std::string> wrong;
    const ReflectorTag tag = ReflectorTag::parse(text, wrong);
    const auto take = [&](const FlatFaces& found, const Eigen::Isometry3d& pose)
    {
        const bool isBody = found.body && isCorrectable(tag) &&
                            _real.bodies.size() < midair::haptics::kMostReflectors;
        if (isBody) _real.bodies.push_back({found.body, pose});
        if (!found.problem.empty())
            wrong.push_back(found.problem + (isBody ? "; only fields at rest are solved for it"
                                                    : "; it reflects nothing"));
        for (const FlatFace& face : found.faces)
        {
            if (_real.faces.size() > midair::haptics::kMostReflectors) continue;
            FlatFace& one = _real.faces.emplace_back(face.movedBy(pose));
            one.rectangle.name = instance.node->getName();
            one.rectangle.reflection = tag.reflection;
            one.rectangle.reflectionPhase_rad = tag.reflectionPhase;
            one.rectangle.accuracy_mm = tag.accuracy;
            one.isSolvedAtRest = isBody;
        }
    };
    if (tag.enabled && instance.inWorld)
        _real.reflectors.add(*instance.node,
                             _places.toArray * midair::bridge::toEigen(instance.world),
                             _extract.skip,
                             _warnings,
                             take);
    else if (tag.enabled)
        _warnings.emplace_back("hangs on a camera, not in the world; it reflects nothing");
    std::vector<midair::base::Message> told;
    told.reserve(wrong.size());
    for (const std::string& what : wrong)
        told.push_back(about(
            MessageCode::REFLECTOR_INVALID, _visitor.path(instance), "as a reflector: " + what));
    _log().sayNow({MessageCode::REFLECTOR_INVALID, instance.id}, told);
    _told.realThings[instance.id] = _frames.now;
    tellReal(instance, MessageCode::REFLECTOR_INVALID);
}

// Logs the warnings about an obstacle or a reflector.
void SceneCollector::tellReal(const HapticInstance& instance, MessageCode code)
{
    const auto told = _told.realThings.find(instance.id);
    if (told != _told.realThings.end()) told->second = _frames.now;
    for (const std::string& warning : _warnings)
    {
        const Topic topic{code, instance.id, warning};
        _told.realThings[instance.id] = _frames.now;
        if (_log().begins(topic))
            _log().say(topic, about(topic.code, _visitor.path(instance), warning));
    }
}

SceneCollector::Known&
SceneCollector::know(const HapticInstance& instance, bool& fresh, bool& changed)
{
    const auto [found, isNew] = _known.try_emplace(instance.id);
    Known& known = found->second;
    // Another node may have the address of a deleted one.
    const bool isOther = !isNew && known.node.get() != instance.node;
    if (isOther) known = Known();
    const bool inserted = isNew || isOther;
    const bool isMet = !inserted && known.seen == _frames.now;
    const bool isBack = !inserted && !isMet && known.seen + 1 != _frames.now;
    fresh = inserted || isBack;
    changed = fresh || isMet;
    if (!isMet) ++_collected.known;
    if (fresh) _collected.isAnyBack = true;
    if (isBack) known.cause.clear();
    known.id = instance.id;
    known.seen = _frames.now;
    const bool isSurface =
        instance.property && !instance.points && (!_unmarked || instance.property != &*_unmarked);
    if (!changed && isSurface && !_frames.isAnySet) return known;
    if (inserted)
    {
        _meshes.spend(kInstanceWork);
        instance.node->getBound(); // so that no later frame computes all bounds at once
    }
    if (inserted) known.path = _visitor.path(instance);
    if (inserted) known.node = instance.node;
    if (inserted) renew(known);

    HapticProperty raw;
    std::vector<std::string> errors;
    if (instance.property)
    {
        if (!fresh && *instance.property == known.raw) return known;
        raw = *instance.property;
    }
    else
    {
        std::string tag;
        hapticTag(*instance.node, tag);
        if (!fresh && tag == known.tag) return known;
        known.tag = tag;
        raw.parse(tag, errors);
        if (!fresh && errors.empty() && raw == known.raw && known.isUnderstood) return known;
    }
    changed = true;
    known.raw = known.property = raw;
    repair(known, std::move(errors));
    return known;
}

// Repairs values out of range; logs this, previous errors in \a wrong, and silencing.
void SceneCollector::repair(Known& known, std::vector<std::string> wrong)
{
    for (std::string& what : known.property.repair())
        wrong.push_back(std::move(what));
    locateSensation(_places.folder, known.property);
    if (std::string what = problemOfMaterial(known.property); !what.empty())
        wrong.push_back(std::move(what));
    if (std::string what = problemOfSensation(known.property); !what.empty())
        wrong.push_back(std::move(what));
    known.felt = forBridge(known.property);
    const std::vector<std::string>& why = known.property.whySilenced;
    std::vector<midair::base::Message> told;
    for (const std::string& what : wrong)
        if (std::find(why.begin(), why.end(), what) == why.end())
            told.push_back(about(MessageCode::PROPERTY_INVALID, known.path, what, known.origin));
    for (const std::string& what : why)
        told.push_back(about(MessageCode::PROPERTY_SILENCED, known.path, what, known.origin));
    known.isUnderstood = told.empty();
    _log().sayNow({MessageCode::PROPERTY_INVALID, known.id}, told);
}

// A new instance in a frame without time for it. If it silences the scene, it does so at once.
bool SceneCollector::mustWait(const HapticInstance& instance)
{
    if (!_meshes.isFull() || _known.count(instance.id) > 0) return false;
    const auto [waiting, isFirst] = _frames.waiting.try_emplace(instance.id, false);
    if (isFirst) waiting->second = silences(instance);
    if (waiting->second) _collected.isSilenced = true;
    ++_collected.beingRead;
    return true;
}

bool SceneCollector::silences(const HapticInstance& instance)
{
    HapticProperty property;
    std::string tag;
    std::vector<std::string> wrong; // logged when it is read
    if (instance.property)
        property = *instance.property;
    else if (hapticTag(*instance.node, tag))
        property.parse(tag, wrong);
    property.repair();
    return property.enabled && !property.whySilenced.empty();
}

// The part of an instance that is read: if it consists of one drawable, that drawable, which others
// may share. Paint depends on the nodes above.
osg::Node& SceneCollector::contentOf(osg::Node& node) const
{
    if (_extract.paint.source != PaintOptions::NONE) return node;
    osg::Node* at = &node;
    for (osg::Group* group = at->asGroup(); group; group = at->asGroup())
    {
        const bool isRoot = at == &node;
        if (!isPlain(*group) || group->getNumChildren() != 1 ||
            (!isRoot && (group->getStateSet() || group->getCullCallback())))
            return node;
        at = group->getChild(0);
        if (isOwnObject(*at) || (at->getNodeMask() & _extract.traversalMask) == 0) return node;
    }
    return at->asDrawable() && !at->getCullCallback() ? *at : node;
}

// A snapshot's objects of a known instance are up to date if they have its origin, which changes
// each time.
void SceneCollector::renew(Known& known)
{
    known.origin = std::make_shared<const FeltNode>(FeltNode{known.node, known.path});
}

void SceneCollector::fill(const HapticInstance& instance)
{
    if (mustWait(instance)) return;
    bool fresh = false;
    bool changed = false;
    Known& known = know(instance, fresh, changed);
    std::uint64_t shape = 0;
    const bool possible = known.property.enabled && instance.inWorld;
    if (known.property.enabled && !known.property.whySilenced.empty()) _collected.isSilenced = true;
    if (possible)
    {
        _extract.paint = paintOf(known.property);
        shape = instance.points           ? instance.points->getModifiedCount()
                : mayRest(known, changed) ? known.shape
                                          : lookAt(known, *instance.node, fresh);
    }
    const bool stands = _frames.isKept && !changed && known.shape == shape &&
                        isSame(known.world, instance.world) && known.clips == instance.clips;
    known.shape = shape;
    if (!stands || known.first != _collected.count) _collected.isChanged = true;
    known.first = _collected.count;
    if (!stands)
    {
        known.world = instance.world;
        known.clips = instance.clips;
        known.objects.clear();
        renew(known);
        if (known.property.enabled && !instance.inWorld && fresh)
            tell(known,
                 MessageCode::OBJECT_CAMERA,
                 "hangs on a camera, not in the world; it can't be felt");
        if (possible && instance.followsCamera && fresh)
            tell(known,
                 MessageCode::OBJECT_UNTURNED,
                 "hangs on what turns with the camera on screen; it is felt unturned");
        if (possible && fresh && !instance.points) tellStates(instance, known);
        if (possible)
            fillParts(instance, known);
        else
            tellCause(known, MessageCode::OBJECT_INVALID, "");
    }
    put(known);
    if (!known.objects.empty()) ++_collected.felt;
}

// If many objects have had unchanged meshes for a while, these are checked in turn.
bool SceneCollector::mayRest(Known& known, bool isChanged)
{
    if (isChanged || !_frames.isKept) known.calm = 0;
    if (++known.calm <= kCalmFrames) return false;
    const unsigned int turns = std::min(_frames.calm / kMostLooks + 1, kCalmFrames);
    return (_collected.calm++ + _frames.now) % turns != 0;
}

std::uint64_t SceneCollector::lookAt(Known& known, osg::Node& node, bool isBack)
{
    osg::Node& content = contentOf(node);
    _warnings.clear();
    const std::uint64_t shape = _meshes.look(content, _extract, _warnings);
    const bool isRead = _meshes.isBeingRead(content);
    if (isRead) ++_collected.beingRead;
    if (shape != known.shape || isRead) known.calm = 0;
    if (shape != known.shape)
    {
        known.geometry.clear();
        _log().ends({MessageCode::OBJECT_GEOMETRY, known.id, kMesh});
    }
    tellGeometry(known, isBack);
    return shape;
}

// The objects may be those of an older snapshot.
void SceneCollector::put(const Known& known)
{
    std::vector<HapticObject>& all = *_collected.objects;
    const std::size_t end = _collected.count + known.objects.size();
    if (all.size() < end) all.resize(end);
    for (const HapticObject& object : known.objects)
    {
        HapticObject& slot = all[_collected.count++];
        if (slot.origin != object.origin || slot.id != object.id) slot = object;
    }
}

// Stores the meshes of an instance in _parts; false, after logging the reason, if there are none.
// \a pressure: replaces the property's, if over 0.
bool SceneCollector::findParts(const HapticInstance& instance, Known& known, double& pressure)
{
    std::vector<std::string> leftOut;
    const auto say = [&](MessageCode code, const std::string& what)
    {
        if (code == MessageCode::POINTS_INVALID)
            leftOut.push_back(what);
        else
            tellCause(known, code, what);
    };
    const Eigen::Matrix4d matrix = _places.toArray * midair::bridge::toEigen(instance.world);
    _parts.clear();
    if (instance.points)
    {
        const PointMesh* made = _points.get(*instance.points, matrix, say);
        tellLeftOut(known, leftOut);
        if (!made) return false;
        tellCause(known, MessageCode::OBJECT_INVALID, "");
        _parts.push_back(made->mesh);
        pressure = made->pressure;
        return true;
    }
    _warnings.clear();
    osg::Node& content = contentOf(*instance.node);
    if (!_meshes.get(content, matrix, _extract, _parts, _warnings))
    {
        tellCause(known,
                  MessageCode::OBJECT_INVALID,
                  "its matrix is singular, not finite or a perspective; it can't be felt");
        return false;
    }
    tellGeometry(known, false);
    midair::bridge::PoseAndStretch place;
    if (_parts.empty() && isSensation(known.property) && midair::bridge::decompose(matrix, place))
        _parts.push_back({kNoMesh, kNoMesh, noMesh(), 0, place.pose});
    if (!_parts.empty()) tellCause(known, MessageCode::OBJECT_INVALID, "");
    if (!_parts.empty() || _meshes.isBeingRead(content)) return !_parts.empty();
    const WhyUnfelt why = whyUnfelt(*instance.node, !known.geometry.empty());
    if (why.isHidden)
        tellCause(known, MessageCode::OBJECT_HIDDEN, why.text + "; it is felt once it is shown");
    else if (!why.text.empty())
        tellCause(known, MessageCode::OBJECT_INVALID, why.text + "; it can't be felt");
    return false;
}

// Points left out are logged once when that begins, however many they become.
void SceneCollector::tellLeftOut(const Known& known, const std::vector<std::string>& leftOut)
{
    std::vector<midair::base::Message> told;
    told.reserve(leftOut.size());
    for (const std::string& what : leftOut)
        told.push_back(about(MessageCode::POINTS_INVALID, known.path, what, known.origin));
    _log().sayNow({MessageCode::POINTS_INVALID, known.id}, told);
}

void SceneCollector::fillParts(const HapticInstance& instance, Known& known)
{
    std::vector<Eigen::Vector4d> clips;
    for (const osg::Vec4d& plane : instance.clips)
        clips.emplace_back(_places.toArray.inverse().transpose() *
                           Eigen::Vector4d(plane.x(), plane.y(), plane.z(), plane.w()));
    double pressure = 0.0;
    if (!findParts(instance, known, pressure)) return;
    for (const midair::bridge::CachedMesh& part : _parts)
    {
        HapticObject& object = known.objects.emplace_back();
        object.id = instance.id ^ part.part;
        object.whole = instance.id;
        object.path = known.path;
        object.origin = known.origin;
        object.meshId = part.meshId;
        object.topologyId = part.topologyId;
        object.mesh = part.mesh;
        object.pose = part.pose;
        object.properties = known.felt;
        object.clips = clips;
        object.touchEvents = known.property.touchEvents;
        if (!instance.points) continue;
        object.properties.sampling = midair::haptics::Sampling::POINTS;
        object.properties.side = midair::bridge::Side::BOTH;
        if (pressure > 0.0) object.properties.pressure = pressure;
    }
}

// Messages of a SceneCollector about tags and objects.

void SceneCollector::tellMarks(const osg::Node& root)
{
    const std::string path = midair::bridge::quoted(root);
    std::vector<midair::base::Message> told;
    if (_marks.state() == SceneMarks::State::UNKNOWN)
        told.push_back(about(
            MessageCode::SCENE_INCOMPLETE,
            path,
            fmt::format("{} is not loaded yet and may have haptic tags; untagged objects aren't "
                        "played until a tag is found or everything is loaded",
                        _marks.missing())));
    else if (_marks.state() == SceneMarks::State::NONE && _unmarked)
        told.push_back(about(MessageCode::SCENE_UNMARKED,
                             path,
                             "nothing in it is tagged as haptic, so the whole scene is touchable"));
    else if (_marks.state() == SceneMarks::State::NONE)
        told.push_back(
            about(MessageCode::SCENE_EMPTY,
                  path,
                  "has no HapticSurface, no HapticPoints and no node with a haptic tag; nothing is "
                  "felt"));
    else if (_unmarked && !(*_unmarked == HapticProperty()))
        told.push_back(about(MessageCode::SETTINGS_INVALID,
                             path,
                             "the haptic properties given for an untagged scene are ignored: "
                             "this one has haptic tags of its own"));
    _log().sayNow({MessageCode::SCENE_EMPTY}, told);
}

void SceneCollector::tellHidden(const std::vector<SceneRoot>& roots)
{
    const auto& all = _visitor.instances();
    const bool isHidden = _marks.state() == SceneMarks::State::SOME && !roots.empty() &&
                          std::all_of(all.begin(),
                                      all.end(),
                                      [](const HapticInstance& one) { return !one.isFelt(); });
    const Topic hidden{MessageCode::OBJECT_HIDDEN};
    if (_log().begins(hidden, isHidden))
        _log().say(hidden,
                   about(hidden.code,
                         midair::bridge::quoted(*roots.front().node),
                         "all its haptic objects are hidden, disabled, unloaded or removed; "
                         "nothing is played until one is shown"));
}

void SceneCollector::tell(const Known& known, MessageCode code, const std::string& what)
{
    const Topic topic{code, known.id, what};
    if (_log().begins(topic)) _log().say(topic, about(code, known.path, what, known.origin));
}

// Warnings come when a mesh is read; an instance that is back repeats them.
void SceneCollector::tellGeometry(Known& known, bool isBack)
{
    if (_warnings.empty() && !isBack) return;
    for (const std::string& warning : _warnings)
        known.geometry.push_back(
            about(MessageCode::OBJECT_GEOMETRY, known.path, warning, known.origin));
    _log().sayNow({MessageCode::OBJECT_GEOMETRY, known.id, kMesh}, known.geometry);
}

// Objects are filled in again whenever another one has changed; a cause is logged once while it
// lasts, and ends when there is none.
void SceneCollector::tellCause(Known& known, MessageCode code, const std::string& cause)
{
    if (known.cause == cause) return;
    known.cause = cause;
    std::vector<midair::base::Message> told;
    if (!cause.empty()) told.push_back(about(code, known.path, cause, known.origin));
    _log().sayNow({MessageCode::OBJECT_INVALID, known.id, kCause}, told);
}

// Logs how states on the path to an object affect its visible shape, when it is first met. States
// below it are logged when it and its drawables are read.
void SceneCollector::tellStates(const HapticInstance& instance, const Known& known)
{
    const auto look = [&](const osg::Node& node)
    {
        if (node.asDrawable()) return;
        const std::string what = midair::bridge::notFeltOf(node);
        if (!what.empty())
            tell(known, MessageCode::OBJECT_GEOMETRY, midair::bridge::quoted(node) + " " + what);
    };
    _visitor.lookAlong(instance, look);
}

} // namespace osgMidair
