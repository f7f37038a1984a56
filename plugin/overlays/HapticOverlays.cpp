#include "haptics/Medium.h"
#include "haptics/TransducerArray.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>

#include <osg/Transform>

#include <array>

namespace osgMidair
{

namespace
{

std::array<Overlay*, 5> allOf(HapticOverlays& overlays)
{
    return {overlays.getControlPoints(),
            overlays.getFieldSlice(),
            overlays.getArray(),
            overlays.getWorkspace(),
            overlays.getHud()};
}

} // namespace

HapticOverlays::HapticOverlays() :
    _frame(new osg::MatrixTransform),
    _points(new ControlPointOverlay),
    _slice(new FieldSliceOverlay),
    _array(new ArrayGhost),
    _workspace(new WorkspaceBox),
    _hud(new Hud)
{
    _frame->setDataVariance(DYNAMIC);
    _frame->addChild(_array);
    _frame->addChild(_workspace);
    _frame->addChild(_slice);
    _frame->addChild(_points);
    _hud->setFieldSlice(_slice);
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
}

HapticOverlays::~HapticOverlays() = default;

void HapticOverlays::setSource(Source source)
{
    _source = std::move(source);
}

void HapticOverlays::setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                              const midair::haptics::Medium& medium)
{
    for (Overlay* overlay : allOf(*this))
        overlay->setArray(array, medium);
}

void HapticOverlays::setArrayToParent(const osg::Matrix& matrix)
{
    if (matrix != _frame->getMatrix()) _frame->setMatrix(matrix);
}

std::shared_ptr<const midair::bridge::HologramResult>
HapticOverlays::follow(const osg::NodePath& path)
{
    const HapticScene* scene = nullptr;
    for (osg::Node* node : path)
        if (const auto* found = dynamic_cast<HapticScene*>(node)) scene = found;
    if (!scene) return _shown;
    const auto array = scene->getTransducerArray();
    const midair::haptics::Medium medium = scene->getMedium();
    if (array && (array != _followedArray || !_followedMedium || !(*_followedMedium == medium)))
    {
        _followedArray = array;
        _followedMedium = std::make_unique<midair::haptics::Medium>(medium);
        setArray(array, medium);
        const std::string of = scene->getName().empty() ? "" : scene->getName() + " in ";
        _hud->setTitle(of + scene->getArray() + " (" + std::to_string(array->size()) +
                       " transducers)");
    }
    const double unitsPerMetre = 1.0 / scene->getMetresPerUnit();
    setArrayToParent(osg::Matrix::inverse(scene->getCalibration()) *
                     osg::Matrix::scale(unitsPerMetre, unitsPerMetre, unitsPerMetre) *
                     osg::computeWorldToLocal(path));
    return scene->getLatestResult();
}

void HapticOverlays::show(const std::shared_ptr<const midair::bridge::HologramResult>& result)
{
    if (!result) return;
    if (result != _shown) _shownMask = 0;
    _shown = result;
    unsigned int bit = 1;
    for (Overlay* overlay : allOf(*this))
    {
        // One that was just switched on gets what the others have long had.
        if (overlay->isShown() && !(_shownMask & bit))
        {
            overlay->setResult(result);
            _shownMask |= bit;
        }
        bit <<= 1;
    }
}

void HapticOverlays::traverse(osg::NodeVisitor& visitor)
{
    switch (visitor.getVisitorType())
    {
    case osg::NodeVisitor::UPDATE_VISITOR:
        show(_source ? _source() : follow(visitor.getNodePath()));
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
    const std::array<Overlay*, 5> all = allOf(*overlays);
    const int key = event.getKey() - osgGA::GUIEventAdapter::KEY_F2;
    if (key < 0 || key > static_cast<int>(all.size())) return false;
    if (key < static_cast<int>(all.size()))
    {
        all[key]->setShown(!all[key]->isShown());
        return true;
    }
    bool anyShown = false;
    for (const Overlay* overlay : all)
        anyShown = anyShown || overlay->isShown();
    for (Overlay* overlay : all)
        overlay->setShown(!anyShown);
    return true;
}

void OverlayKeys::getUsage(osg::ApplicationUsage& usage) const
{
    usage.addKeyboardMouseBinding("F2", "Haptics: show or hide the control points");
    usage.addKeyboardMouseBinding("F3", "Haptics: show or hide the slice of the field");
    usage.addKeyboardMouseBinding("F4", "Haptics: show or hide the array");
    usage.addKeyboardMouseBinding("F5", "Haptics: show or hide the workspace");
    usage.addKeyboardMouseBinding("F6", "Haptics: show or hide the figures");
    usage.addKeyboardMouseBinding("F7", "Haptics: show or hide all overlays");
}

} // namespace osgMidair
