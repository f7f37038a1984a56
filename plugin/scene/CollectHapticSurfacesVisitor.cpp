#include "plugin/scene/CollectHapticSurfacesVisitor.h"

#include "engine-bridge/scene/GeometryReader.h"
#include "engine-bridge/scene/SubtreeWalk.h"

#include <osgMidair/HapticPoints>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/Camera>
#include <osg/Drawable>
#include <osg/Plane>
#include <osg/Transform>
#include <osg/ValueObject>

#include <algorithm>

namespace osgMidair
{

namespace
{

const std::string kTag = "haptic";
const std::string kObstacleTag = "obstacle";
const std::string kReflectorTag = "reflector";

/// Returns the description that begins with the word \a tag, or null.
const std::string* description(const osg::Node& node, const std::string& tag)
{
    const osg::UserDataContainer* container = node.getUserDataContainer();
    if (!container) return nullptr;
    for (const std::string& text : container->getDescriptions())
        if (text.compare(0, tag.size(), tag) == 0 &&
            (text.size() == tag.size() || text.find_first_of(" :=") == tag.size()))
            return &text;
    return nullptr;
}

const osg::Object* userValue(const osg::Node& node, const std::string& tag)
{
    const osg::UserDataContainer* container = node.getUserDataContainer();
    return container ? container->getUserObject(tag) : nullptr;
}

/// Reads the text of \a tag; false if the node has none.
bool textOf(const osg::Node& node, const std::string& tag, std::string& text)
{
    if (const osg::Object* value = userValue(node, tag))
    {
        if (const auto* words = dynamic_cast<const osg::StringValueObject*>(value))
            text = words->getValue();
        else if (const auto* flag = dynamic_cast<const osg::BoolValueObject*>(value))
            text = flag->getValue() ? "true" : "false";
        else
            text = "true";
        return true;
    }
    if (const std::string* words = description(node, tag))
    {
        const std::size_t start = words->find_first_not_of(" :=", tag.size());
        text = start == std::string::npos ? "true" : words->substr(start);
        return true;
    }
    return false;
}

bool hasTag(const osg::Node& node, const std::string& tag)
{
    return node.getUserDataContainer() && (userValue(node, tag) || description(node, tag));
}

} // namespace

bool hasHapticTag(const osg::Node& node)
{
    return hasTag(node, kTag);
}

bool hapticTag(const osg::Node& node, std::string& text)
{
    return textOf(node, kTag, text);
}

bool hasReflectorTag(const osg::Node& node)
{
    return hasTag(node, kReflectorTag);
}

bool reflectorTag(const osg::Node& node, std::string& text)
{
    return textOf(node, kReflectorTag, text);
}

bool hasObstacleTag(const osg::Node& node)
{
    if (!node.getUserDataContainer()) return false;
    const osg::Object* value = userValue(node, kObstacleTag);
    const auto* flag = dynamic_cast<const osg::BoolValueObject*>(value);
    return flag ? flag->getValue() : value || description(node, kObstacleTag);
}

bool isOwnObject(const osg::Node& node)
{
    // The cheapest test comes first: own objects always request the event traversal.
    return node.getNumChildrenRequiringEventTraversal() > 0 &&
           (dynamic_cast<const HapticSurface*>(&node) || dynamic_cast<const HapticPoints*>(&node) ||
            hasHapticTag(node) || hasObstacleTag(node) || hasReflectorTag(node));
}

CollectHapticSurfacesVisitor::CollectHapticSurfacesVisitor(const osg::Node* owner) :
    osg::NodeVisitor(NODE_VISITOR, TRAVERSE_ACTIVE_CHILDREN),
    _owner(owner)
{
}

void CollectHapticSurfacesVisitor::collect(const std::vector<SceneRoot>& roots,
                                           const HapticProperty* otherwise)
{
    _innerScenes.clear();
    _instances.clear();
    _paths.clear();
    _pathStarts.clear();
    _inWorld = true;
    _followsCamera = false;
    _clips.clear();
    for (const SceneRoot& root : roots)
    {
        _world = root.world;
        root.node->accept(*this);
    }
    const bool haptic = std::any_of(
        _instances.begin(), _instances.end(), [](const HapticInstance& i) { return i.isFelt(); });
    if (haptic || !otherwise || roots.empty() || !validNodeMask(*roots.front().node)) return;
    osg::Node& root = *roots.front().node;
    _world = roots.front().world;
    if (osg::Transform* transform = root.asTransform())
        transform->computeLocalToWorldMatrix(_world, this);
    pushOntoNodePath(&root);
    add(root, otherwise);
    popFromNodePath();
}

std::uint64_t CollectHapticSurfacesVisitor::pathId() const
{
    // FNV-1a over the addresses on the path.
    std::uint64_t hash = 0xCBF29CE484222325ull;
    for (const osg::Node* node : _nodePath)
    {
        hash ^= static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(node));
        hash *= 0x100000001B3ull;
        hash ^= hash >> 31;
    }
    return hash;
}

bool CollectHapticSurfacesVisitor::enter(const osg::Node& node)
{
    const auto* scene = dynamic_cast<const HapticScene*>(&node);
    if (!scene || scene == _owner) return true;
    const bool isFelt = scene->getEnabled() && !scene->getMuted();
    if (isFelt) _innerScenes.push_back(scene);
    return isFelt;
}

