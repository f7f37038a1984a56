#pragma once

#include "engine-bridge/contact/ContactTracker.h"
#include "engine-bridge/sensations/SensationFrame.h"
#include "haptics/sensation/StoredTurn.h"

#include <optional>
#include <vector>

namespace midair::bridge
{

constexpr double kPatternUnit_m = 1e-3; ///< patterns are in millimetres

/// Appends \a focus at \a place_mm of the pattern in \a frame, and sets its position. Leaves out
/// what is silent or nowhere.
void appendFocus(const SensationFrame& frame,
                 const Eigen::Vector3d& place_mm,
                 ContactFocus& focus,
                 std::vector<ContactFocus>& foci);
/// The same for the curve that \a brush draws round \a path_mm, as SensationFigures::kLeastPoints
/// points at once.
void appendOutline(const SensationFrame& frame,
                   const Eigen::Vector3d& path_mm,
                   const haptics::DrawnBrush& brush,
                   ContactFocus& focus,
                   std::vector<ContactFocus>& foci);

/// A sensation that repeats itself.
struct SteadyPart
{
    haptics::SteadySensation pattern;
    SensationFrame frame;
    ContactFocus focus; ///< with the pressure of intensity 1
};

/// Sensations that repeat themselves together, for a device that stores and times fields by itself.
class SteadyTurn
{
public:
    /// At least one part.
    explicit SteadyTurn(std::vector<SteadyPart> parts);

    /// Returns the fields that a device stores for it; none: it needs none, or can't store them, or
    /// the parts differ in their frequencies.
    std::optional<haptics::StoredTurn> storedIn(const haptics::TurnStore& store) const;
    /// Returns the foci of field \a field, 0 .. turn.fields - 1.
    std::vector<ContactFocus> foci(const haptics::StoredTurn& turn, int field) const;

    /// Returns true if \a other plays the same, apart from the place in it.
    bool isSame(const SteadyTurn& other) const;

private:
    std::vector<SteadyPart> _parts;
};

} // namespace midair::bridge
