#pragma once

#include <osg/observer_ptr>
#include <osgGA/GUIEventHandler>

namespace osgMidair
{

class HapticScene;

/// Handler of the keys that every viewer of a haptic scene gets, listed in its `h` help: the
/// overlay keys add overlays to a scene that has none, F8 mutes the array.
class SceneKeys : public osgGA::GUIEventHandler
{
public:
    explicit SceneKeys(HapticScene* scene);

    /// Adds the handler to the view behind \a adapter, unless it has one for this scene.
    static void addTo(osgGA::GUIActionAdapter* adapter, HapticScene& scene);

    bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& action) override;
    void getUsage(osg::ApplicationUsage& usage) const override;

private:
    osg::observer_ptr<HapticScene> _scene;
};

} // namespace osgMidair
