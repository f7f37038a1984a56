#include "haptics/base/text/Number.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "plugin/hands/KitHands.h"
#include "plugin/hands/MouseSource.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/settings/Grants.h"

#include <osgMidair/FieldSliceOverlay>
#include <osgMidair/FieldVolumeOverlay>
#include <osgMidair/HapticOverlays>
#include <osgMidair/Hud>

#include <osg/Notify>
#include <osgGA/EventVisitor>
#include <osgUtil/CullVisitor>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using Keys = osgGA::GUIEventAdapter;

/// Returns how far the mouse's hand is, once the wheel has moved it; empty: no such hand.
std::string noteOf(const midair::bridge::HandTracker& tracker)
{
    const auto* mouse = dynamic_cast<const MouseSource*>(KitHands::of(tracker.active().get()));
    return mouse ? mouse->depthText() : std::string();
}

} // namespace

HapticOverlays::HapticOverlays() :
    _feed(std::make_unique<OverlayFeed>(*this)),
    _frame(new osg::MatrixTransform)
{
    for (const auto& [place, kind] : overlayKinds())
    {
        _parts.push_back({&kind, kind.make()});
        if (kind.isHidden) _parts.back().overlay->setShown(false);
    }
    _hud = get<Hud>();
    if (!_hud) _hud = new Hud; // if the kind was refused: never added to the scene
    _hud->setFieldSlice(get<FieldSliceOverlay>());
    _hud->setFieldVolume(get<FieldVolumeOverlay>());
    _banner = _hud->makeBanner();

    std::vector<Part> layers = _parts;
    std::stable_sort(layers.begin(),
                     layers.end(),
                     [](const Part& a, const Part& b) { return a.kind->layer < b.kind->layer; });
    _frame->setDataVariance(DYNAMIC);
    addChild(_frame);
    for (const Part& each : layers)
        (each.kind->layer == 0 ? static_cast<osg::Group*>(this) : _frame.get())
            ->addChild(each.overlay);
    addChild(_banner);
    // The keys are handled in traverse(): an event callback would be saved in files, and replace
    // that of the overlays read from them.
    setNumChildrenRequiringEventTraversal(getNumChildrenRequiringEventTraversal() + 1);
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
        if (each.kind->isNamed(name)) return each.overlay.get();
    return nullptr;
}

bool HapticOverlays::setShown(const std::string& name, bool shown)
{
    Overlay* overlay = getOverlay(name);
    if (overlay) overlay->setShown(shown);
    std::string error;
    if (!overlay && !findOverlayKind(name, error))
        OSG_WARN << "osgMidair: " << printable(error) << std::endl;
    return overlay != nullptr;
}

bool HapticOverlays::isShown(const std::string& name) const
{
    const Overlay* overlay = getOverlay(name);
    return overlay && overlay->isShown();
}

std::string HapticOverlays::showOnly(const std::vector<std::string>& names)
{
    std::string error;
    std::vector<const OverlayKind*> shown;
    for (const std::string& name : names)
    {
        if (name == "none") continue;
        shown.push_back(findOverlayKind(name, error));
        if (!shown.back()) return error;
    }
    for (const Part& each : _parts)
        each.overlay->setShown(std::count(shown.begin(), shown.end(), each.kind) > 0);
    return {};
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

std::vector<OverlayDescription> HapticOverlays::describe()
{
    std::vector<OverlayDescription> all;
    for (const auto& [place, kind] : overlayKinds())
    {
        OverlayDescription& one = all.emplace_back();
        one.name = kind.name;
        one.word = kind.word;
        one.help = kind.what;
        one.seen = kind.seen;
        one.key = kind.keyName();
        const osg::ref_ptr<Overlay> fresh = kind.make(); // with the defaults
        one.node = fresh->className();
        for (const OverlayNumber& number : kind.numbers)
        {
            SettingDescription& said = one.numbers.emplace_back();
            said.name = number.name;
            said.help = number.help;
            said.values = number.numbers();
            said.unit = number.unit;
            said.initial = midair::base::shortNumber(number.get(*fresh));
            said.summary = said.help + " (" + said.values + "; default " + said.initial + ")";
            said.low = number.range.low;
            said.high = number.range.high;
        }
    }
    return all;
}

void HapticOverlays::setShowAll(bool shown)
{
    for (const Part& each : _parts)
        if (!shown || !each.kind->isHidden) each.overlay->setShown(shown);
}

bool HapticOverlays::hasKey(int key)
{
    const auto& kinds = overlayKinds();
    return key == Keys::KEY_F1 || key == Keys::KEY_F7 ||
           std::any_of(kinds.begin(),
                       kinds.end(),
                       [key](const auto& kind) { return key != 0 && kind.second.key == key; });
}

std::string HapticOverlays::keyNames()
{
    std::string names = "F1, ";
    for (const auto& [place, kind] : overlayKinds())
        if (kind.key != 0) names += kind.keyName() + ", ";
    return names + "F7";
}

void HapticOverlays::setArrayToParent(const osg::Matrix& matrix)
{
    if (matrix != _frame->getMatrix()) _frame->setMatrix(matrix);
}

OverlayFeed::OverlayFeed(HapticOverlays& overlays) : _overlays(overlays) {}

OverlayFeed& OverlayFeed::of(const HapticOverlays& overlays)
{
    return *overlays._feed;
}

void OverlayFeed::setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                           const midair::haptics::Medium& medium)
{
    for (const HapticOverlays::Part& each : _overlays._parts)
        OverlayPart::of(*each.overlay).setArray(array, medium);
}

