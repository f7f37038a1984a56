#include "samples/paper/StarStarts.h"

#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"

#include <cmath>
#include <cstdio>
#include <vector>

namespace midair::samples
{

namespace
{

struct Row
{
    double equal = 0.0;           // evenness from equal phases
    std::vector<double> evenness; // from each random start
    std::vector<double> loudness;
};

Row solveAll(const PaperArray& paper, const Eigen::Matrix3Xd& points, PaperSolve how, int starts)
{
    Row row;
    how.start = 0;
    row.equal = paper.solve(points, how).evenness();
    for (int start = 1; start <= starts; ++start)
    {
        how.start = static_cast<std::uint64_t>(start);
        const PaperField field = paper.solve(points, how);
        row.evenness.push_back(field.evenness());
        row.loudness.push_back(field.report.loudness);
    }
    return row;
}

void print(const PaperSolve& how, const Row& row)
{
    char lambda[16] = "-"; // the default solver has none
    if (how.solver != haptics::solverNames().front())
        std::snprintf(lambda, sizeof lambda, "%g", how.lambda);
    std::printf("    %-12s %6s    %.2f  %.2f %.2f %.2f %.2f %.2f   %.2f\n",
                how.solver.c_str(),
                lambda,
                row.equal,
                base::percentile(row.evenness, 0.0),
                base::percentile(row.evenness, 0.1),
                base::percentile(row.evenness, 0.5),
                base::percentile(row.evenness, 0.9),
                base::percentile(row.evenness, 1.0),
                base::percentile(row.loudness, 0.5));
    std::fflush(stdout);
}

} // namespace

Eigen::Matrix3Xd flatStar(double width_m)
{
    const double outer_m = 0.5 * width_m / std::sin(0.4 * base::kPi);
    const double inner_m = outer_m * 0.5 * (3.0 - std::sqrt(5.0)); // the pentagram's notches
    Eigen::Matrix3Xd points(3, 11);
    for (int k = 0; k < 10; ++k)
    {
        const double r = k % 2 == 0 ? outer_m : inner_m;
        const double angle = base::kPi * k / 5.0;
        points.col(k) = Eigen::Vector3d(r * std::sin(angle), 0.0, r * std::cos(angle));
    }
    points.col(10).setZero();
    return points;
}

void printStarStarts(const PaperArray& paper, int starts)
{
    std::printf("Flat star of 11 points in the cross-section, equal start and %d random starts:\n"
                "weakest point over strongest (and median loudness E)\n"
                "    solver       lambda   equal   min  10%%  50%%  90%%  max      E\n",
                starts);
    for (const double width_m : {0.034, 0.12})
        for (const bool phaseOnly : {true, false})
        {
            std::printf(
                "  %.0f mm, %s\n", 1e3 * width_m, phaseOnly ? "phases only" : "clipped amplitudes");
            for (const PaperSolve& how : {PaperSolve{"gs", phaseOnly, 1e-3},
                                          PaperSolve{"sdp-bcd", phaseOnly, 1e-3},
                                          PaperSolve{"gs", phaseOnly, 0.1},
                                          PaperSolve{"sdp-bcd", phaseOnly, 0.1},
                                          PaperSolve{"gauss-newton", phaseOnly}})
                print(how, solveAll(paper, flatStar(width_m), how, starts));
        }
}

} // namespace midair::samples
