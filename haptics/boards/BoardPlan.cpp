#include "haptics/boards/BoardPlan.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Range.h"
#include "haptics/boards/BoardFit.h"
#include "haptics/boards/BoardSolver.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kShortest_m = 0.01;
constexpr double kFree_m = 0.1;     // how far boards may be off before anything is measured
constexpr double kRedundancy = 1.5; // distances over unknowns

void check(const TransducerArray& array, const BoardPlanOptions& options)
{
    std::string error;
    if (!base::RangeCheck("plan: ")
             .within("longest_m", options.longest_m, kShortest_m, 10.0, " m")
             .within("sigma_m", options.sigma_m, 1e-6, 0.1, " m")
             .within("count", options.count, 0.0, 10000.0)
             .passed(&error))
        throw base::InputError(error);
    if (boardsOf(array).size() < 2)
        throw base::InputError("array \"" + array.name +
                               "\" has one board: there is no other to measure it to");
}

/// All corner to corner distances between boards that a tape reaches.
std::vector<PlannedDistance> candidates(const TransducerArray& array, double longest_m)
{
    const BoardMarks marks(array);
    std::vector<PlannedDistance> found;
    for (int a = 0; a < marks.boards(); ++a)
        for (int b = a + 1; b < marks.boards(); ++b)
            for (const char from : {'a', 'b', 'c', 'd'})
                for (const char to : {'a', 'b', 'c', 'd'})
                {
                    PlannedDistance one;
                    one.fromTransducer = marks.corner(a, from);
                    one.toTransducer = marks.corner(b, to);
                    one.from = fmt::format("{}:{}", a, from);
                    one.to = fmt::format("{}:{}", b, to);
                    one.distance_m = (array.positions.col(one.fromTransducer) -
                                      array.positions.col(one.toTransducer))
                                         .norm();
                    if (one.distance_m >= kShortest_m && one.distance_m <= longest_m)
                        found.push_back(one);
                }
    return found;
}

BoardMeasurements measurementsOf(const std::vector<PlannedDistance>& distances)
{
    BoardMeasurements all;
    for (const PlannedDistance& planned : distances)
    {
        BoardMeasurement& one = all.all.emplace_back();
        one.from = {planned.from, planned.fromTransducer, -1};
        one.to = {planned.to, planned.toTransducer, -1};
        one.distance_m = planned.distance_m;
    }
    return all;
}

} // namespace

BoardPlan planBoards(const TransducerArray& array, const BoardPlanOptions& options)
{
    check(array, options);
    const std::vector<PlannedDistance> all = candidates(array, options.longest_m);
    const BoardMeasurements measurements = measurementsOf(all);
    const BoardSolver solver(array, measurements, 343.2);
    const BoardState state = solver.start();
    const Eigen::MatrixXd J = solver.jacobian(state) / options.sigma_m;
    // Covariance of the parameters, of boards that may be anywhere at first.
    const int P = solver.parameters();
    Eigen::MatrixXd C = Eigen::MatrixXd::Identity(P, P) * kFree_m * kFree_m;
    const auto wanted = static_cast<std::size_t>(
        options.count > 0 ? options.count : std::lround(kRedundancy * (P - 6)));
    std::vector<char> taken(all.size(), 0);
    BoardPlan plan;
    while (plan.distances.size() < std::min(wanted, all.size()))
    {
        Eigen::Index best = -1;
        double most = -1.0;
        const Eigen::MatrixXd JC = J * C;
        for (Eigen::Index k = 0; k < J.rows(); ++k)
        {
            if (taken[static_cast<std::size_t>(k)]) continue;
            const double gain = JC.row(k).dot(J.row(k));
            if (gain <= most) continue;
            most = gain;
            best = k;
        }
        // Sherman and Morrison: what one more measurement leaves of the covariance.
        const Eigen::VectorXd column = JC.row(best).transpose();
        C -= column * column.transpose() / (1.0 + most);
        taken[static_cast<std::size_t>(best)] = 1;
        plan.distances.push_back(all[static_cast<std::size_t>(best)]);
    }
    std::sort(plan.distances.begin(),
              plan.distances.end(),
              [](const PlannedDistance& a, const PlannedDistance& b)
              {
                  return a.fromTransducer != b.fromTransducer ? a.fromTransducer < b.fromTransducer
                                                              : a.toTransducer < b.toTransducer;
              });
    BoardFitOptions fit;
    fit.sigma_m = options.sigma_m;
    const BoardFitReport report = fitBoards(array, measurementsOf(plan.distances), fit);
    plan.problems = report.problems;
    for (const BoardPose& board : report.boards)
        plan.uncertain_m = std::max(plan.uncertain_m, board.uncertain_m);
    if (!report.usable) plan.uncertain_m = std::numeric_limits<double>::infinity();
    return plan;
}

} // namespace midair::haptics
