// The scenes of Inoue, Makino, Shinoda 2015 under the paper's own algorithms.
#include "haptics/propagation/PressureField.h"
#include "haptics/solvers/HologramSolver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

ControlPoints equalTargets(const Eigen::Matrix3Xd& positions)
{
    ControlPoints points;
    points.positions = positions;
    points.normals = Eigen::Vector3d::UnitZ().replicate(1, positions.cols());
    points.targets = Eigen::VectorXd::Ones(positions.cols());
    return points;
}

// Five points a wavelength (8.5 mm) apart: 34 mm along x.
ControlPoints line()
{
    Eigen::Matrix3Xd positions(3, 5);
    for (int l = 0; l < 5; ++l)
        positions.col(l) = Eigen::Vector3d(8.5e-3 * (l - 2), 0.0, 0.0);
    return equalTargets(positions);
}

// Five tips, five notches and the centre, across the prism's axis. The paper gives no size: tips at
// 34 mm, as far as its line is long, notches at the pentagram's ratio.
ControlPoints star()
{
    const double outer = 0.034, inner = outer * 0.381966;
    Eigen::Matrix3Xd positions(3, 11);
    for (int k = 0; k < 10; ++k)
    {
        const double r = k % 2 == 0 ? outer : inner;
        const double angle = M_PI * k / 5.0;
        positions.col(k) = Eigen::Vector3d(r * std::sin(angle), 0.0, r * std::cos(angle));
    }
    positions.col(10).setZero();
    return equalTargets(positions);
}

SolveReport
solve(const std::string& name, const ControlPoints& points, bool phaseOnly, Eigen::VectorXcf& q)
{
    SolverOptions options;
    options.maxIterations = 1000;
    options.phaseOnly = phaseOnly;
    const SolveReport report =
        makeSolver(name, options)->solve(points, TransducerArray::octagonalPrism(), Medium{}, q);
    std::printf("    %-10s %2d points, %s: rms %.4f, max %.4f, E %.3f\n",
                name.c_str(),
                points.size(),
                phaseOnly ? "phases only " : "full drive  ",
                report.rms,
                report.max,
                report.loudness);
    return report;
}

} // namespace

TEST(PaperScenes, LineIsTenMillimetresWide)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    Eigen::VectorXcf q;
    for (const char* name : {"gs", "sdp-bcd", "gauss-newton"})
    {
        SCOPED_TRACE(name);
        const SolveReport report = solve(name, line(), false, q);
        // Tikhonov (lambdaRel 0.1) and the clipped drive leave GS and SDP 5 % each, the same
        // phases.
        EXPECT_LT(report.rms, 0.06);
        // Across the line, in the plane across the axis, at its middle point: distance between the
        // first minima, in steps of 0.1 mm. A focus in a ring of transducers has its first zero at
        // 0.383 wavelengths (J0): 6.6 mm between zeros; five points at once leave the paper's
        // "about 10 mm".
        const int steps = 120;
        Eigen::Matrix3Xd across(3, 2 * steps + 1);
        for (int k = -steps; k <= steps; ++k)
            across.col(k + steps) = Eigen::Vector3d(0.0, 0.0, 1e-4 * k);
        const Eigen::VectorXf p = pressureAt(across, array, Medium{}, q).cwiseAbs();
        int right = steps, left = steps;
        while (right < 2 * steps && p[right + 1] < p[right])
            ++right;
        while (left > 0 && p[left - 1] < p[left])
            --left;
        const double width_mm = 0.1 * (right - left);
        std::printf("    %-10s width between minima %.1f mm\n", name, width_mm);
        EXPECT_GT(width_mm, 8.0);
        EXPECT_LT(width_mm, 11.0);
    }
}

TEST(PaperScenes, StarKeepsAllElevenPoints)
{
    Eigen::VectorXcf q;
    for (const bool phaseOnly : {false, true})
    {
        // The paper's figures 3 and 4 show points missing under GS and all there under SDP. A star
        // of this size, from equal phases, loses none in either; what differs is a few percent, and
        // clipping makes most of it. Smaller stars from random phases do:
        // tests/samples/experiments/paper.
        EXPECT_LT(solve("gs", star(), phaseOnly, q).max, 0.25);
        EXPECT_LT(solve("sdp-bcd", star(), phaseOnly, q).max, 0.25);
        const SolveReport best = solve("gauss-newton", star(), phaseOnly, q);
        EXPECT_LT(best.rms, 1e-3); // the tolerance asked for by default
    }
}