std::shared_ptr<const midair::bridge::HologramResult>
OverlayFeed::follow(const HapticEngine& engine, const osg::NodePath& path)
{
    const HapticSettings& settings = engine.settings();
    const auto array = engine.array();
    const midair::haptics::Medium medium = engine.medium();
    if (array && (array != _array || !_medium || !(*_medium == medium)))
    {
        _array = array;
        _medium = medium;
        setArray(array, medium);
        const osg::ref_ptr<osg::Node> root = engine.root();
        const std::string of = !root || root->getName().empty() ? "" : root->getName() + " in ";
        const std::string& name = settings.array.empty() ? array->name : settings.array;
        _overlays._hud->setTitle(fmt::format("{}{} ({} transducers)", of, name, array->size()));
    }
    // With an invalid length nothing is played, and the overlays don't move.
    const double unitsPerMetre = 1.0 / settings.metresPerUnit;
    if (unitsPerMetre > 0.0 && std::isfinite(unitsPerMetre))
        _overlays.setArrayToParent(osg::Matrix::inverse(settings.calibration) *
                                   osg::Matrix::scale(unitsPerMetre, unitsPerMetre, unitsPerMetre) *
                                   osg::computeWorldToLocal(path));
    const midair::bridge::HandTracker& tracker = engine.hands();
    for (const HapticOverlays::Part& each : _overlays._parts)
        if (OverlayPart& part = OverlayPart::of(*each.overlay);
            each.overlay->isShown() && part.followsHands())
        {
            part.setHandNote(noteOf(tracker));
            part.setHands(midair::bridge::handCapsules(tracker.shown()),
                          tracker.proximity().contacts(),
                          tracker.frame().time_s);
        }
    return engine.latestResult();
}

void OverlayFeed::show(const std::shared_ptr<const midair::bridge::HologramResult>& result)
{
    if (!result || _overlays._hud->getPlain()) return;
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

void OverlayFeed::noteSight(osgUtil::CullVisitor& visitor)
{
    unsigned int seen = 0;
    unsigned int bit = 1;
    for (const HapticOverlays::Part& each : _overlays._parts)
    {
        osg::BoundingSphere bound = each.overlay->getBound();
        if (each.kind->layer == 0 || !each.overlay->isShown())
            seen |= bit;
        else if (bound.valid())
        {
            const osg::Matrix& place = _overlays._frame->getMatrix();
            bound.radius() *= static_cast<float>(place.getScale().x());
            bound.center() = osg::Vec3(osg::Vec3d(bound.center()) * place);
            if (!visitor.isCulled(bound)) seen |= bit;
        }
        bit <<= 1;
    }
    _seen |= seen;
}

void OverlayFeed::update(const osg::NodePath& path, double time_s)
{
    if (const unsigned int seen = _seen.exchange(0)) _inSight = seen; // else nothing was drawn
    const osg::ref_ptr<HapticEngine> engine = SceneAccess::playing(path);
    show(engine ? follow(*engine, path) : _shown);
    OverlayPart::of(*_overlays._hud).update(_overlays, engine, time_s);
}

void HapticOverlays::handleKeys(osg::NodeVisitor& visitor)
{
    osgGA::EventVisitor* events = visitor.asEventVisitor();
    if (!events) return;
    for (const auto& event : events->getEvents())
    {
        osgGA::GUIEventAdapter* given = event->asGUIEventAdapter();
        const bool isKey = given && given->getEventType() == Keys::KEYDOWN;
        if (isKey && press(given->getKey())) given->setHandled(true);
    }
}

bool HapticOverlays::press(int key)
{
    if (!hasKey(key) || _hud->getPlain()) return false;
    OverlayPart::of(*_hud).noteKey(key);
    if (key == Keys::KEY_F1) return true;
    for (const Part& each : _parts)
        if (each.kind->key == key)
        {
            each.overlay->setShown(!each.overlay->isShown());
            return true;
        }
    // The first press shows all overlays, even if some are already visible.
    setShowAll(std::any_of(_parts.begin(),
                           _parts.end(),
                           [](const Part& each)
                           { return !each.kind->isHidden && !each.overlay->isShown(); }));
    return true;
}

void HapticOverlays::traverse(osg::NodeVisitor& visitor)
{
    switch (visitor.getVisitorType())
    {
    case osg::NodeVisitor::UPDATE_VISITOR:
        _feed->update(visitor.getNodePath(),
                      visitor.getFrameStamp() ? visitor.getFrameStamp()->getSimulationTime()
                                              : -1.0);
        break;
    case osg::NodeVisitor::EVENT_VISITOR:
        handleKeys(visitor);
        break;
    case osg::NodeVisitor::CULL_VISITOR:
        if (osgUtil::CullVisitor* cull = visitor.asCullVisitor()) _feed->noteSight(*cull);
        if (!_hud->getPlain()) break;
        _banner->accept(visitor);
        return;
    default:
        return;
    }
    osg::Group::traverse(visitor);
}

OverlayKeys::OverlayKeys(HapticOverlays* overlays) : _overlays(overlays) {}

bool OverlayKeys::handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& /*action*/)
{
    osg::ref_ptr<HapticOverlays> overlays;
    return event.getEventType() == Keys::KEYDOWN && !event.getHandled() &&
           _overlays.lock(overlays) && overlays->press(event.getKey());
}

void OverlayKeys::getUsage(osg::ApplicationUsage& usage) const
{
    usage.addKeyboardMouseBinding("F1", "Haptics: list the keys");
    for (const auto& [place, kind] : overlayKinds())
        if (kind.key != 0)
            usage.addKeyboardMouseBinding(kind.keyName(), "Haptics: show or hide " + kind.what);
    usage.addKeyboardMouseBinding("F7", "Haptics: show or hide all overlays");
}

} // namespace osgMidair
