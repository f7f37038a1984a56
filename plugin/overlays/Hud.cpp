#include "haptics/base/threads/SteadyClock.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/hud/HudRoom.h"
#include "plugin/overlays/hud/HudSheets.h"
#include "plugin/overlays/hud/SkinTrace.h"

#include <osgMidair/HapticOverlays>
#include <osgMidair/Hud>

#include <osgGA/GUIEventAdapter>
#include <osgUtil/CullVisitor>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace osgMidair
{

namespace
{

const OverlayNumber kScale = overlayNumber<Hud, &Hud::setScale, &Hud::getScale>(
    "figuresScale", "pixels per unit of the figures; 0: follows the viewport's size", {0.0, 20.0});
const OverlayNumber kInterval =
    overlayNumber<Hud, &Hud::setUpdateInterval, &Hud::getUpdateInterval>(
        "figuresInterval", "shortest time between two changes of the figures", {0.0, 60.0}, "s");
const OverlayNumber kKeyTime = overlayNumber<Hud, &Hud::setKeyTime, &Hud::getKeyTime>(
    "keyTime",
    "how long the keys are listed after the start and after one of them; 0: never",
    {0.0, 3600.0},
    "s");
const OverlayNumber kPlain = overlayNumber<Hud, &Hud::setPlain, &Hud::getPlain>(
    "plain",
    "1: for visitors: no overlay is drawn and no key shows one; F8 mutes, and MUTED is seen",
    {1.0, 1.0, true});
const OverlayRegistration
    kHudRegistration({5,
                      "Figures",
                      "figures",
                      "the figures",
                      "figures and messages, the course of error and latency, the scales of what "
                      "is shown; as much as there is room for",
                      osgGA::GUIEventAdapter::KEY_F6,
                      0,
                      makeOverlay<Hud>,
                      {kScale, kInterval, kKeyTime, kPlain}});

constexpr float kHudMargin = 10.0F;
constexpr float kGap = 4.0F;

/// Draws sheets in pixels of a viewport. The scene graph is not changed, as views may cull at the
/// same time: each pushes its own matrices.
class SheetCull
{
public:
    SheetCull(osgUtil::CullVisitor& visitor, const HudRoom& room) :
        _visitor(visitor),
        _mode(visitor.getComputeNearFarMode())
    {
        visitor.setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
        // Where the scene is drawn for eyes that see it in a mirror, so is this.
        const osg::RefMatrix* before = visitor.getProjectionMatrix();
        const double side = before && (*before)(0, 0) < 0.0 ? -1.0 : 1.0;
        visitor.pushProjectionMatrix(new osg::RefMatrix(
            osg::Matrix::ortho2D(0.0, room.viewport.x(), 0.0, room.viewport.y()) *
            osg::Matrix::scale(side, 1.0, 1.0)));
    }
    ~SheetCull()
    {
        _visitor.popProjectionMatrix();
        _visitor.setComputeNearFarMode(_mode);
    }
    SheetCull(const SheetCull&) = delete;
    SheetCull& operator=(const SheetCull&) = delete;

    /// Whole pixels keep letters sharp.
    void draw(const HudSheet& sheet, const osg::Vec2& lowerLeft, double scale)
    {
        if (sheet.size.x() <= 0.0F) return;
        const auto whole = [&](double at) { return std::round(at * scale) / scale; };
        _visitor.pushModelViewMatrix(new osg::RefMatrix(osg::Matrix::translate(
                                         whole(lowerLeft.x()), whole(lowerLeft.y()), 0.0)),
                                     osg::Transform::ABSOLUTE_RF);
        sheet.panel->accept(_visitor);
        _visitor.popModelViewMatrix();
    }

private:
    osgUtil::CullVisitor& _visitor;
    const osg::CullSettings::ComputeNearFarMode _mode;
};

/// Returns the number of the largest layout for \a room; below 0: there is too little even for the
/// smallest.
int layoutFor(const HudRoom& room)
{
    int found = -1;
    for (const HudLayout& layout : kHudLayouts)
        if (room.width() >= layout.width && room.height() >= layout.height) ++found;
    return found;
}

/// Height of \a sheet with the gap around it; 0: nothing is drawn.
float heightOf(const HudSheet& sheet)
{
    return sheet.size.y() > 0.0F ? sheet.size.y() + kGap : 0.0F;
}

} // namespace

/// Keeps what is to be said, draws it into the sheets of every layout, and when a view is culled
/// chooses the layout for the room there.
class Hud::Part : public OverlayPart
{
public:
    explicit Part(Hud& owner) : _owner(owner), _layouts(kHudLayouts.begin(), kHudLayouts.end()) {}

    void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result) override
    {
        _result = result;
        _error.add(100.0 * result->report().rms);
        _latency.add(result->latency_ms);
    }

    /// Changes the figures once per interval, and at once when the array is muted.
    void update(const HapticOverlays& overlays, const HapticEngine* engine, double time_s) override
    {
        ++_frames;
        drawKeys(overlays, time_s);
        const double now_s = midair::base::steadySeconds();
        const bool isMuted = engine && engine->isMuted();
        const bool isShown = overlays.isShown("figures") && !_owner._isPlain;
        if (now_s - _lastUpdate_s < _owner._updateInterval_s && isMuted == _news.isMuted) return;
        if (_lastUpdate_s > 0.0)
            _owner._frameRate = _frames / std::max(1e-9, now_s - _lastUpdate_s);
        _frames = 0;
        _lastUpdate_s = now_s;
        auto result = _result;
        if (engine)
        {
            _news.statistics = engine->statistics();
            _news.isMuted = isMuted;
            _news.isEnabled = engine->mayPlay();
            result = engine->latestResult();
        }
        else if (result)
            _news = newsOf(*result);
        const bool isKnown = engine ? _news.statistics.frames > 0 : result != nullptr;
        HudAlarm alarm = isKnown ? alarmOf(_news, result.get()) : HudAlarm();
        // Hidden figures and visitors leave what is only told to those who look after the array.
        const bool isSaid =
            isShown || alarm.word == "MUTED" || (alarm.word == "LOST" && !_owner._isPlain);
        drawAlarm(isSaid ? std::move(alarm) : HudAlarm());
        if (!isShown || !isKnown) return;
        _skin.update(result, engine, _lastUpdate_s);
        drawFigures(overlays, result);
    }

    void noteKey() override { _hasKey = true; }

    /// Draws figures, messages and scales at the bottom.
    void cullFigures(osgUtil::CullVisitor& visitor)
    {
        const HudRoom room = roomOf(visitor, _owner._scale);
        const int layout = layoutFor(room);
        if (layout < 0) return;
        const HudSheets& sheets = _layouts[static_cast<std::size_t>(layout)];
        SheetCull cull(visitor, room);
        const osg::Vec2 corner = room.lowerLeft + osg::Vec2(kHudMargin, kHudMargin);
        cull.draw(sheets.figures, corner, room.scale);
        const float above = sheets.figures.size.y() + kGap;
        const float used =
            above + heightOf(sheets.keys) + heightOf(sheets.alarm) + 2.0F * kHudMargin;
        if (used + sheets.messages.size.y() <= room.height())
            cull.draw(sheets.messages, corner + osg::Vec2(0.0F, above), room.scale);
        const float beside = sheets.figures.size.x() + sheets.scales.size.x() + 3.0F * kHudMargin;
        if (beside <= room.width())
            cull.draw(sheets.scales,
                      {room.upperRight.x() - kHudMargin - sheets.scales.size.x(), corner.y()},
                      room.scale);
    }

    /// Draws keys and alarm at the top.
    void cullBanner(osgUtil::CullVisitor& visitor)
    {
        const HudRoom room = roomOf(visitor, _owner._scale);
        const HudSheets& sheets = _layouts[static_cast<std::size_t>(std::max(0, layoutFor(room)))];
        SheetCull cull(visitor, room);
        // It is seen even where there is no room for it.
        float top = std::max(room.upperRight.y() - kHudMargin, heightOf(sheets.alarm) + kHudMargin);
        if (room.height() >= heightOf(sheets.keys) + heightOf(sheets.alarm) + 2.0F * kHudMargin)
        {
            cull.draw(sheets.keys,
                      {room.lowerLeft.x() + kHudMargin, top - sheets.keys.size.y()},
                      room.scale);
            top -= heightOf(sheets.keys);
        }
        const float middle = 0.5F * (room.lowerLeft.x() + room.upperRight.x());
        cull.draw(sheets.alarm,
                  {middle - 0.5F * sheets.alarm.size.x(), top - sheets.alarm.size.y()},
                  room.scale);
    }

private:
    /// \a result: null before the first field.
    void drawFigures(const HapticOverlays& overlays,
                     const std::shared_ptr<const midair::bridge::HologramResult>& result)
    {
        osg::ref_ptr<FieldSliceOverlay> fieldSlice;
        osg::ref_ptr<FieldVolumeOverlay> fieldVolume;
        _owner._slice.lock(fieldSlice);
        _owner._volume.lock(fieldVolume);
        const bool hasSlice = fieldSlice && fieldSlice->isShown();
        const bool hasVolume = fieldVolume && fieldVolume->isShown();
        OverlayRates rates;
        rates.frames = _owner._frameRate;
        if (hasSlice) rates.slices = fieldSlice->getSlicesPerSecond();
        if (hasVolume) rates.volumes = fieldVolume->getVolumesPerSecond();
        const HudRows rows = rowsOf(result.get(), _news, rates);
        const std::vector<std::string> messages = messagesOf(_news, _alarm);
        for (HudSheets& sheets : _layouts)
        {
            sheets.drawFigures(_owner._title, rows, _error, _latency, _skin.curve());
            sheets.drawMessages(messages);
            sheets.drawScales(hasSlice ? fieldSlice->getRange() : 0.0F,
                              hasVolume ? fieldVolume->getRange() : 0.0F,
                              overlays.isShown("points"),
                              overlays.isShown("array"),
                              overlays.isShown("ears"));
        }
    }

    void drawAlarm(HudAlarm alarm)
    {
        if (alarm == _alarm) return;
        _alarm = std::move(alarm);
        for (HudSheets& sheets : _layouts)
            sheets.drawAlarm(_alarm);
    }

    void drawKeys(const HapticOverlays& overlays, double time_s)
    {
        if (_hasKey && time_s >= 0.0)
        {
            _keysSince_s = time_s;
            _hasKey = false;
        }
        // If time goes back, a clock was reset.
        const double age_s = time_s - _keysSince_s;
        if (_owner._isPlain || time_s < 0.0 || age_s < 0.0 || age_s >= _owner._keyTime_s)
            _keysSince_s = -1.0;
        std::vector<bool> drawn;
        if (_keysSince_s >= 0.0)
            for (const auto& [place, kind] : overlayKinds())
                drawn.push_back(overlays.getOverlay(kind.name)->isShown());
        if (drawn == _keysDrawn) return;
        _keysDrawn = std::move(drawn);
        std::vector<HudKey> all;
        bool isAnyOn = false;
        std::size_t next = 0;
        if (!_keysDrawn.empty())
            for (const auto& [place, kind] : overlayKinds())
            {
                const bool isOn = _keysDrawn[next++];
                all.push_back({kind.keyName() + " " + kind.word, isOn});
                isAnyOn = isAnyOn || isOn;
            }
        if (!all.empty())
        {
            all.push_back({"F7 all", isAnyOn});
            all.push_back({"F8 mute", true});
        }
        for (HudSheets& sheets : _layouts)
            sheets.drawKeys(all);
    }

    Hud& _owner;
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
class Hud::Banner : public osg::Group
{
public:
    explicit Banner(Hud* hud) : _hud(hud)
    {
        setName("banner");
        pixels::paintInOrder(*this, HUD_BIN + 1);
    }

    void traverse(osg::NodeVisitor& visitor) override
    {
        osgUtil::CullVisitor* cull = visitor.asCullVisitor();
        if (cull && cull->getViewport()) _hud->_part.cullBanner(*cull);
    }
    /// Returns an empty bound, as it takes no space in the scene.
    osg::BoundingSphere computeBound() const override { return {}; }

private:
    const osg::ref_ptr<Hud> _hud;
};

Hud::Hud() :
    Overlay(std::make_unique<Part>(*this)),
    _part(static_cast<Part&>(OverlayPart::of(*this)))
{
    pixels::paintInOrder(*this, HUD_BIN);
}

Hud::~Hud() = default;

osg::ref_ptr<osg::Group> Hud::makeBanner()
{
    return new Banner(this);
}

float Hud::scaleFor(double width, double height)
{
    return static_cast<float>(hudScale(width, height));
}

void Hud::traverse(osg::NodeVisitor& visitor)
{
    osgUtil::CullVisitor* cull = visitor.asCullVisitor();
    if (cull && cull->getViewport()) _part.cullFigures(*cull);
}

} // namespace osgMidair
