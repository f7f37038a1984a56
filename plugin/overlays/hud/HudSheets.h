#pragma once

#include "engine-bridge/pipeline/HologramResult.h"
#include "plugin/overlays/drawing/PixelDrawing.h"
#include "plugin/overlays/hud/SkinTrace.h"

#include <osgMidair/HapticStatistics>

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace osgMidair
{

/// State of an array besides its newest field.
struct ArrayNews
{
    HapticStatistics statistics;
    bool isMuted = false;
    bool isEnabled = true; ///< false: the scene is disabled
};

/// A sign in large letters: one word, and the reason. Both empty: no problem.
struct HudAlarm
{
    std::string word;
    std::string reason;
    /// True: nothing is played although something should be; false: less than requested.
    bool isSilence = true;

    bool operator==(const HudAlarm& other) const
    {
        return word == other.word && reason == other.reason && isSilence == other.isSilence;
    }
};

/// Rates known only to overlays; 0: not shown.
struct OverlayRates
{
    double slices = 0.0; ///< 1/s, like the others
    double volumes = 0.0;
    double frames = 0.0;
};

using HudRows = std::vector<std::pair<std::string, std::string>>;

/// Returns the state for a scene without an owner: taken from \a result alone.
ArrayNews newsOf(const midair::bridge::HologramResult& result);

/// Returns MUTED, LOST, FAULT, SILENT or CAPPED with its reason. \a result may be null.
HudAlarm alarmOf(const ArrayNews& news, const midair::bridge::HologramResult* result);

/// Returns the figures by name, the most important first, because with little room only the first
/// ones are shown. Without a \a result, before the first field, only the state.
HudRows rowsOf(const midair::bridge::HologramResult* result,
               const ArrayNews& news,
               const OverlayRates& rates);

/// Returns the messages without the reason of \a alarm, the most important first: faults, warnings,
/// notices; the newest of each first. Each begins with its cause and ends with the name of the
/// node.
std::vector<std::string> messagesOf(const ArrayNews& news, const HudAlarm& alarm);

/// A layout of the figures for a size of room; lengths in units.
struct HudLayout
{
    float width = 0.0F;  ///< least width of the room
    float height = 0.0F; ///< without messages
    float text = 13.0F;  ///< height of letters
    int rows = 0;        ///< at most
    int messages = 0;    ///< at most
    float panel = 0.0F;  ///< width of the figures
    float names = 0.0F;  ///< width of the column of names
    bool isTitled = false;
    bool hasCourses = false; ///< the course of error and latency is shown
    int scales = 0;          ///< number of colour scales, at most
    float scaleHeight = 0.0F;
    float line = 0.0F; ///< longest line of messages, reasons and keys
    float word = 0.0F; ///< height of the letters of an alarm
};

/// For little, medium and much room.
extern const std::array<HudLayout, 3> kHudLayouts;

/// A key and what it shows.
struct HudKey
{
    std::string text; ///< "F3 slice"
    bool isOn = false;

    bool operator==(const HudKey& other) const { return text == other.text && isOn == other.isOn; }
};

/// A drawing with its lower left corner at the origin.
struct HudSheet
{
    osg::ref_ptr<pixels::TextPanel> panel = new pixels::TextPanel;
    osg::Vec2 size; ///< 0: nothing is drawn
};

/// The drawings of one layout.
class HudSheets
{
public:
    explicit HudSheets(const HudLayout& layout) : layout(layout) {}

    const HudLayout& layout;
    HudSheet figures; ///< with the courses
    HudSheet messages;
    HudSheet scales;
    HudSheet alarm;
    HudSheet keys;

    void drawFigures(const std::string& title,
                     const HudRows& rows,
                     const pixels::Sparkline& error,
                     const pixels::Sparkline& latency,
                     const SkinCurve& skin = {});
    void drawMessages(const std::vector<std::string>& texts);
    /// Draws the scales of the pressure, the radiation pressure, points, the array and the levels
    /// \a around it; omits ranges of 0.
    void drawScales(float field_Pa, float volume_Pa, bool points, bool array, bool around = false);
    void drawAlarm(const HudAlarm& alarm);
    void drawKeys(const std::vector<HudKey>& all);
};

} // namespace osgMidair
