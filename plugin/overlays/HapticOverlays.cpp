#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/overlays/OverlayPart.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>

#include <osg/Transform>

#include <algorithm>
#include <array>
#include <string>

namespace osgMidair
{

namespace
{

/// An overlay, the key that shows and hides it, and what the key's help calls it.
struct Keyed
{
    int key;
    const char* name;
    const char* what;
    Overlay* overlay;
};

using Keys = osgGA::GUIEventAdapter;

std::array<Keyed, 7> allOf(HapticOverlays& overlays)
{
    return {{{Keys::KEY_F2, "F2", "the control points", overlays.getControlPoints()},
             {Keys::KEY_F3, "F3", "the slice of the field", overlays.getFieldSlice()},
             {Keys::KEY_F4, "F4", "the array", overlays.getArray()},
             {Keys::KEY_F5, "F5", "the workspace", overlays.getWorkspace()},
             {Keys::KEY_F6, "F6", "the figures", overlays.getHud()},
             {Keys::KEY_F9, "F9", "the field in space", overlays.getFieldVolume()},
             {Keys::KEY_F10, "F10", "hands and touches", overlays.getHands()}}};
}

} // namespace

HapticOverlays::HapticOverlays() :
    _feed(std::make_unique<OverlayFeed>(*this)),
    _frame(new osg::MatrixTransform),
    _points(new ControlPointOverlay),
    _slice(new FieldSliceOverlay),
    _array(new ArrayGhost),
    _workspace(new WorkspaceBox),
    _hud(new Hud),
    _volume(new FieldVolumeOverlay),
    _hands(new HandsOverlay)
{
    _frame->setDataVariance(DYNAMIC);
    _frame->addChild(_array);
    _frame->addChild(_workspace);
    _frame->addChild(_slice);
    _frame->addChild(_volume);
    _frame->addChild(_hands);
    _frame->addChild(_points);
    _hud->setFieldSlice(_slice);
    _hud->setFieldVolume(_volume);
    addChild(_frame);
    addChild(_hud);
    addEventCallback(new OverlayKeys(this));
    setNumChildrenRequiringUpdateTraversal(getNumChildrenRequiringUpdateTraversal() + 1);
}

HapticOverlays::HapticOverlays(const HapticOverlays& other, const osg::CopyOp& /*copyop*/) :
    HapticOverlays()
{
    setName(other.getName());
    setNodeMask(other.getNodeMask());
    setShowControlPoints(other.getShowControlPoints());
    setShowFieldSlice(other.getShowFieldSlice());
    setShowArray(other.getShowArray());
    setShowWorkspace(other.getShowWorkspace());
    setShowFigures(other.getShowFigures());
    setShowFieldVolume(other.getShowFieldVolume());
    setShowHands(other.getShowHands());
}

HapticOverlays::~HapticOverlays() = default;

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
    for (const Keyed& each : allOf(_overlays))
        OverlayPart::of(*each.overlay).setArray(array, medium);
}

std::shared_ptr<const midair::bridge::HologramResult> OverlayFeed::follow(const osg::NodePath& path)
{
    HapticScene* scene = nullptr; // the outermost: it plays what is in those inside it
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
        _overlays.getHud()->setTitle(of + scene->getArray() + " (" + std::to_string(array->size()) +
                                     " transducers)");
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
    for (const Keyed& each : allOf(_overlays))
    {
        Overlay* overlay = each.overlay;
        // One that was just switched on gets what the others have long had.
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
    const auto all = allOf(*overlays);
    const int key = event.getKey();
    for (const Keyed& each : all)
        if (each.key == key)
        {
            each.overlay->setShown(!each.overlay->isShown());
            return true;
        }
    if (key != Keys::KEY_F7) return false;
    const bool anyShown = std::any_of(
        all.begin(), all.end(), [](const Keyed& each) { return each.overlay->isShown(); });
    for (const Keyed& each : all)
        each.overlay->setShown(!anyShown);
    return true;
}

void OverlayKeys::getUsage(osg::ApplicationUsage& usage) const
{
    osg::ref_ptr<HapticOverlays> overlays;
    if (!_overlays.lock(overlays)) return;
    for (const Keyed& each : allOf(*overlays))
        usage.addKeyboardMouseBinding(each.name, std::string("Haptics: show or hide ") + each.what);
    usage.addKeyboardMouseBinding("F7", "Haptics: show or hide all overlays");
}

} // namespace osgMidair
