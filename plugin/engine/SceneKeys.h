#pragma once

#include <osg/observer_ptr>
#include <osgGA/GUIEventHandler>

namespace osgMidair
{

class HapticEngine;

/// Handler of the keys that every viewer of a haptic scene gets, be it played by a HapticScene, a
/// HapticCallback or a HapticDevice; listed in its `h` help. F8 mutes the array. The overlay keys
/// add overlays to a scene that has none, of which the key's own is shown. A window whose scene has
/// none gets some that list the keys for a moment, and that show the hand and what it touches where
/// the user's mouse moves one. Handles nothing while another owner plays the scene.
class SceneKeys : public osgGA::GUIEventHandler
{
public:
    explicit SceneKeys(HapticEngine* engine);

    /// Adds the handler to the view behind \a adapter, unless it has one for this engine; removes
    /// handlers of deleted engines.
    static void addTo(osgGA::GUIActionAdapter* adapter, HapticEngine& engine);

    using osgGA::GUIEventHandler::handle;
    bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& action) override;
    void getUsage(osg::ApplicationUsage& usage) const override;

private:
    void greet(HapticEngine& engine, osgGA::GUIActionAdapter& action);

    osg::observer_ptr<HapticEngine> _engine;
    bool _hasGreeted = false;
};

} // namespace osgMidair
