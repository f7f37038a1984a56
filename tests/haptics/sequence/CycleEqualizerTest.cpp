#include "haptics/sequence/CycleEqualizer.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "tests/haptics/sequence/SteppedCycle.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

const Eigen::Vector3d kMiddle(0.0, 0.0, 0.12);

std::vector<Eigen::VectorXcf> randomFields(int count, int m, unsigned seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> phase(-3.0f, 3.0f);
    std::vector<Eigen::VectorXcf> fields;
    for (int k = 0; k < count; ++k)
    {
        Eigen::VectorXcf& q = fields.emplace_back(m);
        for (std::complex<float>& one : q)
            one = std::polar(1.0f, phase(random));
    }
    return fields;
}

/// 0.5 at the lower half of a sphere, 1 at the upper.
ControlPoints halves()
{
    ControlPoints places = spherePoints(80, 0.015, kMiddle);
    for (Eigen::Index l = 0; l < places.targets.size(); ++l)
        places.targets[l] = places.positions(2, l) < kMiddle.z() ? 0.5 : 1.0;
    return places;
}

/// Mean and weighted variation of |p|^2 / a^2, by the formula in double precision.
std::pair<double, double> measured(const ControlPoints& places,
                                   const TransducerArray& array,
                                   const std::vector<Eigen::VectorXcf>& fields)
{
    const Eigen::MatrixXcd G = referencePropagationMatrix(places.positions, array, Medium());
    Eigen::VectorXd square = Eigen::VectorXd::Zero(G.rows());
    for (const Eigen::VectorXcf& q : fields)
        square += (G * q.cast<std::complex<double>>()).cwiseAbs2();
    const Eigen::ArrayXd weight = places.targets.array().square();
    const Eigen::ArrayXd ratio = square.array() / weight;
    const double mean = (weight * ratio).sum() / weight.sum();
    return {mean, std::sqrt((weight * (ratio - mean).square()).sum() / weight.sum()) / mean};
}

/// The same of fields that ring, each for \a step_s: by small steps in time, sound at once; the
/// mean is a sum over the fields.
std::pair<double, double> measuredRinging(const ControlPoints& places,
                                          const TransducerArray& array,
                                          const std::vector<Eigen::VectorXcf>& fields,
                                          double step_s)
{
    const Eigen::MatrixXcd G = referencePropagationMatrix(places.positions, array, Medium());
    Eigen::MatrixXcd p(G.rows(), static_cast<Eigen::Index>(fields.size()));
    for (std::size_t k = 0; k < fields.size(); ++k)
        p.col(static_cast<Eigen::Index>(k)) = G * fields[k].cast<std::complex<double>>();
    const Eigen::ArrayXd square = static_cast<double>(fields.size()) *
                                  steppedSquares(p, step_s, array.ringing_s).rowwise().mean();
    const Eigen::ArrayXd weight = places.targets.array().square();
    const Eigen::ArrayXd ratio = square / weight;
    const double mean = (weight * ratio).sum() / weight.sum();
    return {mean, std::sqrt((weight * (ratio - mean).square()).sum() / weight.sum()) / mean};
}

int toTheEnd(CycleEqualizer& equalizer)
{
    int slices = 0;
    while (equalizer.step() && slices < 1000000)
        ++slices;
    return slices;
}

TEST(CycleEqualizer, ReachesTheTargetsRatiosAndTellsHowWell)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.drive.phaseLevels = 0;
    const ControlPoints places = halves();
    const std::vector<Eigen::VectorXcf> given = randomFields(4, array.size(), 1);
    const auto [meanBefore, before] = measured(places, array, given);
    double last = before;
    for (const int passes : {1, 5, 40})
    {
        CycleEqualizerOptions options;
        options.passes = passes;
        CycleEqualizer equalizer(options, {});
        ASSERT_TRUE(equalizer.begin(places, array, Medium(), given));
        toTheEnd(equalizer);
        EXPECT_LE(equalizer.passes(), passes);
        const auto [mean, variation] = measured(places, array, equalizer.fields());
        EXPECT_NEAR(equalizer.variation(), variation, 2e-3 + 2e-3 * variation);
        EXPECT_NEAR(equalizer.gain(), mean / meanBefore, 2e-3 * equalizer.gain());
        EXPECT_LT(variation, last);
        last = variation;
    }
    EXPECT_LT(last, 0.3 * before);
}

