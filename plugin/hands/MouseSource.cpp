#include "plugin/hands/MouseSource.h"

#include <osg/ApplicationUsage>
#include <osg/Camera>
#include <osgGA/GUIEventAdapter>

#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

/// Event handler in a view; inactive once the source is gone.
class MouseEvents : public osgGA::GUIEventHandler
{
public:
    explicit MouseEvents(MouseSource* source) : _source(source) {}

    bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& adapter) override
    {
        osg::ref_ptr<MouseSource> source;
        return _source.lock(source) && source->handle(event, adapter);
    }

    void getUsage(osg::ApplicationUsage& usage) const override
    {
        if (_source.valid()) osg::ref_ptr<MouseHand>(new MouseHand)->getUsage(usage);
    }

private:
    osg::observer_ptr<MouseSource> _source;
};

constexpr double kWheelStep_m = 2e-3;
constexpr int kKey = 't';

/// View direction of a camera, of unit length, in the world.
struct Look
{
    osg::Vec3d ahead;
    osg::Vec3d up;
};

Look lookOf(const osg::Camera& camera)
{
    osg::Vec3d eye;
    osg::Vec3d centre;
    Look look;
    camera.getViewMatrixAsLookAt(eye, centre, look.up);
    look.ahead = centre - eye;
    look.ahead.normalize();
    return look;
}

/// Returns the orientation with the fingers along \a ahead and the back of the hand towards \a up.
osg::Quat turned(const osg::Vec3d& ahead, const osg::Vec3d& up)
{
    const osg::Vec3d z = -ahead;
    osg::Vec3d x = up ^ z;
    x.normalize();
    const osg::Vec3d y = z ^ x;
    return osg::Matrixd(
               x.x(), x.y(), x.z(), 0, y.x(), y.y(), y.z(), 0, z.x(), z.y(), z.z(), 0, 0, 0, 0, 1)
        .getRotate();
}

} // namespace

void MouseSource::attach(osgViewer::View& view, double metresPerUnit, const osg::Vec3d& depthPoint)
{
    const bool isKnown = _mouse && _view.get() == &view;
    if (isKnown && metresPerUnit == _metresPerUnit) return;
    _mouse = new MouseHand(metresPerUnit, depthPoint);
    _metresPerUnit = metresPerUnit;
    _isMovedInDepth = false;
    _depth_m = 0.0;
    if (isKnown) return;
    _view = &view;
    view.addEventHandler(new MouseEvents(this));
}

bool MouseSource::getHands(double time, std::vector<Hand>& hands)
{
    hands.clear();
    if (!_mouse && _waited <= kPatience) ++_waited;
    if (!_isMoved) waitAside();
    return _mouse && _mouse->getHandSource()->getHands(time, hands);
}

std::string MouseSource::getStatus() const
{
    return _mouse ? "mouse: follows the mouse" : "mouse: there is no viewer";
}

std::vector<std::string> MouseSource::takeMessages()
{
    if (_mouse || _waited != kPatience) return {};
    ++_waited;
    return {"hand source \"mouse:\": there is no viewer whose mouse it can follow, so there is no "
            "hand"};
}

bool MouseSource::handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& adapter)
{
    using Event = osgGA::GUIEventAdapter;
    const int type = event.getEventType();
    _isMoved = _isMoved || type == Event::MOVE || type == Event::DRAG;
    if (!_mouse) return false;
    const osg::Vec3d before = _mouse->getDepthPoint();
    const bool isHandled = _mouse->handle(event, adapter);
    const auto* view = dynamic_cast<osgViewer::View*>(&adapter);
    if (view && view->getCamera() && _mouse->getDepthPoint() != before)
    {
        _depth_m += _metresPerUnit *
                    ((_mouse->getDepthPoint() - before) * lookOf(*view->getCamera()).ahead);
        _isMovedInDepth = true;
    }
    return isHandled;
}

std::string MouseSource::depthText() const
{
    if (!_isMovedInDepth) return {};
    const long depth_mm = std::lround(1e3 * _depth_m);
    if (depth_mm == 0) return "in the middle";
    return fmt::format(
        "{} mm {} the middle", std::abs(depth_mm), depth_mm > 0 ? "behind" : "before");
}

// As if the mouse were there, however the camera has moved by now.
void MouseSource::waitAside()
{
    osgViewer::View* const view = _view.get(); // mostly on a stack, where it can't be locked
    if (!_mouse || !view) return;
    const osg::ref_ptr<osgGA::GUIEventAdapter> event = new osgGA::GUIEventAdapter;
    event->setEventType(osgGA::GUIEventAdapter::MOVE);
    event->setInputRange(-1.0F, -1.0F, 1.0F, 1.0F);
    event->setX(0.7F);
    event->setY(-0.7F);
    _mouse->handle(*event, *view);
}

MouseHand::MouseHand(double metresPerUnit, const osg::Vec3d& depthPoint) :
    _hands(new InjectedHands),
    _metresPerUnit(metresPerUnit),
    _depthPoint(depthPoint)
{
}

void MouseHand::follow(const osgGA::GUIEventAdapter& event, const osg::Camera& camera)
{
    const osg::Matrixd toWorld =
        osg::Matrixd::inverse(camera.getViewMatrix() * camera.getProjectionMatrix());
    const osg::Vec3d near =
        osg::Vec3d(event.getXnormalized(), event.getYnormalized(), -1.0) * toWorld;
    const osg::Vec3d far =
        osg::Vec3d(event.getXnormalized(), event.getYnormalized(), 1.0) * toWorld;
    const auto [ahead, up] = lookOf(camera);
    const double along = (far - near) * ahead;
    if (!(std::abs(along) > 0.0)) return;
    const osg::Vec3d tip = near + (far - near) * (((_depthPoint - near) * ahead) / along);
    if (!tip.valid()) return;
    // The wrist is at the lower right, so that the hand hides neither its fingertips nor what they
    // touch.
    osg::Vec3d fingers = ahead * 0.55 + up * 0.65 - (ahead ^ up) * 0.5;
    fingers.normalize();
    _hands->setHands({openHand(1, tip * _metresPerUnit, turned(fingers, up - ahead))});
}

bool MouseHand::handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& adapter)
{
    using Event = osgGA::GUIEventAdapter;
    const auto* view = dynamic_cast<osgViewer::View*>(&adapter);
    if (!view || !view->getCamera()) return false;
    const osg::Camera& camera = *view->getCamera();
    const int type = event.getEventType();
    if (type == Event::KEYDOWN && event.getKey() == kKey)
    {
        _shown = !_shown;
        if (!_shown) _hands->setHands({});
        return true;
    }
    const bool wheel = type == Event::SCROLL && (event.getModKeyMask() & Event::MODKEY_CTRL);
    if (wheel)
    {
        const double sign = event.getScrollingMotion() == Event::SCROLL_UP ? 1.0 : -1.0;
        _depthPoint += lookOf(camera).ahead * (sign * kWheelStep_m / _metresPerUnit);
    }
    if (_shown && (wheel || type == Event::MOVE || type == Event::DRAG)) follow(event, camera);
    return wheel;
}

void MouseHand::getUsage(osg::ApplicationUsage& usage) const
{
    usage.addKeyboardMouseBinding("t", "osgMidair: hide or show the mouse hand");
    usage.addKeyboardMouseBinding("Ctrl+wheel", "osgMidair: move the mouse hand in depth");
}

} // namespace osgMidair
