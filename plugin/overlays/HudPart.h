#pragma once

#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/hud/HudRoom.h"
#include "plugin/overlays/hud/HudSheets.h"
#include "plugin/overlays/hud/SkinTrace.h"

#include <osgMidair/Hud>

#include <osg/observer_ptr>

#include <string>
#include <vector>

namespace osgMidair
{

/// Implementation of Hud: keeps what is to be said, draws it into the sheets of every layout, and
/// when a view is culled chooses the layout for the room there. Its functions are called on the
/// update thread, cullFigures() and cullBanner() on those that cull.
class HudPart : public OverlayPart
{
public:
    HudPart();

    static HudPart& of(Hud& hud) { return static_cast<HudPart&>(OverlayPart::of(hud)); }

    void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result) override;

    /// Called in every frame of \a overlays, the figures shown or not; \a engine plays them, null:
    /// none does. Changes the figures once per interval, and at once when the array is muted. \a
    /// time_s: the frame's simulation time; below 0: unknown, keys are not listed then.
    void update(const HapticOverlays& overlays, const HapticEngine* engine, double time_s);
    /// Lists the keys for a while.
    void noteKey() { _hasKey = true; }

    /// Draws figures, messages and scales at the bottom.
    void cullFigures(osgUtil::CullVisitor& visitor, float scale);
    /// Draws keys and alarm at the top.
    void cullBanner(osgUtil::CullVisitor& visitor, float scale);

    std::string title = "osgMidair";
    osg::observer_ptr<FieldSliceOverlay> slice;
    osg::observer_ptr<FieldVolumeOverlay> volume;
    double updateInterval_s = 0.25;
    double keyTime_s = 8.0;
    bool isPlain = false;
    double frameRate = 0.0;

private:
    /// \a result: null before the first field.
    void drawFigures(const HapticOverlays& overlays,
                     const std::shared_ptr<const midair::bridge::HologramResult>& result);
    void drawAlarm(HudAlarm alarm);
    void drawKeys(const HapticOverlays& overlays, double time_s);

    std::vector<HudSheets> _layouts; ///< as kHudLayouts
    pixels::Sparkline _error{"error rms", "%"};
    pixels::Sparkline _latency{"latency", "ms"};
    SkinTrace _skin;
    std::shared_ptr<const midair::bridge::HologramResult> _result;
    ArrayNews _news;
    HudAlarm _alarm;              ///< that is drawn
    std::vector<bool> _keysDrawn; ///< which overlays were on when the keys were; empty: not drawn
    bool _hasKey = true;          ///< keys are to be listed from now on
    double _keysSince_s = -1.0;   ///< below 0: they aren't
    double _lastUpdate_s = 0.0;
    int _frames = 0;
};

/// What a Hud says even while it is hidden: keys, and in large letters what is not as it should be.
class HudBanner : public osg::Group
{
public:
    explicit HudBanner(Hud* hud);

    void traverse(osg::NodeVisitor& visitor) override;
    /// Returns an empty bound, as it takes no space in the scene.
    osg::BoundingSphere computeBound() const override { return {}; }

private:
    const osg::ref_ptr<Hud> _hud;
};

} // namespace osgMidair
