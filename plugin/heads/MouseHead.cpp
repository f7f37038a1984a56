#include "plugin/heads/MouseHead.h"

#include <osg/ApplicationUsage>
#include <osg/Camera>
#include <osgGA/GUIEventHandler>

namespace osgMidair
{

namespace
{

/// Event handler in a view; inactive once the source is gone.
class MouseHeadEvents : public osgGA::GUIEventHandler
{
public:
    explicit MouseHeadEvents(MouseHead* source) : _source(source) {}

    bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& /*adapter*/) override
    {
        osg::ref_ptr<MouseHead> source;
        return _source.lock(source) && source->handle(event);
    }

    void getUsage(osg::ApplicationUsage& usage) const override
    {
        if (_source.valid())
            usage.addKeyboardMouseBinding("Alt+wheel", "osgMidair: move the mouse head in depth");
    }

private:
    osg::observer_ptr<MouseHead> _source;
};

} // namespace

void MouseHead::attach(osgViewer::View& view, double metresPerUnit)
{
    if (_view.get() == &view || !view.getCamera()) return;
    _view = &view;
    const osg::Matrixd toWorld = view.getCamera()->getInverseViewMatrix();
    _begin = toWorld.getTrans() * metresPerUnit;
    _orientation = toWorld.getRotate();
    _moved = osg::Vec3d();
    _isKnown = true;
    view.addEventHandler(new MouseHeadEvents(this));
}

bool MouseHead::getHead(double /*time*/, Head& head)
{
    if (!_isKnown && _waited <= kPatience) ++_waited;
    head = {_begin + _orientation * _moved, _orientation, 0.0};
    return _isKnown;
}

std::string MouseHead::getStatus() const
{
    return _isKnown ? "mouse: the head follows the mouse" : "mouse: there is no viewer";
}

std::vector<std::string> MouseHead::takeMessages()
{
    if (_isKnown || _waited != kPatience) return {};
    ++_waited;
    return {"head source \"mouse:\": there is no viewer whose mouse it can follow, so there is no "
            "head"};
}

bool MouseHead::handle(const osgGA::GUIEventAdapter& event)
{
    using Event = osgGA::GUIEventAdapter;
    const int type = event.getEventType();
    if (type == Event::MOVE || type == Event::DRAG)
    {
        _moved.x() = kAside_m * event.getXnormalized();
        _moved.y() = kAside_m * event.getYnormalized();
    }
    const bool isWheel = type == Event::SCROLL && (event.getModKeyMask() & Event::MODKEY_ALT) != 0;
    if (isWheel)
        _moved.z() += event.getScrollingMotion() == Event::SCROLL_UP ? -kWheelStep_m : kWheelStep_m;
    return isWheel;
}

} // namespace osgMidair
