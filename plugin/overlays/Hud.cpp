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

/// Draws sheets in pixels of a viewport, or on a sheet in the world. It doesn't change the scene
/// graph, because views may cull at the same time: each pushes its own matrices.
class SheetCull
{
public:
    SheetCull(osgUtil::CullVisitor& visitor, const HudRoom& room) :
        _visitor(visitor),
        _mode(visitor.getComputeNearFarMode()),
        _world(WorldSheet::of(visitor.getCurrentCamera()))
    {
        visitor.setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
        if (_world) return;
        // If the scene is drawn mirrored, so is the HUD.
        const osg::RefMatrix* before = visitor.getProjectionMatrix();
        const double side = before && (*before)(0, 0) < 0.0 ? -1.0 : 1.0;
        visitor.pushProjectionMatrix(new osg::RefMatrix(
            osg::Matrix::ortho2D(0.0, room.viewport.x(), 0.0, room.viewport.y()) *
            osg::Matrix::scale(side, 1.0, 1.0)));
    }
    ~SheetCull()
    {
        if (!_world) _visitor.popProjectionMatrix();
        _visitor.setComputeNearFarMode(_mode);
    }
    SheetCull(const SheetCull&) = delete;
    SheetCull& operator=(const SheetCull&) = delete;

    /// Whole pixels keep letters sharp.
    void draw(const HudSheet& sheet, const osg::Vec2& lowerLeft, double scale)
    {
        if (sheet.size.x() <= 0.0F) return;
        const auto whole = [&](double at) { return std::round(at * scale) / scale; };
        osg::Matrixd place =
            osg::Matrixd::translate(whole(lowerLeft.x()), whole(lowerLeft.y()), 0.0);
        if (_world) place *= _world->toWorld * _visitor.getCurrentCamera()->getViewMatrix();
        _visitor.pushModelViewMatrix(new osg::RefMatrix(place), osg::Transform::ABSOLUTE_RF);
        sheet.panel->accept(_visitor);
        _visitor.popModelViewMatrix();
    }

private:
    osgUtil::CullVisitor& _visitor;
    const osg::CullSettings::ComputeNearFarMode _mode;
    const WorldSheet* const _world; ///< null: in the viewport
};

/// Largest fraction of a viewport that figures cover, except in the smallest layout.
constexpr float kMostCovered = 1.0F / 3.0F;

float areaOf(const HudSheet& sheet)
{
    return sheet.size.x() * sheet.size.y();
}

/// Height of \a sheet with the gap around it; 0: it is empty.
float heightOf(const HudSheet& sheet)
{
    return sheet.size.y() > 0.0F ? sheet.size.y() + kGap : 0.0F;
}

} // namespace

/// Keeps the texts, draws them into the sheets of every layout, and when a view is culled chooses
/// the layout for its room.
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
        // With hidden figures and for visitors, signs for the operator are omitted.
        const bool isOfArray = alarm.word == "LOST" || alarm.word == "FAULT" ||
                               (_news.isEnabled && _news.statistics.state == ArrayState::CLOSED);
        const bool isSaid = isShown || alarm.word == "MUTED" || (isOfArray && !_owner._isPlain);
        drawAlarm(isSaid ? std::move(alarm) : HudAlarm());
        if (!isShown || !isKnown) return;
        _skin.update(result, engine, _lastUpdate_s);
        drawFigures(overlays, result);
    }

    void noteKey(int key) override
    {
        const bool isHelp = key == osgGA::GUIEventAdapter::KEY_F1;
        // The list that is there for a while stays or goes, too.
        if (isHelp) _isHelpShown = !_isHelpShown;
        _hasKey = !isHelp;
        if (isHelp) _keysSince_s = -1.0;
    }

    /// Draws figures, messages and scales at the bottom.
    void cullFigures(osgUtil::CullVisitor& visitor)
    {
        const HudRoom room = roomFor(visitor);
        const int layout = layoutFor(room);
        if (layout < 0) return;
        const HudSheets& sheets = _layouts[static_cast<std::size_t>(layout)];
        SheetCull cull(visitor, room);
        const osg::Vec2 corner = room.lowerLeft + osg::Vec2(kHudMargin, kHudMargin);
        if (isListed(sheets, room) && heightUsed(sheets) > room.height()) return;
        cull.draw(sheets.figures, corner, room.scale);
        const float above = sheets.figures.size.y() + kGap;
        if (heightUsed(sheets) + heightOf(sheets.messages) <= room.height())
            cull.draw(sheets.messages, corner + osg::Vec2(0.0F, above), room.scale);
        const float beside = sheets.figures.size.x() + sheets.scales.size.x() + 3.0F * kHudMargin;
        if (beside <= room.width() &&
            covered(sheets) + areaOf(sheets.scales) <= kMostCovered * room.area())
            cull.draw(sheets.scales,
                      {room.upperRight.x() - kHudMargin - sheets.scales.size.x(), corner.y()},
                      room.scale);
    }

    /// Draws keys and alarm at the top.
    void cullBanner(osgUtil::CullVisitor& visitor)
    {
        const HudRoom room = roomFor(visitor);
        const HudSheets& sheets = _layouts[static_cast<std::size_t>(std::max(0, layoutFor(room)))];
        SheetCull cull(visitor, room);
        // Drawn even if there is no room for it.
        float top = std::max(room.upperRight.y() - kHudMargin, heightOf(sheets.alarm) + kHudMargin);
        if (isListed(sheets, room))
        {
            cull.draw(sheets.keys,
                      {room.lowerLeft.x() + kHudMargin, top - sheets.keys.size.y()},
                      room.scale);
            top -= heightOf(sheets.keys);
        }
        const float middle = 0.5F * (room.lowerLeft.x() + room.upperRight.x());
        const float left = _alarm.isSilence ? middle - 0.5F * sheets.alarm.size.x()
                                            : room.lowerLeft.x() + kHudMargin;
        cull.draw(sheets.alarm, {left, top - sheets.alarm.size.y()}, room.scale);
    }