/// The objective by its formula, in double precision, for a goal in Pa^2.
double objective(const Eigen::MatrixXcd& G,
                 const Eigen::VectorXd& targets,
                 const std::vector<Eigen::VectorXcd>& fields,
                 double goal)
{
    Eigen::ArrayXd square = Eigen::ArrayXd::Zero(G.rows());
    for (const Eigen::VectorXcd& q : fields)
        square += (G * q).cwiseAbs2().array() / static_cast<double>(fields.size());
    const Eigen::ArrayXd weight = targets.array().square();
    return (weight * (square / (goal * weight) - 1.0).square()).sum() / weight.sum();
}

// The first step is that of steepest descent. A turn by (1 + j d/2)/(1 - j d/2) tells d.
TEST(CycleEqualizer, TheFirstTurnIsDownTheGradientOfTheFormula)
{
    constexpr double kSmall = 1e-4; // rad; of a central difference
    TransducerArray array = TransducerArray::singleBoard();
    array.drive.phaseLevels = 0;
    const ControlPoints places = halves();
    const Eigen::MatrixXcd G = referencePropagationMatrix(places.positions, array, Medium());
    for (const int count : {1, 3})
    {
        const std::vector<Eigen::VectorXcf> given = randomFields(count, array.size(), 4);
        std::vector<Eigen::VectorXcd> q;
        for (const Eigen::VectorXcf& field : given)
            q.push_back(field.cast<std::complex<double>>());
        CycleEqualizerOptions options;
        options.passes = 1;
        const double goal = (count == 1 ? options.heldRaise : options.raise) *
                            measured(places, array, given).first / count;
        CycleEqualizer equalizer(options, {});
        ASSERT_TRUE(equalizer.begin(places, array, Medium(), given));
        toTheEnd(equalizer);
        ASSERT_EQ(equalizer.passes(), 1);
        const std::vector<Eigen::VectorXcf> turned = equalizer.fields();
        Eigen::VectorXd gradient(count * array.size()), turns(gradient.size());
        Eigen::Index at = 0;
        for (std::size_t k = 0; k < q.size(); ++k)
            for (Eigen::Index i = 0; i < array.size(); ++i, ++at)
            {
                const std::complex<double> one = q[k][i];
                q[k][i] = one * std::polar(1.0, kSmall);
                const double after = objective(G, places.targets, q, goal);
                q[k][i] = one * std::polar(1.0, -kSmall);
                const double before = objective(G, places.targets, q, goal);
                q[k][i] = one;
                gradient[at] = (after - before) / (2.0 * kSmall);
                turns[at] = 2.0 * std::tan(0.5 * std::arg(turned[k][i] * std::conj(given[k][i])));
            }
        // In float, with rows in 16 bits: within a thousandth of its length.
        const Eigen::VectorXd down = -gradient * (turns.norm() / gradient.norm());
        EXPECT_LT((turns - down).norm(), 2e-3 * turns.norm()) << count;
    }
}

// The same with ringing and its vibration, by small steps in time, for some of the transducers.
TEST(CycleEqualizer, TheFirstTurnOfWhatRingsIsDownTheGradientOfTheFormula)
{
    constexpr double kSmall = 1e-3; // rad; of a central difference
    constexpr double kStep_s = 1e-3;
    TransducerArray array = TransducerArray::singleBoard();
    array.drive.phaseLevels = 0;
    array.ringing_s = 190e-6;
    const ControlPoints places = halves();
    const Eigen::ArrayXd weight = places.targets.array().square();
    const Eigen::MatrixXcd G = referencePropagationMatrix(places.positions, array, Medium());
    for (const double calming : {0.0, 20.0})
    {
        const std::vector<Eigen::VectorXcf> given = randomFields(2, array.size(), 4);
        CycleEqualizerOptions options;
        options.passes = 1;
        options.calming = calming;
        const double goal =
            options.fewRaise * measuredRinging(places, array, given, kStep_s).first / 2.0;
        CycleEqualizer equalizer(options, {});
        ASSERT_TRUE(equalizer.begin(places, array, Medium(), given, kStep_s));
        toTheEnd(equalizer);
        ASSERT_EQ(equalizer.passes(), 1);
        const std::vector<Eigen::VectorXcf> turned = equalizer.fields();
        Eigen::MatrixXcd p(places.size(), 2);
        for (int k = 0; k < 2; ++k)
            p.col(k) = G * given[static_cast<std::size_t>(k)].cast<std::complex<double>>();
        const auto f = [&]
        {
            const Eigen::ArrayXd square =
                steppedSquares(p, kStep_s, array.ringing_s).rowwise().mean();
            return (weight * (square / (goal * weight) - 1.0).square()).sum() / weight.sum() +
                   calming *
                       steppedVibration2(
                           places.positions, p, kStep_s, array.ringing_s, goal * weight.mean());
        };
        std::vector<double> gradient, turns;
        for (int k = 0; k < 2; ++k)
            for (Eigen::Index i = k; i < array.size(); i += 16)
            {
                const std::complex<float> one = given[static_cast<std::size_t>(k)][i];
                const Eigen::VectorXcd part = G.col(i) * std::complex<double>(one);
                const Eigen::VectorXcd at = p.col(k);
                p.col(k) = at + part * (std::polar(1.0, kSmall) - 1.0);
                const double after = f();
                p.col(k) = at + part * (std::polar(1.0, -kSmall) - 1.0);
                gradient.push_back((after - f()) / (2.0 * kSmall));
                p.col(k) = at;
                const std::complex<float> turn =
                    turned[static_cast<std::size_t>(k)][i] * std::conj(one);
                turns.push_back(2.0 * std::tan(0.5 * std::arg(turn)));
            }
        const Eigen::Map<Eigen::VectorXd> found(turns.data(), Eigen::Index(turns.size()));
        const Eigen::Map<Eigen::VectorXd> slope(gradient.data(), found.size());
        const Eigen::VectorXd down = -slope * (found.norm() / slope.norm());
        EXPECT_LT((found - down).norm(), 5e-3 * found.norm()) << calming;
    }
}

