#include "plugin/hands/MouseSource.h"

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

} // namespace osgMidair
