#include "plugin/hands/MouseSource.h"

#include <osg/ApplicationUsage>
#include <osg/Camera>
#include <osgGA/GUIEventAdapter>

#include <cmath>

namespace osgMidair
{

namespace
{

/// Handler in a view; it does nothing once the source is gone.
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

/// Where a camera looks, of unit length, in the world.
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
    if (isKnown) return;
    _view = &view;
    view.addEventHandler(new MouseEvents(this));
}

bool MouseSource::getHands(double time, std::vector<Hand>& hands)
{
    hands.clear();
    if (!_mouse && _waited <= kPatience) ++_waited;
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
    return _mouse && _mouse->handle(event, adapter);
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
    _hands->setHands({openHand(1, tip * _metresPerUnit, turned(ahead, up))});
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
    usage.addKeyboardMouseBinding("t", "osgMidair: take the mouse's hand away, bring it back");
    usage.addKeyboardMouseBinding("Ctrl+wheel", "osgMidair: move the mouse's hand in depth");
}

} // namespace osgMidair
