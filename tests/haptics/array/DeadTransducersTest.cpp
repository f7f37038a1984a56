#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/propagation/TransducerGroups.h"
#include "haptics/solvers/HologramSolver.h"

#include <algorithm>
#include <numeric>
#include <string>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

std::string fileWith(const std::string& dead)
{
    return R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10.1, "directivity": "point",
               "boards": [{"position_m": [0, 0, 0], "normal": [0, 0, 1],
                           "columns": 3, "rows": 2, "pitch_m": 0.01}],
               "dead": )" +
           dead + "}";
}

std::string refusal(const std::string& dead)
{
    try
    {
        TransducerArray::fromJson(fileWith(dead), "a.json");
    }
    catch (const midair::base::InputError& error)
    {
        return error.what();
    }
    return {};
}

ControlPoints fourPoints()
{
    ControlPoints points;
    points.positions.resize(3, 4);
    points.positions << -0.02, 0.02, 0.0, 0.0, 0.0, 0.0, -0.02, 0.02, 0.15, 0.15, 0.15, 0.16;
    points.normals = Eigen::Matrix3Xd::Zero(3, 4);
    points.targets = Eigen::VectorXd::Ones(4);
    return points;
}

} // namespace

TEST(DeadTransducers, AFileNamesThemByTheirNumbers)
{
    const TransducerArray array = TransducerArray::fromJson(fileWith("[4, 1]"), "a.json");
    EXPECT_EQ(array.dead, (std::vector<int>{1, 4}));
    ASSERT_EQ(array.gain.size(), 6);
    for (int i = 0; i < 6; ++i)
        EXPECT_EQ(array.gain[i], i == 1 || i == 4 ? 0.0 : 1.0);
    EXPECT_TRUE(array.isValid());
    const TransducerArray again = TransducerArray::fromJson(array.toJson(), "b.json");
    EXPECT_EQ(again.dead, array.dead);
    EXPECT_TRUE(again.gain == array.gain);
}

TEST(DeadTransducers, ImpossibleNumbersAreRefused)
{
    EXPECT_EQ(refusal("[6]"),
              "a.json: dead[0] is 6; it must be the number of a transducer, 0 to 5");
    EXPECT_EQ(refusal("[-1]"),
              "a.json: dead[0] is -1; it must be the number of a transducer, 0 to 5");
    EXPECT_EQ(refusal("[2, 2]"), "a.json: dead[1] is 2; it must be there once");
    EXPECT_EQ(refusal("7"),
              "a.json: dead is 7; it must be a list of numbers of transducers, from 0");
    EXPECT_EQ(refusal("[]"), "");
}

TEST(DeadTransducers, AListThatDoesNotFitTheGainsIsNotValid)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.dead = {3};
    std::string error;
    EXPECT_FALSE(array.isValid(&error));
    EXPECT_EQ(error, "the dead transducers are not ascending numbers of transducers of gain 0");
    array.setDead({3, 1});
    EXPECT_TRUE(array.isValid(&error)) << error;
    EXPECT_EQ(array.dead, (std::vector<int>{1, 3}));
}

// Every solver knows: the pressures are right though the dead ones do nothing.
TEST(DeadTransducers, FieldsAreSolvedForWithoutThem)
{
    TransducerArray array = TransducerArray::singleBoard();
    std::vector<int> dead;
    for (int i = 0; i < array.size(); i += 3)
        dead.push_back(i);
    array.setDead(dead);
    const ControlPoints points = fourPoints();
    const Medium medium;
    const Eigen::MatrixXcd G = referencePropagationMatrix(points.positions, array, medium);
    for (const std::string& name : solverNames())
    {
        Eigen::VectorXcf q;
        const SolveReport report = makeSolver(name)->solve(points, array, medium, q);
        ASSERT_TRUE(q.allFinite()) << name;
        for (const int i : dead)
            q[i] = 0.0F;
        const Eigen::VectorXd p = (G * q.cast<std::complex<double>>()).cwiseAbs();
        EXPECT_NEAR(p.mean() / report.level_Pa, 1.0, 0.02) << name;
        EXPECT_GT(p.minCoeff(), 0.8 * p.maxCoeff()) << name;
    }
}

/// The octagon with a share of its transducers dead: every \a nth one.
TransducerArray thinned(int nth)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    std::vector<int> dead;
    for (int i = 0; i < array.size(); i += nth)
        dead.push_back(i);
    array.setDead(dead);
    return array;
}

