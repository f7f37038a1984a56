#pragma once

#include "haptics/base/threads/StopToken.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// A point that asks for its place in a budget.
struct BudgetPoint
{
    int priority;
    int object; ///< decides between equal shares
    int source; ///< whose share it comes from
    int sample;
    Eigen::Vector3d position; ///< m
};

/// Returns a flag for each point: 1 for at most \a maxPoints that stay. Budgets go priority by
/// priority. The first priority that does not fit as a whole is shared among its sources in
/// proportion to their points (largest remainders), and the share of each source is spread over it.
/// Throws Stopped where \a stop asks for it.
std::vector<char> shareBudget(const std::vector<BudgetPoint>& points,
                              int maxPoints,
                              const base::StopToken& stop = {});

} // namespace midair::haptics
