#include "haptics/points/ControlPointSelector.h"

#include <string>
#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

/// Adds "COUNT WHAT" to \a lost, unless there are none.
auto teller(std::vector<std::string>& lost)
{
    return [&lost](int count, const char* what)
    {
        if (count != 0) lost.push_back(fmt::format("{} {}", count, what));
    };
}

} // namespace

LeftOutPoints& LeftOutPoints::operator+=(const LeftOutPoints& other)
{
    notFinite += other.notFinite;
    noTarget += other.noTarget;
    outOfWorkspace += other.outOfWorkspace;
    tooClose += other.tooClose;
    behind += other.behind;
    crowded += other.crowded;
    overBudget += other.overBudget;
    return *this;
}

std::string LeftOutPoints::summary() const
{
    std::vector<std::string> lost;
    const auto tell = teller(lost);
    tell(notFinite, "not finite");
    tell(noTarget, "without a positive target");
    tell(outOfWorkspace - behind - tooClose, "out of reach");
    tell(behind, "behind the array");
    tell(tooClose, "too close to a transducer");
    tell(crowded, "too near another point");
    tell(overBudget, "over the budget");
    return fmt::format("{}", fmt::join(lost, ", "));
}

std::string SelectionReport::summary() const
{
    if (selected == candidates) return "";
    std::vector<std::string> lost;
    const auto tell = teller(lost);
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