// Columns of G that are left out, not multiplied by 0: what is solved for, and its cost, is less.
// Where what is left has gaps a few columns are 0.
TEST(DeadTransducers, HaveNoColumnInTheMatrix)
{
    for (const int nth : {2, 3, 4, 16})
    {
        const TransducerArray array = thinned(nth);
        const auto live = array.size() - static_cast<int>(array.dead.size());
        PropagationMatrix G;
        G.bind(array, Medium());
        EXPECT_EQ(G.arraySize(), 3984);
        EXPECT_GE(G.transducers(), live);
        EXPECT_LE(G.transducers(), nth == 2 ? 3984 : 1.1 * live) << nth;
        Eigen::Matrix3Xd points(3, 2);
        points << 0.0, 0.02, 0.01, -0.01, 0.03, 0.02;
        G.build(points);
        const Eigen::MatrixXcd exact = referencePropagationMatrix(points, array, Medium());
        std::vector<int> seen(static_cast<std::size_t>(array.size()));
        for (int lane = 0; lane < G.transducers(); ++lane)
        {
            const int i = G.order()[static_cast<std::size_t>(lane)];
            EXPECT_EQ(G.isSilent(lane), G.isFiller(lane) || i % nth == 0);
            if (!G.isSilent(lane)) ++seen[static_cast<std::size_t>(i)];
            for (int l = 0; l < 2; ++l)
            {
                const auto entry = std::complex<double>(G.at(l, lane));
                const std::complex<double> right = G.isSilent(lane) ? 0.0 : exact(l, i);
                EXPECT_LE(std::abs(entry - right), 1e-4 * std::abs(exact(l, i)));
            }
        }
        for (int i = 0; i < array.size(); ++i)
            EXPECT_EQ(seen[static_cast<std::size_t>(i)], i % nth == 0 ? 0 : 1) << i;
    }
}

// No group of what is left spans a gap: such a group's block is computed in double, which takes a
// hundred times as long.
TEST(DeadTransducers, GroupsOfWhatIsLeftAreCompact)
{
    const TransducerArray array = thinned(4);
    std::vector<int> live;
    for (int i = 0; i < array.size(); ++i)
        if (i % 4 != 0) live.push_back(i);
    constexpr double kLargest_m = 6.5 * 8.58e-3;
    std::vector<int> order = compactOrder(array.positions(Eigen::all, live), kernels::kGroup);
    for (int& i : order)
        i = live[static_cast<std::size_t>(i)];
    EXPECT_FALSE(isCompact(array.positions, order, kernels::kGroup, kLargest_m))
        << "or this tests nothing";
    const PackedOrder all = packed(array.positions, order, kernels::kGroup, kLargest_m);
    EXPECT_TRUE(isCompact(array.positions, all.order, kernels::kGroup, kLargest_m));
    EXPECT_LT(all.order.size(), 1.1 * static_cast<double>(live.size()));
    std::vector<int> kept;
    for (std::size_t k = 0; k < all.order.size(); ++k)
        if (!all.isFiller[k]) kept.push_back(all.order[k]);
    EXPECT_EQ(kept, order);
}

// With columns that stand for nothing, too: nobody gets what is theirs.
TEST(DeadTransducers, FieldsOfAnArrayWithGapsAreAsReported)
{
    const TransducerArray array = thinned(4);
    ControlPoints points = fourPoints();
    points.positions.row(2).array() -= 0.15;
    for (const std::string& name : solverNames())
    {
        Eigen::VectorXcf q;
        const auto solver = makeSolver(name);
        solver->solve(points, array, Medium(), q);
        points.positions.row(0).array() += 1e-3;
        const SolveReport report = solver->solve(points, array, Medium(), q);
        points.positions.row(0).array() -= 1e-3;
        for (const int i : array.dead)
            ASSERT_EQ(q[i], std::complex<float>()) << name << ", " << i;
        EXPECT_GT(q.cwiseAbs().sum(), 0.9F * 2988.0F) << name;
        ControlPoints moved = points;
        moved.positions.row(0).array() += 1e-3;
        const Eigen::VectorXd p = (referencePropagationMatrix(moved.positions, array, Medium()) *
                                   q.cast<std::complex<double>>())
                                      .cwiseAbs();
        EXPECT_NEAR(p.mean() / report.level_Pa, 1.0, 0.02) << name;
        EXPECT_LE(report.driveChange, 4.0 + 1e-3) << name;
    }
}

// As a mask moves, a solver gets the same array with other columns, more of them or fewer: its last
// field has room for all. A change is that of the transducers that are left.
TEST(DeadTransducers, ComeAndGoWhileASolverSolves)
{
    ControlPoints points = fourPoints();
    points.positions.row(2).array() -= 0.15;
    for (const std::string& name : solverNames())
        for (const bool absolute : {false, true})
        {
            points.absolute = absolute;
            points.targets.setConstant(absolute ? 500.0 : 1.0);
            const auto solver = makeSolver(name);
            Eigen::VectorXcf before, q;
            for (const int each : {2, 40, 3, 2, 1000, 5})
            {
                before = q;
                const TransducerArray array = thinned(each);
                const SolveReport report = solver->solve(points, array, Medium(), q);
                if (before.size() == 0) continue;
                for (const int i : array.dead)
                    before[i] = 0.0F;
                const float change = (q - before).squaredNorm() / q.squaredNorm();
                EXPECT_NEAR(report.driveChange, change, 1e-3F * (1.0F + change))
                    << name << ", every " << each << "th is dead, absolute " << absolute;
            }
        }
}

