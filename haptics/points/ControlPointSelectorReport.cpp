#include "haptics/points/ControlPointSelector.h"

#include <string>
#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

std::string SelectionReport::summary() const
{
    if (selected == candidates) return "";
    std::vector<std::string> lost;
    const auto tell = [&lost](int count, const char* what)
    {
        if (count != 0) lost.push_back(fmt::format("{} {}", count, what));
    };
    tell(notFinite, "not finite");
    tell(noTarget, "without a positive target");
    tell(outOfReach, "out of reach");
    tell(behind, "behind the array");
    tell(tooClose, "too close to a transducer");
    tell(crowdDropped, "dropped from crowds");
    tell(crowdMerged, "merged into others");
    tell(crowdThinned, "thinned from crowds");
    tell(spacedOut, "too near another object's");
    tell(overBudget, "over the budget");
    const char* why = lost.empty() ? "" : ": ";
    return fmt::format("{} of {} points{}{}", selected, candidates, why, fmt::join(lost, ", "));
}

} // namespace midair::haptics