TEST(CycleEqualizer, ASingleFieldKeepsItsPressure)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    array.drive.phaseLevels = 0;
    const ControlPoints places = spherePoints(300, 0.015, {0.0, 0.0, 0.0});
    const std::vector<Eigen::VectorXcf> given = randomFields(1, array.size(), 1);
    const auto [meanBefore, before] = measured(places, array, given);
    CycleEqualizerOptions options;
    options.passes = 200;
    options.heldRaise = 0.9; // too quiet a goal, which rises
    CycleEqualizer equalizer(options, {});
    ASSERT_TRUE(equalizer.begin(places, array, Medium(), given));
    toTheEnd(equalizer);
    const auto [mean, variation] = measured(places, array, equalizer.fields());
    EXPECT_NEAR(equalizer.variation(), variation, 2e-3 + 2e-3 * variation);
    EXPECT_NEAR(equalizer.gain(), mean / meanBefore, 2e-3 * equalizer.gain());
    EXPECT_NEAR(mean / meanBefore, CycleEqualizer::kHeldGain, 0.02);
    EXPECT_LT(variation, 0.4 * before);
}

TEST(CycleEqualizer, WhatRingsIsEvenAndTold)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.drive.phaseLevels = 0;
    array.ringing_s = 190e-6;
    const ControlPoints places = halves();
    const std::vector<Eigen::VectorXcf> given = randomFields(4, array.size(), 1);
    constexpr double kStep_s = 1e-3;
    const auto [meanBefore, before] = measuredRinging(places, array, given, kStep_s);
    CycleEqualizerOptions options;
    options.passes = 40;
    double variations[2];
    for (const bool knows : {false, true})
    {
        CycleEqualizer equalizer(options, {});
        ASSERT_TRUE(equalizer.begin(places, array, Medium(), given, knows ? kStep_s : 0.0));
        toTheEnd(equalizer);
        const auto [mean, variation] = measuredRinging(places, array, equalizer.fields(), kStep_s);
        variations[knows] = variation;
        if (!knows) continue;
        EXPECT_NEAR(equalizer.variation(), variation, 2e-3 + 2e-3 * variation);
        EXPECT_NEAR(equalizer.gain(), mean / meanBefore, 2e-3 * equalizer.gain());
        EXPECT_LT(variation, 0.3 * before);
    }
    EXPECT_LT(variations[true], 0.7 * variations[false]);
}

TEST(CycleEqualizer, WithoutRingingTheTimeOfAFieldDoesNotCount)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.ringing_s = 0.0;
    std::vector<std::vector<Eigen::VectorXcf>> found;
    for (const double step_s : {0.0, 1e-3})
    {
        CycleEqualizerOptions options;
        options.passes = 6;
        CycleEqualizer equalizer(options, {});
        ASSERT_TRUE(
            equalizer.begin(halves(), array, Medium(), randomFields(4, array.size(), 1), step_s));
        toTheEnd(equalizer);
        found.push_back(equalizer.fields());
    }
    EXPECT_EQ(found[0], found[1]);
}

