#include "plugin/engine/SceneKeys.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/HapticScene>

#include <osg/Notify>
#include <osgViewer/View>

namespace osgMidair
{

namespace
{

bool hasOverlays(const HapticScene& scene)
{
    for (unsigned int i = 0; i < scene.getNumChildren(); ++i)
        if (dynamic_cast<const HapticOverlays*>(scene.getChild(i))) return true;
    return false;
}

} // namespace

SceneKeys::SceneKeys(HapticScene* scene) : _scene(scene) {}

void SceneKeys::addTo(osgGA::GUIActionAdapter* adapter, HapticScene& scene)
{
    auto* view = dynamic_cast<osgViewer::View*>(adapter);
    if (!view) return;
    for (const auto& handler : view->getEventHandlers())
    {
        const auto* keys = dynamic_cast<const SceneKeys*>(handler.get());
        if (keys && keys->_scene == &scene) return;
    }
    view->addEventHandler(new SceneKeys(&scene));
}

bool SceneKeys::handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter&)
{
    osg::ref_ptr<HapticScene> scene;
    if (event.getEventType() != osgGA::GUIEventAdapter::KEYDOWN || !_scene.lock(scene))
        return false;
    const int key = event.getKey();
    if (key == osgGA::GUIEventAdapter::KEY_F8)
    {
        scene->setEnabled(!scene->getEnabled());
        OSG_NOTICE << "osgMidair: the array " << (scene->getEnabled() ? "plays" : "is muted")
                   << std::endl;
        return true;
    }
    // Existing overlays handle these keys themselves.
    if (!HapticOverlays::hasKey(key) || hasOverlays(*scene)) return false;
    scene->addChild(new HapticOverlays);
    return true;
}

void SceneKeys::getUsage(osg::ApplicationUsage& usage) const
{
    usage.addKeyboardMouseBinding(HapticOverlays::keyNames(),
                                  "Haptics: bring in the overlays; then each its own");
    usage.addKeyboardMouseBinding("F8", "Haptics: mute the array, or let it play again");
}

} // namespace osgMidair
