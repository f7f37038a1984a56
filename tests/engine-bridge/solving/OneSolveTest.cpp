// A cap of the amplitude scales a field, whose transducers keep their ratios; and what a cap of the
// pressure has proven is what is written.
#include "engine-bridge/solving/OneSolve.h"

#include "engine-bridge/solving/ArrayLevels.h"
#include "haptics/base/DutyLaw.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

/// Amplitudes from 1 down, as no solver of unit amplitudes gives them.
class UnevenSolver : public haptics::HologramSolver
{
public:
    explicit UnevenSolver(const haptics::SolverOptions& options) : _options(options) {}

    haptics::SolveReport solve(const haptics::ControlPoints& points,
                               const haptics::TransducerArray& array,
                               const haptics::Medium&,
                               Eigen::VectorXcf& q) override
    {
        q = Eigen::VectorXf::LinSpaced(array.size(), 1.0F, 0.01F).cast<std::complex<float>>();
        haptics::SolveReport report;
        report.stop = haptics::StopReason::CONVERGED;
        report.points = points.size();
        return report;
    }
    const haptics::SolverOptions& options() const override { return _options; }

private:
    haptics::SolverOptions _options;
};

SolvedFields solvedWith(const haptics::FieldSettings& settings)
{
    haptics::TransducerArray array = haptics::TransducerArray::load("board");
    keepToSignal(array.drive);
    const haptics::Medium medium;
    SolveTask task{array, medium, settings};
    haptics::ControlPoints points;
    points.positions = Eigen::Vector3d(0.0, 0.0, 0.15);
    points.normals = Eigen::Vector3d::UnitZ();
    points.targets = Eigen::VectorXd::Ones(1);
    points.object = {0};
    task.sets = {points};
    task.makeSolver = [](const std::string&, const haptics::SolverOptions& options)
    { return std::make_unique<UnevenSolver>(options); };
    return solveOnce(task);
}

} // namespace

TEST(OneSolve, ACapOfTheAmplitudeKeepsTheRatiosOfAField)
{
    for (const double cap : {1.0, 0.7, 0.2, 0.05})
    {
        haptics::FieldSettings settings;
        settings.maxAmplitude = cap;
        const device::DriveSignal signal = solvedWith(settings).signals.front();
        const double most = std::floor(base::dutyLevel(cap) + 1e-9);
        for (int i = 0; i < signal.size(); ++i)
        {
            const double share = 1.0 - 0.99 * i / (signal.size() - 1.0);
            EXPECT_NEAR(signal.duty[static_cast<std::size_t>(i)],
                        base::dutyLevel(share * base::dutyAmplitude(most)),
                        0.5 + 1e-3)
                << cap << ", " << i;
        }
    }
}

TEST(OneSolve, WhatTheCapsHaveProvenIsWritten)
{
    haptics::FieldSettings settings;
    const double free_Pa = solvedWith(settings).achieved_Pa[0];
    for (const double cap : {1.0, 0.7, 0.2, 0.05})
        for (double share = 0.99; share > 0.01; share *= 0.83)
        {
            settings.maxAmplitude = cap;
            settings.maxPressure = share * free_Pa;
            const SolvedFields solved = solvedWith(settings);
            EXPECT_LE(solved.achieved_Pa[0], settings.maxPressure) << cap << ", " << share;
            const auto& duty = solved.signals.front().duty;
            EXPECT_LE(*std::max_element(duty.begin(), duty.end()), base::dutyLevel(cap) + 1e-9);
        }
}

} // namespace midair::bridge