// Without any that lives the matrix keeps its shape, and is 0.
TEST(DeadTransducers, AnArrayMayBeDead)
{
    TransducerArray array = TransducerArray::singleBoard();
    std::vector<int> all(249);
    std::iota(all.begin(), all.end(), 0);
    array.setDead(all);
    for (const std::string& name : solverNames())
    {
        Eigen::VectorXcf q;
        const SolveReport report = makeSolver(name)->solve(fourPoints(), array, Medium(), q);
        EXPECT_EQ(report.stop, StopReason::NOTHING_TO_DO) << name;
        EXPECT_EQ(q.size(), 249) << name;
        EXPECT_TRUE(q.isZero(0.0f)) << name;
    }
}

// No solver drives one, whatever it does with amplitudes, and a field that others die in goes on.
TEST(DeadTransducers, AreDrivenWithNothing)
{
    for (const bool phaseOnly : {true, false})
        for (const std::string& name : solverNames())
        {
            SolverOptions options;
            options.phaseOnly = phaseOnly;
            TransducerArray array = TransducerArray::singleBoard();
            array.setDead({0, 17, 248});
            const auto solver = makeSolver(name, options);
            Eigen::VectorXcf q;
            for (const int next : {100, 101, 102})
            {
                const SolveReport report = solver->solve(fourPoints(), array, Medium(), q);
                ASSERT_EQ(q.size(), 249) << name;
                for (const int i : array.dead)
                    EXPECT_EQ(q[i], std::complex<float>()) << name << ", " << i;
                EXPECT_GT(report.loudness, 0.5) << name;
                array.setDead({next});
            }
        }
}

TEST(DeadTransducers, AFileNamesWeakOnesByTheirNumbers)
{
    const auto read = [](const std::string& weak)
    { return TransducerArray::fromJson(fileWith("[1], \"weak\": " + weak), "a.json"); };
    const TransducerArray array = read("[[4, 0.5], [0, 1.25]]");
    EXPECT_EQ(array.gain, (Eigen::VectorXd(6) << 1.25, 0.0, 1.0, 1.0, 0.5, 1.0).finished());
    EXPECT_EQ(TransducerArray::fromJson(array.toJson(), "b.json").gain, array.gain);
    const auto whyNot = [&](const std::string& weak) -> std::string
    {
        try
        {
            read(weak);
        }
        catch (const midair::base::InputError& error)
        {
            return error.what();
        }
        return {};
    };
    EXPECT_EQ(whyNot("[[1, 0.5]]"),
              "a.json: weak[0] is [1,0.5]; it must be of a transducer that isn't dead");
    EXPECT_EQ(whyNot("[[2, 0.5], [2, 0.6]]"), "a.json: weak[1] is [2,0.6]; it must be there once");
    EXPECT_EQ(whyNot("[[2, 0]]").find("a.json: weak[0] is [2,0]; "), 0U) << whyNot("[[2, 0]]");
    EXPECT_NE(whyNot("[[2, 0]]").find("dead"), std::string::npos) << whyNot("[[2, 0]]");
    EXPECT_EQ(whyNot("[2]"),
              "a.json: weak[0] is 2; it must be [number of a transducer, 0 to 5, gain above 0 and "
              "at most 1000]");
}

TEST(DeadTransducers, UsersNameThemToo)
{
    TransducerArray array = TransducerArray::fromJson(fileWith("[1]"), "a.json");
    array.mark("4-5", "0:0.5, 2-3:0.75");
    EXPECT_EQ(array.dead, (std::vector<int>{1, 4, 5}));
    EXPECT_EQ(array.gain, (Eigen::VectorXd(6) << 0.5, 0.0, 0.75, 0.75, 0.0, 0.0).finished());
    EXPECT_TRUE(array.isValid());
    const auto whyNot = [](const std::string& dead, const std::string& weak) -> std::string
    {
        try
        {
            TransducerArray::fromJson(fileWith("[1]"), "a.json").mark(dead, weak);
        }
        catch (const midair::base::InputError& error)
        {
            return error.what();
        }
        return {};
    };
    EXPECT_EQ(whyNot("6", ""), "dead has 6; the array has 6 transducers, 0 to 5");
    EXPECT_EQ(whyNot("", "2-9:0.5"), "weak has 9; the array has 6 transducers, 0 to 5");
    EXPECT_EQ(whyNot("", "1:0.5"), "weak has 1, which is dead; it can be only one of both");
    EXPECT_EQ(whyNot("1", ""), "");
    EXPECT_EQ(whyNot("", ""), "");
}
