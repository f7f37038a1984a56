#include "plugin/overlays/HudPart.h"
#include "plugin/overlays/OverlayKinds.h"
#include "plugin/overlays/drawing/DiscGeometry.h"

#include <osgMidair/Hud>

#include <osgGA/GUIEventAdapter>
#include <osgUtil/CullVisitor>

namespace osgMidair
{

namespace
{

const OverlayNumber kScale = overlayNumber<Hud, &Hud::setScale, &Hud::getScale>(
    "figuresScale", "pixels per unit of the figures; 0: follows the viewport's size", {0.0, 20.0});
const OverlayNumber kInterval =
    overlayNumber<Hud, &Hud::setUpdateInterval, &Hud::getUpdateInterval>(
        "figuresInterval", "shortest time between two changes of the figures", {0.0, 60.0}, "s");
const OverlayNumber kKeyTime = overlayNumber<Hud, &Hud::setKeyTime, &Hud::getKeyTime>(
    "keyTime",
    "how long the keys are listed after the start and after one of them; 0: never",
    {0.0, 3600.0},
    "s");
const OverlayNumber kPlain = overlayNumber<Hud, &Hud::setPlain, &Hud::getPlain>(
    "plain",
    "1: for visitors: no overlay is drawn and no key shows one; F8 mutes, and MUTED is seen",
    {1.0, 1.0, true});
const OverlayRegistration
    kHudRegistration({5,
                      "Figures",
                      "figures",
                      "the figures",
                      "figures and messages, the course of error and latency, the scales of what "
                      "is shown; as much as there is room for",
                      osgGA::GUIEventAdapter::KEY_F6,
                      0,
                      makeOverlay<Hud>,
                      {kScale, kInterval, kKeyTime, kPlain}});

} // namespace

Hud::Hud() : Overlay(std::make_unique<HudPart>()), _part(HudPart::of(*this))
{
    pixels::paintInOrder(*this, HUD_BIN);
}

Hud::~Hud() = default;

void Hud::setTitle(const std::string& title)
{
    _part.title = title;
}

void Hud::setScale(float scale)
{
    _scale = scale;
}

float Hud::scaleFor(double width, double height)
{
    return static_cast<float>(hudScale(width, height));
}

void Hud::setFieldSlice(FieldSliceOverlay* slice)
{
    _part.slice = slice;
}

void Hud::setFieldVolume(FieldVolumeOverlay* volume)
{
    _part.volume = volume;
}

double Hud::getUpdateInterval() const
{
    return _part.updateInterval_s;
}

void Hud::setUpdateInterval(double interval_s)
{
    _part.updateInterval_s = interval_s;
}

void Hud::setKeyTime(double time_s)
{
    _part.keyTime_s = time_s;
}

double Hud::getKeyTime() const
{
    return _part.keyTime_s;
}

void Hud::setPlain(bool plain)
{
    _part.isPlain = plain;
}

bool Hud::getPlain() const
{
    return _part.isPlain;
}

double Hud::getFrameRate() const
{
    return _part.frameRate;
}

// The HUD takes no space in the scene.
osg::BoundingSphere Hud::computeBound() const
{
    return {};
}

void Hud::traverse(osg::NodeVisitor& visitor)
{
    osgUtil::CullVisitor* cull = visitor.asCullVisitor();
    if (cull && cull->getViewport()) _part.cullFigures(*cull, _scale);
}

} // namespace osgMidair
