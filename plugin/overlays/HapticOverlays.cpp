#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/overlays/OverlayKinds.h"
#include "plugin/overlays/OverlayPart.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>

#include <osg/Transform>

#include <algorithm>
#include <string>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using Keys = osgGA::GUIEventAdapter;

} // namespace

template<class O>
osg::ref_ptr<O> HapticOverlays::part() const
{
    for (const Part& each : _parts)
        if (auto* found = dynamic_cast<O*>(each.overlay.get())) return found;
    return new O; // the kind was refused: never added to the scene
}

HapticOverlays::HapticOverlays() :
    _feed(std::make_unique<OverlayFeed>(*this)),
    _frame(new osg::MatrixTransform)
{
    for (const auto& [place, kind] : overlayKinds())
        _parts.push_back({&kind, kind.make()});
    _points = part<ControlPointOverlay>();
    _slice = part<FieldSliceOverlay>();
    _array = part<ArrayGhost>();
    _workspace = part<WorkspaceBox>();
    _hud = part<Hud>();
    _volume = part<FieldVolumeOverlay>();
    _hands = part<HandsOverlay>();
    _hud->setFieldSlice(_slice);
    _hud->setFieldVolume(_volume);

    std::vector<Part> layers = _parts;
    std::stable_sort(layers.begin(),
                     layers.end(),
                     [](const Part& a, const Part& b) { return a.kind->layer < b.kind->layer; });
    _frame->setDataVariance(DYNAMIC);
    addChild(_frame);
    for (const Part& each : layers)
        (each.kind->layer == 0 ? static_cast<osg::Group*>(this) : _frame.get())
            ->addChild(each.overlay);
    addEventCallback(new OverlayKeys(this));
    setNumChildrenRequiringUpdateTraversal(getNumChildrenRequiringUpdateTraversal() + 1);
}

HapticOverlays::HapticOverlays(const HapticOverlays& other, const osg::CopyOp& /*copyop*/) :
    HapticOverlays()
{
    setName(other.getName());
    setNodeMask(other.getNodeMask());
    for (const Part& each : _parts)
        if (const Overlay* theirs = other.getOverlay(each.kind->name))
        {
            each.overlay->setShown(theirs->isShown());
            for (const OverlayNumber& number : each.kind->numbers)
                number.set(*each.overlay, number.get(*theirs));
        }
}

HapticOverlays::~HapticOverlays() = default;

Overlay* HapticOverlays::getOverlay(const std::string& name) const
{
    for (const Part& each : _parts)
        if (each.kind->name == name || each.kind->word == name) return each.overlay.get();
    return nullptr;
}

bool HapticOverlays::setNumber(const std::string& name, double value)
{
    for (const Part& each : _parts)
        for (const OverlayNumber& number : each.kind->numbers)
            if ((number.name == name || number.storedName() == name) && number.range.holds(value))
            {
                number.set(*each.overlay, value);
                return true;
            }
    return false;
}

bool HapticOverlays::hasKey(int key)
{
    const auto& kinds = overlayKinds();
    return key == Keys::KEY_F7 ||
           std::any_of(kinds.begin(),
                       kinds.end(),
                       [key](const auto& kind) { return kind.second.key == key; });
}

std::string HapticOverlays::keyNames()
{
    std::string names;
    for (const auto& [place, kind] : overlayKinds())
        names += kind.keyName() + ", ";
    return names + "F7";
}

void HapticOverlays::setArrayToParent(const osg::Matrix& matrix)
{
    if (matrix != _frame->getMatrix()) _frame->setMatrix(matrix);
}

OverlayFeed::OverlayFeed(HapticOverlays& overlays) : _overlays(overlays) {}

OverlayFeed& OverlayFeed::of(HapticOverlays& overlays)
{
    return *overlays._feed;
}

void OverlayFeed::setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                           const midair::haptics::Medium& medium)
{
    for (const HapticOverlays::Part& each : _overlays._parts)
        OverlayPart::of(*each.overlay).setArray(array, medium);
}