void CollectHapticSurfacesVisitor::check(osg::Node& node)
{
    const auto* surface = dynamic_cast<const HapticSurface*>(&node);
    const auto* points = dynamic_cast<const HapticPoints*>(&node);
    if (points)
        add(node, &points->getProperty()).points = points;
    else if (surface || hasHapticTag(node))
        add(node, surface ? &surface->getProperty() : nullptr);
    if (hasObstacleTag(node)) add(node, nullptr).kind = HapticInstance::OBSTACLE;
    if (hasReflectorTag(node)) add(node, nullptr).kind = HapticInstance::REFLECTOR;
}

HapticInstance& CollectHapticSurfacesVisitor::add(osg::Node& node, const HapticProperty* property)
{
    HapticInstance instance;
    instance.node = &node;
    instance.id = pathId();
    instance.world = _world;
    instance.property = property;
    instance.inWorld = _inWorld;
    instance.followsCamera = _followsCamera;
    if (!_clips.empty()) addClips(instance);
    _instances.push_back(instance);
    _pathStarts.push_back(_paths.size());
    _paths.insert(_paths.end(), _nodePath.begin(), _nodePath.end());
    _paths.push_back(nullptr);
    return _instances.back();
}

// A ClipNode's own state enables its planes; a state further down may disable them.
void CollectHapticSurfacesVisitor::addClips(HapticInstance& instance) const
{
    for (const Clip& clip : _clips)
    {
        bool isOn = false;
        bool isForced = false;
        for (std::size_t i = clip.from; i < _nodePath.size(); ++i)
        {
            const osg::StateSet* state = _nodePath[i]->getStateSet();
            if (!state) continue;
            const osg::StateAttribute::GLModeValue value = state->getMode(clip.mode);
            const bool counts = !isForced || (value & osg::StateAttribute::PROTECTED);
            if ((value & osg::StateAttribute::INHERIT) || !counts) continue;
            isOn = (value & osg::StateAttribute::ON) != 0;
            isForced = (value & osg::StateAttribute::OVERRIDE) != 0;
        }
        if (isOn) instance.clips.push_back(clip.plane);
    }
}

void CollectHapticSurfacesVisitor::lookAlong(
    const HapticInstance& instance, const std::function<void(const osg::Node&)>& look) const
{
    const auto index = static_cast<std::size_t>(&instance - _instances.data());
    for (std::size_t i = _pathStarts[index]; _paths[i]; ++i)
        look(*_paths[i]);
}

std::string CollectHapticSurfacesVisitor::path(const HapticInstance& instance)
{
    std::string text;
    lookAlong(instance,
              [&text](const osg::Node& node)
              { text += (text.empty() ? "" : "/") + midair::bridge::quoted(node); });
    return text;
}

void CollectHapticSurfacesVisitor::apply(osg::Node& node)
{
    if (!leadsSomewhere(node)) return;
    if (!enter(node)) return;
    check(node);
    traverse(node);
}

void CollectHapticSurfacesVisitor::apply(osg::Transform& node)
{
    if (!leadsSomewhere(node)) return;
    const osg::Matrixd outer = _world;
    const bool outerInWorld = _inWorld;
    const bool outerFollows = _followsCamera;
    if (node.getReferenceFrame() != osg::Transform::RELATIVE_RF) _inWorld = false;
    if (midair::bridge::followsCamera(node)) _followsCamera = true;
    if (_inWorld) _world.preMult(midair::bridge::cameraFreeMatrix(node, this));
    check(node);
    traverse(node);
    _world = outer;
    _inWorld = outerInWorld;
    _followsCamera = outerFollows;
}

void CollectHapticSurfacesVisitor::apply(osg::Camera& node)
{
    if (!leadsSomewhere(node)) return;
    const bool outerInWorld = _inWorld;
    _inWorld = false;
    check(node);
    traverse(node);
    _inWorld = outerInWorld;
}

void CollectHapticSurfacesVisitor::apply(osg::ClipNode& node)
{
    if (!leadsSomewhere(node)) return;
    const std::size_t outer = _clips.size();
    // One in an absolute frame clips relative to the camera, not in the world.
    if (_inWorld && node.getReferenceFrame() == osg::ClipNode::RELATIVE_RF)
        for (const auto& plane : node.getClipPlaneList())
        {
            osg::Plane world(plane->getClipPlane());
            world.transform(_world);
            _clips.push_back({world.asVec4(),
                              GL_CLIP_PLANE0 + plane->getClipPlaneNum(),
                              _nodePath.empty() ? 0 : _nodePath.size() - 1});
        }
    apply(static_cast<osg::Node&>(node));
    _clips.resize(outer);
}

void CollectHapticSurfacesVisitor::apply(osg::Drawable& drawable)
{
    if (leadsSomewhere(drawable)) check(drawable);
}

void markTags(osg::Node& root)
{
    // The function is protected in osg::Node because only subclasses normally request traversals;
    // here a tag makes a plain node haptic.
    struct Counts : osg::Node
    {
        using osg::Node::setNumChildrenRequiringEventTraversal;
    };
    // Plain recursion is several times faster than a visitor. It enters all children, shown or not.
    if (root.getUserDataContainer() && root.getNumChildrenRequiringEventTraversal() == 0 &&
        (hasHapticTag(root) || hasObstacleTag(root) || hasReflectorTag(root)))
        (root.*&Counts::setNumChildrenRequiringEventTraversal)(1);
    osg::Group* group = root.asGroup();
    const unsigned int children = group ? group->getNumChildren() : 0;
    for (unsigned int i = 0; i < children; ++i)
        markTags(*group->getChild(i));
}

} // namespace osgMidair
