#include "haptics/propagation/Exposure.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

// Apart from the closed form: the discrete Fourier transform of a held pulse in an hour-glass of
// samples, energy bin by bin.
double byTransform(double rate_Hz)
{
    const double held_s = 1.0 / rate_Hz;
    constexpr double kLow = 20.0, kHigh = 20e3;
    double inside = 0.0;
    const double step = std::min(1.0, 0.002 * rate_Hz); // Hz
    for (double f = kLow + 0.5 * step; f < kHigh; f += step)
    {
        // integral of exp(-j 2 pi f t) over the pulse
        const double re = std::sin(2 * M_PI * f * held_s) / (2 * M_PI * f);
        const double im = (std::cos(2 * M_PI * f * held_s) - 1.0) / (2 * M_PI * f);
        inside += 2.0 * (re * re + im * im) * step;
    }
    return inside / held_s; // Parseval: the whole is its length
}

TEST(AudibleShare, IsTheEnergyOfAHeldPulseInTheAudibleBand)
{
    for (const double rate : {60.0, 200.0, 1000.0, 5000.0, 40000.0})
        EXPECT_NEAR(audibleShare(rate), byTransform(rate), 2e-4) << rate << " Hz";
    EXPECT_GT(audibleShare(1000.0), 0.95); // nearly all of it
    EXPECT_LT(audibleShare(1.0), 0.01);    // below what is heard
    EXPECT_LT(audibleShare(1e6), 0.05);    // above it
}

TEST(AudibleShare, IsInTheReport)
{
    SolverOptions options;
    options.updateRate_Hz = 200.0;
    const auto solver = makeSolver("gauss-newton", options);
    const TransducerArray array = TransducerArray::singleBoard();
    Eigen::VectorXcf q;
    EXPECT_EQ(solver->solve(spherePoints(8, 0.02, {0, 0, 0.1}), array, {}, q).audibleChange, 0.0);
    const SolveReport moved = solver->solve(spherePoints(8, 0.02, {0.001, 0, 0.1}), array, {}, q);
    EXPECT_GT(moved.driveChange, 0.0);
    EXPECT_NEAR(moved.audibleChange, audibleShare(200.0) * moved.driveChange, 1e-12);
    const SolveReport still = solver->solve(spherePoints(8, 0.02, {0.001, 0, 0.1}), array, {}, q);
    EXPECT_EQ(still.audibleChange, 0.0);
    options.updateRate_Hz = 0.0;
    std::string error;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "solver option updateRate_Hz is 0; it must be above 0");
}

} // namespace
} // namespace midair::haptics