private:
    HudRoom roomFor(osgUtil::CullVisitor& visitor) const
    {
        return roomOf(visitor, _owner._scale, std::clamp(_owner._topMargin, 0.0F, 1.0F));
    }

    /// True: the keys are drawn; false: there are none, or no room for them.
    static bool isListed(const HudSheets& sheets, const HudRoom& room)
    {
        const float least = heightOf(sheets.keys) + heightOf(sheets.alarm) + 2.0F * kHudMargin;
        return sheets.keys.size.y() > 0.0F && room.height() >= least;
    }

    /// The height that is always drawn, in one column.
    float heightUsed(const HudSheets& sheets) const
    {
        return (_owner.isShown() ? heightOf(sheets.figures) : 0.0F) + heightOf(sheets.keys) +
               heightOf(sheets.alarm) + 2.0F * kHudMargin;
    }

    /// The area that is always drawn.
    float covered(const HudSheets& sheets) const
    {
        const float always = areaOf(sheets.keys) + areaOf(sheets.alarm);
        return _owner.isShown() ? always + areaOf(sheets.figures) + areaOf(sheets.messages)
                                : always;
    }

    /// Returns the index of the largest layout for \a room that leaves enough of the picture and in
    /// which nothing is over anything else; below 0: even the smallest doesn't fit.
    int layoutFor(const HudRoom& room) const
    {
        int found = -1;
        for (std::size_t i = 0; i < _layouts.size(); ++i)
            if (room.width() >= kHudLayouts[i].width && room.height() >= kHudLayouts[i].height &&
                (found < 0 || (covered(_layouts[i]) <= kMostCovered * room.area() &&
                               heightUsed(_layouts[i]) <= room.height())))
                found = static_cast<int>(i);
        return found;
    }

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
        std::vector<HudKey> keys;
        if (_isHelpShown || _keysSince_s >= 0.0) keys = keysOf(overlays);
        if (keys == _keysDrawn) return;
        _keysDrawn = std::move(keys);
        for (HudSheets& sheets : _layouts)
            sheets.drawKeys(_keysDrawn);
    }

    static std::vector<HudKey> keysOf(const HapticOverlays& overlays)
    {
        std::vector<HudKey> keys;
        bool isAnyOn = false;
        std::size_t place = 0;
        for (const auto& [number, kind] : overlayKinds())
        {
            const Overlay& overlay = *overlays.getOverlay(kind.name);
            const bool isOn = overlay.isShown();
            const bool isSeen = OverlayFeed::of(overlays).isInSight(place++);
            isAnyOn = isAnyOn || isOn;
            if (kind.key == 0) continue;
            const char* why = !isOn || isSeen              ? ""
                              : overlay.getBound().valid() ? " (out of sight)"
                                                           : " (nothing yet)";
            keys.push_back({kind.keyName() + " " + kind.word + why, isOn});
        }
        keys.push_back({isAnyOn ? "F7 all" : "F7 shows what is felt", isAnyOn});
        keys.push_back({"F8 mute", true});
        return keys;
    }

    Hud& _owner;
    std::vector<HudSheets> _layouts; ///< as kHudLayouts
    pixels::Sparkline _error{"error rms", "%"};
    pixels::Sparkline _latency{"latency", "ms"};
    SkinTrace _skin;
    std::shared_ptr<const midair::bridge::HologramResult> _result;
    ArrayNews _news;
    HudAlarm _alarm;                ///< that is drawn
    std::vector<HudKey> _keysDrawn; ///< empty: they aren't listed
    bool _hasKey = true;            ///< keys are to be listed for a while from now on
    bool _isHelpShown = false;      ///< they are listed until F1 is pressed again
    double _keysSince_s = -1.0;     ///< below 0: they aren't listed for a while
    double _lastUpdate_s = 0.0;
    int _frames = 0;
};

/// The part of a Hud that is shown even while it is hidden: keys, and problems in large letters.
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
    /// Returns an empty bound because it takes no space in the scene.
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
