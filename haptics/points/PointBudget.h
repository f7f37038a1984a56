#pragma once

#include "haptics/base/threads/StopToken.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Point that competes for a place in the budget.
struct BudgetPoint
{
    int priority;
    int object; ///< decides between equal remainders
    int source; ///< the source whose share it uses
    int sample;
    Eigen::Vector3d position; ///< m
};

/// Returns a flag for each point: 1 for those that stay, at most \a maxPoints. The budget is given
/// out in order of priority. The first priority that does not fit as a whole is shared among its
/// sources in proportion to their points (largest remainders), and the share of each source is
/// spread over it. Throws Stopped if \a stop requests it.
std::vector<char> shareBudget(const std::vector<BudgetPoint>& points,
                              int maxPoints,
                              const base::StopToken& stop = {});

} // namespace midair::haptics
