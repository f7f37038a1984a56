#pragma once

#include <osg/observer_ptr>
#include <osgGA/GUIEventHandler>

namespace osgMidair
{

class HapticScene;

/// Keys that every viewer of a haptic scene has, listed by its `h` help: those of overlays bring
/// them in where the scene has none, F8 mutes the array.
class SceneKeys : public osgGA::GUIEventHandler
{
public:
    explicit SceneKeys(HapticScene* scene);

    /// Gives the keys to the view behind \a adapter, once.
    static void addTo(osgGA::GUIActionAdapter* adapter, HapticScene& scene);

    bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& action) override;
    void getUsage(osg::ApplicationUsage& usage) const override;

private:
    osg::observer_ptr<HapticScene> _scene;
};

} // namespace osgMidair
