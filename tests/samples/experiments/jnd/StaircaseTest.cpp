#include "samples/experiments/jnd/Staircase.h"

#include "samples/experiments/jnd/TrialFile.h"
#include "samples/experiments/paper/LineExperiment.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

using namespace midair::samples;

namespace
{

/// Leads somebody through a staircase who feels what is at \a threshold or above.
std::vector<double> askedOf(Staircase& staircase, double threshold)
{
    std::vector<double> asked;
    while (!staircase.isFinished())
    {
        asked.push_back(staircase.value());
        staircase.answer(staircase.value() >= threshold);
    }
    return asked;
}

} // namespace

TEST(Staircase, GoesDownFromTheMaximumAndUpThreeTimes)
{
    Staircase staircase({45.0, 5.0, 3});
    EXPECT_EQ(askedOf(staircase, 28.0),
              (std::vector<double>{45, 40, 35, 30, 25, 30, 25, 30, 25, 30}));
    ASSERT_EQ(staircase.turns().size(), 6u);
    for (const Turn& turn : staircase.turns())
    {
        EXPECT_DOUBLE_EQ(turn.value, 27.5);
        EXPECT_FALSE(turn.isBound);
    }
    const Threshold threshold = thresholdOf(staircase.turns());
    EXPECT_DOUBLE_EQ(threshold.value, 27.5);
    EXPECT_NEAR(threshold.deviation, 0.0, 1e-12);
    EXPECT_EQ(threshold.bounds, 0);
}

TEST(Staircase, CountsRunsAndDirections)
{
    Staircase staircase({45.0, 5.0, 3});
    EXPECT_EQ(staircase.run(), 1);
    EXPECT_TRUE(staircase.isDown());
    for (const bool isFelt : {true, false})
        staircase.answer(isFelt);
    EXPECT_EQ(staircase.run(), 2);
    EXPECT_FALSE(staircase.isDown());
    EXPECT_EQ(staircase.trials(), 2);
    EXPECT_DOUBLE_EQ(staircase.value(), 45.0);
}

TEST(Staircase, WhoFeelsNothingIsToldApartFromWhoFeelsTheMaximum)
{
    Staircase staircase({27.0, 3.0, 3});
    for (const double value : askedOf(staircase, 1e9))
        EXPECT_DOUBLE_EQ(value, 27.0);
    EXPECT_EQ(thresholdOf(staircase.turns()).bounds, 6);
    EXPECT_EQ(staircase.trials(), 3 * (1 + Staircase::kPatience));
}

TEST(Staircase, WhoFeelsTheReferenceTurnsAtNought)
{
    Staircase staircase({27.0, 3.0, 3});
    askedOf(staircase, -1.0);
    const Threshold threshold = thresholdOf(staircase.turns());
    EXPECT_DOUBLE_EQ(threshold.value, 0.0);
    EXPECT_EQ(threshold.bounds, 6);
}

TEST(Staircase, RefusesStepsThatDoNotFit)
{
    EXPECT_EQ(problemOf(StaircaseSettings{45.0, 2.5, 3}), "");
    EXPECT_EQ(problemOf(StaircaseSettings{45.0, 4.0, 3}),
              "the staircase's step is 4; it must be a whole part of its maximum, at most 1000 of "
              "them");
    EXPECT_NE(problemOf(StaircaseSettings{45.0, 0.0, 3}), "");
    EXPECT_NE(problemOf(StaircaseSettings{45.0, 0.01, 3}), "");
    EXPECT_NE(problemOf(StaircaseSettings{NAN, 1.0, 3}), "");
    EXPECT_NE(problemOf(StaircaseSettings{45.0, 5.0, 0}), "");
}

