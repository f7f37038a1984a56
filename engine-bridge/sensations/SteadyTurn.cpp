#include "engine-bridge/sensations/SteadyTurn.h"

#include "haptics/base/Units.h"
#include "haptics/sensation/SensationFigures.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace midair::bridge
{

namespace
{

/// Takes over a frequency if there is none yet; returns false for a different one.
bool agree(double& all_Hz, double own_Hz)
{
    if (all_Hz == 0.0) all_Hz = own_Hz;
    return own_Hz == 0.0 || own_Hz == all_Hz;
}

bool isSameBrush(const haptics::DrawnBrush& a, const haptics::DrawnBrush& b)
{
    return a.x_mm == b.x_mm && a.y_mm == b.y_mm && a.a == b.a && a.b == b.b &&
           a.phase_rad == b.phase_rad && a.rotation_rad == b.rotation_rad &&
           a.draw_Hz == b.draw_Hz && a.modulation_Hz == b.modulation_Hz;
}

bool isSamePart(const SteadyPart& a, const SteadyPart& b)
{
    return a.focus.contact == b.focus.contact && a.focus.pressure_Pa == b.focus.pressure_Pa &&
           a.focus.share == b.focus.share && a.focus.normal == b.focus.normal &&
           a.pattern.path_mm == b.pattern.path_mm && a.pattern.intensity == b.pattern.intensity &&
           isSameBrush(a.pattern.brush, b.pattern.brush) && a.frame.surface == b.frame.surface &&
           a.frame.toArray.matrix() == b.frame.toArray.matrix() &&
           a.frame.surfacePose.matrix() == b.frame.surfacePose.matrix();
}

/// Turns a second, in either direction; 0: it is a point.
double drawn_Hz(const haptics::DrawnBrush& brush)
{
    return brush.isDrawn() ? brush.draw_Hz : 0.0;
}

} // namespace

void appendFocus(const SensationFrame& frame,
                 const Eigen::Vector3d& place_mm,
                 ContactFocus& focus,
                 std::vector<ContactFocus>& foci)
{
    focus.position = frame.at(kPatternUnit_m * place_mm);
    if (focus.pressure_Pa > 0.0 && focus.position.allFinite()) foci.push_back(focus);
}

void appendOutline(const SensationFrame& frame,
                   const Eigen::Vector3d& path_mm,
                   const haptics::DrawnBrush& brush,
                   ContactFocus& focus,
                   std::vector<ContactFocus>& foci)
{
    const int points = static_cast<int>(haptics::SensationFigures::kLeastPoints);
    for (focus.index = 0; focus.index < points; ++focus.index)
    {
        Eigen::Vector3d place_mm = path_mm;
        place_mm.head<2>() += brush.at(base::kTwoPi * focus.index / points);
        appendFocus(frame, place_mm, focus, foci);
    }
}

// Turns begin with the first part's.
SteadyTurn::SteadyTurn(std::vector<SteadyPart> parts) : _parts(std::move(parts))
{
    const haptics::SteadySensation first = _parts.front().pattern;
    for (SteadyPart& part : _parts)
    {
        if (drawn_Hz(part.pattern.brush) != 0.0) part.pattern.draw_turns -= first.draw_turns;
        part.pattern.modulation_turns -= first.modulation_turns;
    }
}

std::optional<haptics::StoredTurn> SteadyTurn::storedIn(const haptics::TurnStore& store) const
{
    double draw_Hz = 0.0;
    double modulation_Hz = 0.0;
    for (const SteadyPart& part : _parts)
        if (!agree(draw_Hz, drawn_Hz(part.pattern.brush)) ||
            !agree(modulation_Hz, part.pattern.brush.modulation_Hz))
            return std::nullopt;
    return haptics::storedTurn(store, std::abs(draw_Hz), std::abs(modulation_Hz));
}

std::vector<ContactFocus> SteadyTurn::foci(const haptics::StoredTurn& turn, int field) const
{
    std::vector<ContactFocus> foci;
    const double done = static_cast<double>(field) / turn.fields;
    for (const SteadyPart& part : _parts)
    {
        const haptics::SteadySensation& pattern = part.pattern;
        const double periods = done * turn.periods + pattern.modulation_turns;
        const bool isModulated = turn.periods > 0 && pattern.brush.modulation_Hz != 0.0;
        ContactFocus focus = part.focus;
        focus.pressure_Pa *=
            pattern.intensity * (isModulated ? 0.5 + 0.5 * std::cos(base::kTwoPi * periods) : 1.0);
        const bool isDrawn = drawn_Hz(pattern.brush) != 0.0;
        const double turns =
            std::copysign(done * turn.turns, pattern.brush.draw_Hz) + pattern.draw_turns;
        Eigen::Vector3d place_mm = pattern.path_mm;
        if (isDrawn && turn.turns == 0)
        {
            appendOutline(part.frame, place_mm, pattern.brush, focus, foci);
            continue;
        }
        place_mm.head<2>() += pattern.brush.at(base::kTwoPi * turns);
        appendFocus(part.frame, place_mm, focus, foci);
    }
    return foci;
}

bool SteadyTurn::isSame(const SteadyTurn& other) const
{
    return std::equal(
        _parts.begin(), _parts.end(), other._parts.begin(), other._parts.end(), isSamePart);
}

} // namespace midair::bridge