TEST(CycleEqualizer, DoesNotDependOnTheThreads)
{
    const TransducerArray array = TransducerArray::singleBoard();
    const ControlPoints places = halves();
    std::vector<std::vector<Eigen::VectorXcf>> found;
    for (const int threads : {1, 2, 3, 5})
    {
        SolverOptions solver;
        solver.threads = threads;
        CycleEqualizerOptions options;
        options.passes = 8;
        CycleEqualizer equalizer(options, solver);
        ASSERT_TRUE(equalizer.begin(places, array, Medium(), randomFields(11, array.size(), 2)));
        toTheEnd(equalizer);
        found.push_back(equalizer.fields());
        EXPECT_EQ(found.back(), found.front()) << threads;
    }
}

TEST(CycleEqualizer, BeginsAnewWithOtherFieldsAndSizes)
{
    const TransducerArray array = TransducerArray::singleBoard();
    CycleEqualizerOptions options;
    options.passes = 6;
    CycleEqualizer used(options, {});
    ASSERT_TRUE(used.begin(halves(), array, Medium(), randomFields(5, array.size(), 3)));
    for (int k = 0; k < 17; ++k)
        used.step();
    const ControlPoints fewer = spherePoints(50, 0.01, kMiddle);
    CycleEqualizer fresh(options, {});
    for (CycleEqualizer* one : {&used, &fresh})
    {
        ASSERT_TRUE(one->begin(fewer, array, Medium(), randomFields(3, array.size(), 4)));
        toTheEnd(*one);
    }
    EXPECT_EQ(used.fields(), fresh.fields());
}

TEST(CycleEqualizer, WhatIsAcceptedIsThereBetweenSlices)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.drive.phaseLevels = 0;
    const ControlPoints places = halves();
    CycleEqualizerOptions options;
    options.passes = 5;
    CycleEqualizer equalizer(options, {});
    ASSERT_TRUE(equalizer.begin(places, array, Medium(), randomFields(4, array.size(), 5)));
    while (equalizer.step())
    {
        if (equalizer.passes() == 0) continue;
        const double variation = measured(places, array, equalizer.fields()).second;
        ASSERT_NEAR(equalizer.variation(), variation, 2e-3 + 2e-3 * variation);
    }
    EXPECT_EQ(equalizer.passes(), 5);
}

TEST(CycleEqualizer, WherePressureAndEvennessDontGoTogetherPressureStays)
{
    // Two fields of few transducers can't be even on so large a surface.
    TransducerArray array = TransducerArray::singleBoard();
    const ControlPoints places = spherePoints(600, 0.05, kMiddle);
    for (const unsigned seed : {6u, 7u, 8u})
    {
        CycleEqualizerOptions options;
        options.passes = 100;
        CycleEqualizer equalizer(options, {});
        ASSERT_TRUE(equalizer.begin(places, array, Medium(), randomFields(2, array.size(), seed)));
        toTheEnd(equalizer);
        EXPECT_GT(equalizer.gain(), 0.98);
    }
}

TEST(CycleEqualizer, AStopIsThrownAndTheWorkGoesOnAfterIt)
{
    const TransducerArray array = TransducerArray::singleBoard();
    base::StopSource source;
    SolverOptions solver;
    solver.stop = source.token();
    CycleEqualizer equalizer({}, solver);
    ASSERT_TRUE(equalizer.begin(halves(), array, Medium(), randomFields(3, array.size(), 9)));
    source.request();
    EXPECT_THROW(equalizer.step(), base::Stopped);
    EXPECT_TRUE(equalizer.hasWork());
    source.clear();
    toTheEnd(equalizer);
    EXPECT_GT(equalizer.passes(), 3);
}

TEST(CycleEqualizer, OptionsOutOfRangeAreNamed)
{
    CycleEqualizerOptions options;
    std::string error;
    options.passes = -1;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "passes is -1; it must be at least 0");
    EXPECT_THROW(CycleEqualizer(options, {}), base::InputError);
    options.passes = 1;
    options.raise = 0.0;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "raise is 0; it must be above 0");
    options.raise = 1.2;
    options.ringingRaise = -1.0;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "ringingRaise is -1; it must be above 0");
    options.ringingRaise = 1.2;
    options.fewRaise = 0.0;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "fewRaise is 0; it must be above 0");
    options.fewRaise = 1.3;
    options.calming = -1.0;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "calming is -1; it must be at least 0");
    options.calming = 0.0;
    options.heldRaise = 0.0;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "heldRaise is 0; it must be above 0");
}

} // namespace
} // namespace midair::haptics
