#include "plugin/engine/SceneKeys.h"

#include "plugin/engine/HapticEngine.h"
#include "plugin/settings/UserOptions.h"

#include <osgMidair/HapticOverlays>

#include <osg/Notify>
#include <osgViewer/GraphicsWindow>
#include <osgViewer/View>

#include <vector>

namespace osgMidair
{

namespace
{

/// Returns the overlays below \a root, including hidden ones; null: there are none.
HapticOverlays* findOverlays(osg::Node& root)
{
    if (auto* overlays = dynamic_cast<HapticOverlays*>(&root)) return overlays;
    osg::Group* group = root.asGroup();
    HapticOverlays* found = nullptr;
    for (unsigned int i = 0; group && !found && i < group->getNumChildren(); ++i)
        found = findOverlays(*group->getChild(i));
    return found;
}

/// Returns the overlays below \a root. If there are none, adds hidden ones, which still show that
/// the array is muted; null if \a root can have no children.
HapticOverlays* overlaysOf(osg::Node& root)
{
    if (HapticOverlays* found = findOverlays(root)) return found;
    osg::Group* group = root.asGroup();
    if (!group)
    {
        OSG_NOTICE
            << "osgMidair: overlays need a Group as the root of the haptic scene, and this is a "
            << root.className() << std::endl;
        return nullptr;
    }
    osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
    overlays->setShowAll(false);
    group->addChild(overlays);
    return overlays;
}

} // namespace

SceneKeys::SceneKeys(HapticEngine* engine) : _engine(engine) {}

void SceneKeys::addTo(osgGA::GUIActionAdapter* adapter, HapticEngine& engine)
{
    auto* view = dynamic_cast<osgViewer::View*>(adapter);
    if (!view) return;
    std::vector<osg::ref_ptr<osgGA::EventHandler>> old;
    for (const auto& handler : view->getEventHandlers())
    {
        const auto* keys = dynamic_cast<const SceneKeys*>(handler.get());
        if (keys && keys->_engine == &engine) return;
        if (keys && !keys->_engine.valid()) old.push_back(handler);
    }
    for (const auto& handler : old)
        view->removeEventHandler(handler);
    view->addEventHandler(new SceneKeys(&engine));
}

bool SceneKeys::handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& action)
{
    osg::ref_ptr<HapticEngine> engine;
    const bool isFrame = event.getEventType() == osgGA::GUIEventAdapter::FRAME && !_hasGreeted;
    const bool isKey = event.getEventType() == osgGA::GUIEventAdapter::KEYDOWN;
    // osgviewer's handlers take frames for themselves as well.
    if ((!isKey && !isFrame) || (isKey && event.getHandled()) || !_engine.lock(engine) ||
        engine->isPlayedByAnother())
        return false;
    if (isFrame)
    {
        greet(*engine, action);
        return false;
    }
    const osg::ref_ptr<osg::Node> root = engine->root();
    const int key = event.getKey();
    if (key == osgGA::GUIEventAdapter::KEY_F8)
    {
        engine->setMuted(!engine->isMuted());
        OSG_NOTICE << "osgMidair: the array " << (engine->isMuted() ? "is muted" : "plays")
                   << std::endl;
        if (root) overlaysOf(*root); // they show MUTED
        return true;
    }
    // Existing overlays handle these keys themselves.
    if (!HapticOverlays::hasKey(key) || !root || findOverlays(*root)) return false;
    HapticOverlays* overlays = overlaysOf(*root);
    return overlays && OverlayKeys(overlays).handle(event, action);
}

// Once, for who doesn't know yet what there is. A window that another toolkit owns, or a picture
// without one, is left as it is.
void SceneKeys::greet(HapticEngine& engine, osgGA::GUIActionAdapter& action)
{
    const osg::ref_ptr<osg::Node> root = engine.root();
    const auto* view = dynamic_cast<osgViewer::View*>(&action);
    if (!root || !view || !view->getCamera()) return;
    _hasGreeted = true;
    const auto* window =
        dynamic_cast<const osgViewer::GraphicsWindow*>(view->getCamera()->getGraphicsContext());
    const bool isOwn = window && !dynamic_cast<const osgViewer::GraphicsWindowEmbedded*>(window);
    const bool isTouched = Environment::isByMouse();
    if ((!isOwn && !isTouched) || findOverlays(*root)) return;
    HapticOverlays* overlays = overlaysOf(*root);
    if (overlays && isTouched) overlays->showOnly({"hands", "contacts"});
}

void SceneKeys::getUsage(osg::ApplicationUsage& usage) const
{
    OverlayKeys(nullptr).getUsage(usage);
    usage.addKeyboardMouseBinding("F8", "Haptics: mute or unmute the array");
}

} // namespace osgMidair