TEST(LineExperiment, PlacesTheLine)
{
    const Eigen::Matrix3Xd straight = lineExperiment("oblique").points(0.0);
    ASSERT_EQ(straight.cols(), 5);
    EXPECT_NEAR((straight.col(4) - straight.col(0)).norm(), 0.034, 1e-12);
    EXPECT_NEAR((straight.col(1) - straight.col(0)).norm(), 0.0085, 1e-12);
    const Eigen::Matrix3Xd oblique = lineExperiment("oblique").points(45.0);
    EXPECT_NEAR(oblique.rowwise().mean().norm(), 0.0, 1e-12);
    const Eigen::Vector3d along = (oblique.col(4) - oblique.col(0)).normalized();
    EXPECT_NEAR(along.x(), std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(std::abs(along.z()), std::sqrt(0.5), 1e-12);
    const Eigen::Matrix3Xd shifted = lineExperiment("shifted").points(27.0);
    EXPECT_TRUE(shifted.isApprox(straight.colwise() + Eigen::Vector3d(0.0, 0.0, 0.027), 1e-12));
    EXPECT_THROW(lineExperiment("shfted"), std::runtime_error);
}

TEST(SimulatedParticipant, FeelsAsOftenAsItsCurveSays)
{
    const SimulatedParticipant person{17.9, 5.0, 0.1, 7};
    EXPECT_DOUBLE_EQ(person.chance(17.9), 0.5);
    EXPECT_NEAR(person.chance(17.9 + 5.0), 0.05 + 0.9 * 0.841345, 1e-6);
    EXPECT_NEAR(person.chance(1e9), 0.95, 1e-12);
    for (const double value : {10.0, 17.9, 25.0})
    {
        constexpr int kTrials = 20000;
        int felt = 0;
        for (int trial = 1; trial <= kTrials; ++trial)
            felt += person.feels(trial, value) ? 1 : 0;
        const double chance = person.chance(value);
        EXPECT_NEAR(
            felt / double(kTrials), chance, 4.0 * std::sqrt(chance * (1.0 - chance) / kTrials));
    }
}

TEST(SimulatedParticipant, AnswersATrialAlwaysAlike)
{
    SimulatedParticipant person{17.9, 5.0, 0.1, 7};
    std::vector<bool> first, again, others;
    for (int trial = 1; trial < 60; ++trial)
        first.push_back(person.feels(trial, 17.9));
    for (int trial = 59; trial > 0; --trial)
        again.insert(again.begin(), person.feels(trial, 17.9));
    EXPECT_EQ(first, again);
    person.seed = 8;
    for (int trial = 1; trial < 60; ++trial)
        others.push_back(person.feels(trial, 17.9));
    EXPECT_NE(first, others);
}

// The bar: found within the participant's own spread. 95 % of sessions, less four standard errors
// of a share of 400.
TEST(Rehearsal, FindsThresholdsWithinTheParticipantsOwnSpread)
{
    for (const LineExperiment& experiment : lineExperiments())
        for (const double sign : {-1.0, 0.0, 1.0})
        {
            const StaircaseSettings settings{experiment.maximum, experiment.step, 3};
            const SimulatedParticipant person{experiment.paperMean +
                                                  sign * experiment.paperDeviation,
                                              2.0 * experiment.step,
                                              0.02,
                                              1};
            const Rehearsal found = rehearse(person, settings, 400);
            SCOPED_TRACE(experiment.name + " " + std::to_string(person.threshold));
            EXPECT_GE(found.fit.within, 0.95 - 4.0 * std::sqrt(0.95 * 0.05 / 400));
            EXPECT_LT(std::abs(found.fit.bias), 0.2 * person.spread);
            EXPECT_LT(found.fit.deviation, 0.6 * person.spread);
            EXPECT_GE(found.covered, 0.85);
            // The mean of the turns is biased towards the maximum, where they begin.
            EXPECT_GT(found.turns.bias, 2.0 * found.turns.biasError);
            EXPECT_GT(found.turns.bias, std::abs(found.fit.bias));
        }
}

TEST(PsychometricFit, FindsTheCurveOfManyAnswers)
{
    const SimulatedParticipant person{20.0, 6.0, kFitLapse, 3};
    std::vector<Trial> trials;
    for (int trial = 1; trial <= 4000; ++trial)
    {
        Trial& made = trials.emplace_back();
        made.value = 2.5 * (trial % 19);
        made.isFelt = person.feels(trial, made.value);
    }
    const PsychometricFit fit = fitTrials(trials, {45.0, 2.5, 3});
    EXPECT_NEAR(fit.threshold, 20.0, 4.0 * fit.thresholdError + 0.19); // half a place of its grid
    EXPECT_LT(fit.thresholdError, 0.5);
    EXPECT_NEAR(fit.spread, 6.0, 0.7);
}