std::shared_ptr<const midair::bridge::HologramResult> OverlayFeed::follow(const osg::NodePath& path)
{
    HapticScene* scene = nullptr; // the outermost one, which plays those inside it
    for (osg::Node* node : path)
        if (!scene) scene = dynamic_cast<HapticScene*>(node);
    if (!scene) return _shown;
    const auto array = SceneAccess::array(*scene);
    const midair::haptics::Medium medium = SceneAccess::medium(*scene);
    if (array && (array != _array || !_medium || !(*_medium == medium)))
    {
        _array = array;
        _medium = medium;
        setArray(array, medium);
        const std::string of = scene->getName().empty() ? "" : scene->getName() + " in ";
        _overlays.getHud()->setTitle(
            fmt::format("{}{} ({} transducers)", of, scene->getArray(), array->size()));
    }
    const double unitsPerMetre = 1.0 / scene->getMetresPerUnit();
    _overlays.setArrayToParent(osg::Matrix::inverse(scene->getCalibration()) *
                               osg::Matrix::scale(unitsPerMetre, unitsPerMetre, unitsPerMetre) *
                               osg::computeWorldToLocal(path));
    if (_overlays.getHands()->isShown())
    {
        const HandTracker& tracker = SceneAccess::engine(*scene).hands();
        OverlayPart::of(*_overlays.getHands())
            .setHands(midair::bridge::handCapsules(tracker.frame()),
                      tracker.contacts(),
                      tracker.frame().time_s);
    }
    return SceneAccess::latestResult(*scene);
}

void OverlayFeed::show(const std::shared_ptr<const midair::bridge::HologramResult>& result)
{
    if (!result) return;
    if (result != _shown) _shownMask = 0;
    _shown = result;
    unsigned int bit = 1;
    for (const HapticOverlays::Part& each : _overlays._parts)
    {
        Overlay* overlay = each.overlay.get();
        // An overlay that was just switched on still needs the current result.
        if (overlay->isShown() && !(_shownMask & bit))
        {
            OverlayPart::of(*overlay).setResult(result);
            _shownMask |= bit;
        }
        bit <<= 1;
    }
}

void OverlayFeed::update(const osg::NodePath& path)
{
    show(follow(path));
}

void HapticOverlays::traverse(osg::NodeVisitor& visitor)
{
    switch (visitor.getVisitorType())
    {
    case osg::NodeVisitor::UPDATE_VISITOR:
        _feed->update(visitor.getNodePath());
        break;
    case osg::NodeVisitor::EVENT_VISITOR:
    case osg::NodeVisitor::CULL_VISITOR:
        break;
    default:
        return;
    }
    osg::Group::traverse(visitor);
}

OverlayKeys::OverlayKeys(HapticOverlays* overlays) : _overlays(overlays) {}

bool OverlayKeys::handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& /*action*/)
{
    osg::ref_ptr<HapticOverlays> overlays;
    if (event.getEventType() != osgGA::GUIEventAdapter::KEYDOWN || !_overlays.lock(overlays))
        return false;
    const auto& all = overlays->_parts;
    const int key = event.getKey();
    for (const auto& each : all)
        if (each.kind->key == key)
        {
            each.overlay->setShown(!each.overlay->isShown());
            return true;
        }
    if (key != Keys::KEY_F7) return false;
    const bool anyShown = std::any_of(
        all.begin(), all.end(), [](const auto& each) { return each.overlay->isShown(); });
    for (const auto& each : all)
        each.overlay->setShown(!anyShown);
    return true;
}

void OverlayKeys::getUsage(osg::ApplicationUsage& usage) const
{
    for (const auto& [place, kind] : overlayKinds())
        usage.addKeyboardMouseBinding(kind.keyName(), "Haptics: show or hide " + kind.what);
    usage.addKeyboardMouseBinding("F7", "Haptics: show or hide all overlays");
}

} // namespace osgMidair
