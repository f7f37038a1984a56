// Boards that were put up by hand, measured with noise, and found again.
#include "haptics/boards/BoardFit.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

/// \a array with each of its boards off by some millimetres and degrees.
TransducerArray putUp(TransducerArray array, double off_m, double off_deg, unsigned seed)
{
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto vector = [&]
    { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
    for (const BoardRange& board : boardsOf(array))
    {
        const Eigen::Vector3d middle = middleOf(array, board), shift = off_m * vector();
        const Eigen::Vector3d turn = base::toRadians(off_deg) * vector();
        moveBoard(Eigen::Translation3d(middle + shift) *
                      Eigen::AngleAxisd(turn.norm(), turn.normalized()) *
                      Eigen::Translation3d(-middle),
                  board,
                  array);
    }
    return array;
}

/// The plan's distances in \a truth, with errors.
BoardMeasurements
measured(const BoardPlan& plan, const TransducerArray& truth, double sigma_m, unsigned seed)
{
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::string text;
    for (const PlannedDistance& one : plan.distances)
        text += fmt::format(
            "{} {} {:.9f}\n",
            one.from,
            one.to,
            (truth.positions.col(one.fromTransducer) - truth.positions.col(one.toTransducer))
                    .norm() +
                sigma_m * normal(random));
    return readBoardMeasurements(text, "tape", truth);
}

/// rms distance of the transducers of both, after the best common motion if \a isFree.
double apart_m(const TransducerArray& a, const TransducerArray& b, bool isFree)
{
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    if (isFree) motion = Eigen::Isometry3d(Eigen::umeyama(a.positions, b.positions, false));
    const Eigen::Matrix3Xd d = motion * a.positions - b.positions;
    return std::sqrt(d.colwise().squaredNorm().mean());
}

/// Two boards that face each other, 0.2 m apart, and one at their side.
TransducerArray threeBoards()
{
    return TransducerArray::fromJson(R"({"name": "three", "frequency_Hz": 40000,
        "sourceAmplitude_Pa_m": 10.1, "directivity": "point", "boards": [
        {"position_m": [0, -0.1, 0], "normal": [0, 1, 0], "columns": 16, "rows": 16, "pitch_m": 0.01},
        {"position_m": [0, 0.1, 0], "normal": [0, -1, 0], "columns": 16, "rows": 16, "pitch_m": 0.01},
        {"position_m": [0.15, 0, 0], "normal": [-1, 0, 0], "columns": 16, "rows": 16, "pitch_m": 0.01}]})",
                                     "three");
}

std::string all(const std::vector<std::string>& texts)
{
    std::string joined;
    for (const std::string& text : texts)
        joined += text + "\n";
    return joined;
}

std::string refusal(const std::string& text)
{
    try
    {
        readBoardMeasurements(text, "tape", threeBoards());
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return {};
}

/// Distances of all corners of board \a a to all of board \a b.
std::string corners(int a, int b, const TransducerArray& truth)
{
    const BoardMarks marks(truth);
    std::string text;
    for (const char from : {'a', 'b', 'c', 'd'})
        for (const char to : {'a', 'b', 'c', 'd'})
            text += fmt::format("{}:{} {}:{} {:.9f}\n",
                                a,
                                from,
                                b,
                                to,
                                (truth.positions.col(marks.corner(a, from)) -
                                 truth.positions.col(marks.corner(b, to)))
                                    .norm());
    return text;
}

} // namespace

// 16 boards off by 3 mm and 1 degree are found to below what one distance is measured to, by 135
// distances for their 90 unknowns.
TEST(BoardFit, TheOctagonFromATapeMeasure)
{
    const TransducerArray nominal = TransducerArray::octagonalPrism();
    const BoardPlan plan = planBoards(nominal, {});
    EXPECT_EQ(plan.distances.size(), 135U);
    EXPECT_TRUE(plan.problems.empty()) << all(plan.problems);
    for (unsigned seed = 1; seed <= 3; ++seed)
    {
        const TransducerArray truth = putUp(nominal, 3e-3, 1.0, seed);
        const BoardFitReport report =
            fitBoards(nominal, measured(plan, truth, 1e-3, 100 + seed), {});
        ASSERT_TRUE(report.usable) << all(report.problems);
        EXPECT_GT(apart_m(nominal, truth, true), 3e-3);
        EXPECT_LT(apart_m(report.array, truth, true), 1.5e-3);
        EXPECT_NEAR(report.noise_m, 1e-3, 0.4e-3);
        // The plan foresees how well.
        for (const BoardPose& board : report.boards)
            EXPECT_LT(board.uncertain_m, 1.5 * plan.uncertain_m);
        // The whole stays where it was.
        EXPECT_LT(
            (report.array.positions.rowwise().mean() - nominal.positions.rowwise().mean()).norm(),
            1e-9);
        EXPECT_TRUE(report.array.isValid());
    }
}

// Three boards off by 50 mm and 20 degrees are not taken for their mirror images, nor anything
// else.
TEST(BoardFit, FarOff)
{
    const TransducerArray nominal = threeBoards();
    const BoardPlan plan = planBoards(nominal, {});
    for (const double sigma_m : {0.0, 1e-3})
        for (unsigned seed = 1; seed <= 12; ++seed)
        {
            SCOPED_TRACE(fmt::format("sigma {} m, seed {}", sigma_m, seed));
            const TransducerArray truth = putUp(nominal, 50e-3, 20.0, seed);
            const BoardFitReport report =
                fitBoards(nominal, measured(plan, truth, sigma_m, 100 + seed), {});
            ASSERT_TRUE(report.usable) << all(report.problems);
            // Compilers draw other noise; another minimum is tens of millimetres off.
            EXPECT_LT(apart_m(report.array, truth, true), 1e-6 + 5.0 * sigma_m);
        }
}

// Without errors they are found exactly, and what they are uncertain by scales with sigma.
TEST(BoardFit, ExactDistancesGiveExactPoses)
{
    const TransducerArray nominal = threeBoards();
    const TransducerArray truth = putUp(nominal, 4e-3, 2.0, 5);
    const BoardPlan plan = planBoards(nominal, {});
    const BoardMeasurements distances = measured(plan, truth, 0.0, 1);
    const BoardFitReport report = fitBoards(nominal, distances, {});
    ASSERT_TRUE(report.usable) << all(report.problems);
    EXPECT_LT(apart_m(report.array, truth, true), 1e-6);
    BoardFitOptions finer;
    finer.sigma_m = 1e-4;
    EXPECT_NEAR(fitBoards(nominal, distances, finer).boards[1].uncertain_m,
                0.1 * report.boards[1].uncertain_m,
                0.01 * report.boards[1].uncertain_m);
    EXPECT_NE(all(report.notes).find("mirror"), std::string::npos);
}

// The uncertainty that is told is the spread of many measurements.
TEST(BoardFit, UncertaintyIsWhatRepeatedMeasurementsSpreadBy)
{
    const TransducerArray nominal = threeBoards();
    const BoardPlan plan = planBoards(nominal, {});
    double squares = 0.0, told = 0.0;
    constexpr int kTimes = 200;
    for (unsigned k = 0; k < kTimes; ++k)
    {
        const BoardFitReport report = fitBoards(nominal, measured(plan, nominal, 1e-3, k), {});
        ASSERT_TRUE(report.usable) << all(report.problems);
        squares += std::pow(report.boards[2].moved_m, 2) / kTimes;
        told = report.boards[2].uncertain_m;
    }
    // Of three directions that told is the worst.
    EXPECT_GT(std::sqrt(squares), 0.9 * told);
    EXPECT_LT(std::sqrt(squares), 1.1 * std::sqrt(3.0) * told);
}

TEST(BoardFit, AWrongDistanceIsLeftOutByName)
{
    const TransducerArray nominal = threeBoards();
    const TransducerArray truth = putUp(nominal, 3e-3, 1.0, 7);
    BoardPlanOptions options;
    options.count = 30;
    BoardMeasurements distances = measured(planBoards(nominal, options), truth, 0.5e-3, 1);
    distances.all[4].distance_m += 0.05;
    const BoardFitReport report = fitBoards(nominal, distances, {});
    ASSERT_TRUE(report.usable) << all(report.problems);
    EXPECT_EQ(std::count(report.leftOut.begin(), report.leftOut.end(), 1), 1);
    EXPECT_EQ(report.leftOut[4], 1);
    EXPECT_NEAR(report.residuals_m[4], -0.05, 3e-3);
    EXPECT_NE(all(report.notes).find(distances.all[4].name() + " (line 5) is left out"),
              std::string::npos)
        << all(report.notes);
    EXPECT_LT(apart_m(report.array, truth, true), 1.5e-3);
}

TEST(BoardFit, DistancesThatContradictEachOtherAreRefusedByName)
{
    const TransducerArray nominal = threeBoards();
    BoardPlanOptions options;
    options.count = 30;
    const BoardMeasurements distances = measured(planBoards(nominal, options), nominal, 15e-3, 3);
    const BoardFitReport report = fitBoards(nominal, distances, {});
    EXPECT_FALSE(report.usable);
    ASSERT_EQ(report.problems.size(), 1U) << all(report.problems);
    EXPECT_NE(report.problems[0].find("contradict each other"), std::string::npos);
    // The worst is named first.
    Eigen::Index worst = 0;
    report.residuals_m.cwiseAbs().maxCoeff(&worst);
    EXPECT_NE(report.problems[0].find("measured): " +
                                      distances.all[static_cast<std::size_t>(worst)].name()),
              std::string::npos)
        << report.problems[0];
    EXPECT_EQ(report.array.positions, nominal.positions);
}

TEST(BoardFit, ABoardWithoutMeasurementsIsNamed)
{
    const TransducerArray nominal = threeBoards();
    const BoardFitReport report =
        fitBoards(nominal, readBoardMeasurements(corners(0, 1, nominal), "tape", nominal), {});
    EXPECT_FALSE(report.usable);
    EXPECT_EQ(all(report.problems), "board 2 has no measurement\n");
}

// Two boards in one plane can move out of it without any distance telling, to first order.
TEST(BoardFit, WhatIsNotDeterminedIsNamed)
{
    const TransducerArray flat = TransducerArray::fromJson(
        R"({"name": "flat", "frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10.1,
            "directivity": "point", "boards": [
            {"position_m": [0, 0, 0], "normal": [0, 0, 1], "columns": 16, "rows": 16, "pitch_m": 0.01},
            {"position_m": [0.2, 0, 0], "normal": [0, 0, 1], "columns": 16, "rows": 16,
             "pitch_m": 0.01}]})",
        "flat");
    const BoardFitReport report =
        fitBoards(flat, readBoardMeasurements(corners(0, 1, flat), "tape", flat), {});
    EXPECT_FALSE(report.usable);
    EXPECT_NE(all(report.problems).find("is not determined: it can "), std::string::npos)
        << all(report.problems);
    const BoardPlan plan = planBoards(flat, {});
    EXPECT_FALSE(plan.problems.empty());
    EXPECT_TRUE(std::isinf(plan.uncertain_m));
}

// Board 2, measured to the corners of board 0 alone, could be on its other side.
TEST(BoardFit, MirroredPlacesAreTold)
{
    const TransducerArray nominal = threeBoards();
    const std::string one = corners(0, 1, nominal) + corners(0, 2, nominal);
    const BoardFitReport report =
        fitBoards(nominal, readBoardMeasurements(one, "tape", nominal), {});
    ASSERT_TRUE(report.usable) << all(report.problems);
    EXPECT_NE(all(report.notes).find("board 2 "), std::string::npos) << all(report.notes);
    EXPECT_NE(all(report.notes).find(" 200 mm away"), std::string::npos) << all(report.notes);
    EXPECT_LT(apart_m(report.array, nominal, false), 1e-6);
    // Not once it is measured to board 1, too.
    const BoardFitReport more = fitBoards(
        nominal, readBoardMeasurements(one + corners(1, 2, nominal), "tape", nominal), {});
    ASSERT_TRUE(more.usable) << all(more.problems);
    EXPECT_EQ(all(more.notes).find("in one plane"), std::string::npos) << all(more.notes);
}

// A microphone at four places that are known: sound from some transducers of each board, with a
// delay of the electronics that nobody knows. The whole is then where the places say.
TEST(BoardFit, FromTheTimesThatSoundTakesToAMicrophone)
{
    const TransducerArray nominal = threeBoards();
    TransducerArray truth = putUp(nominal, 3e-3, 1.0, 11);
    const Eigen::Isometry3d whole(Eigen::Translation3d(4e-3, -2e-3, 3e-3));
    for (const BoardRange& board : boardsOf(truth))
        moveBoard(whole, board, truth);
    const std::vector<Eigen::Vector3d> places = {
        {0.03, 0.01, 0.02}, {-0.04, 0.02, -0.03}, {0.0, -0.03, 0.05}, {-0.02, 0.03, 0.01}};
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    std::string text;
    for (std::size_t p = 0; p < places.size(); ++p)
        text += fmt::format("place m{} {} {} {}\n", p, places[p].x(), places[p].y(), places[p].z());
    for (int board = 0; board < 3; ++board)
        for (const int in : {0, 15, 240, 255, 119, 136})
            for (std::size_t p = 0; p < places.size(); ++p)
            {
                const double way_m = (truth.positions.col(256 * board + in) - places[p]).norm();
                text += fmt::format("{}:{} m{} {:.6f}us\n",
                                    board,
                                    in,
                                    p,
                                    way_m / 343.2 * 1e6 + 250.0 + normal(random) * 1.0);
            }
    const BoardFitReport report =
        fitBoards(nominal, readBoardMeasurements(text, "times", nominal), {});
    ASSERT_TRUE(report.usable) << all(report.problems);
    EXPECT_NEAR(report.delay_s, 250e-6, 10e-6);
    EXPECT_LT(apart_m(report.array, truth, false), 2e-3);
    EXPECT_GT(apart_m(nominal, truth, false), 5e-3);
    EXPECT_EQ(all(report.notes).find("mirror"), std::string::npos) << all(report.notes);
}

// A hook whose place is known about ties boards together, and is found.
TEST(BoardFit, APlaceThatIsKnownAboutIsFound)
{
    const TransducerArray nominal = threeBoards();
    const BoardPlan plan = planBoards(nominal, {});
    std::string text = "place hook about -100mm 0 50mm\n";
    const BoardMarks marks(nominal);
    const Eigen::Vector3d hook(-0.12, 0.02, 0.06);
    for (int board = 0; board < 3; ++board)
        for (const char corner : {'a', 'b', 'c', 'd'})
            text += fmt::format(
                "hook, {}:{}, {:.3f} mm\n",
                board,
                corner,
                1e3 * (nominal.positions.col(marks.corner(board, corner)) - hook).norm());
    // "12.3 mm" is two words.
    EXPECT_THROW(readBoardMeasurements(text, "tape", nominal), base::InputError);
    std::string joined = text;
    for (std::size_t at = 0; (at = joined.find(" mm", at)) != std::string::npos;)
        joined.replace(at, 3, "mm");
    joined += corners(0, 1, nominal) + corners(0, 2, nominal) + corners(1, 2, nominal);
    const BoardFitReport report =
        fitBoards(nominal, readBoardMeasurements(joined, "tape", nominal), {});
    ASSERT_TRUE(report.usable) << all(report.problems);
    ASSERT_EQ(report.places.size(), 1U);
    EXPECT_LT((report.places[0].position - hook).norm(), 1e-5);
}

TEST(BoardFit, KnownPlacesMustSayWhereTheWholeIs)
{
    const TransducerArray nominal = threeBoards();
    const std::string text = "place m 0 0 0\n0:a m 0.14\n" + corners(0, 1, nominal);
    EXPECT_THROW(fitBoards(nominal, readBoardMeasurements(text, "tape", nominal), {}),
                 base::InputError);
}

TEST(BoardMeasurements, NamesAndNumbersThatAreWrongAreNamed)
{
    EXPECT_EQ(refusal("0:a 1:b 151.2mm\n\n# all\n2:c 1:17 0.3 # m\nt0 t600 20cm\n"), "");
    EXPECT_EQ(refusal("0:a 1:b 151.2\n"),
              "tape: line 1: 0:a - 1:b is \"151.2\", should be a distance above 0, at most 10 m "
              "(151.2mm), or a time of at most 1 s (683us)");
    EXPECT_EQ(refusal("0:a 3:b 0.1\n"),
              "tape: line 1: \"3:b\" names no board, should begin with 0 to 2");
    EXPECT_EQ(refusal("0:a 1:e 0.1\n"),
              "tape: line 1: \"1:e\" names no transducer of board 1, should end with a, b, c, d or "
              "0 to 255");
    EXPECT_EQ(refusal("\n0:a hook 0.1\n").find("tape: line 2: \"hook\" "), 0U);
    EXPECT_NE(refusal("\n0:a hook 0.1\n").find("t0 to t767"), std::string::npos);
    EXPECT_EQ(refusal("0:a 0:b 0.1\n"),
              "tape: line 1: 0:a - 0:b is on one board, should be from a board to another");
    EXPECT_EQ(refusal("0:a 1:b\n"),
              "tape: line 1: has 2 words, should be two ends and a distance or a time: 0:a 1:b "
              "151.2mm");
    EXPECT_EQ(refusal("place m 0 0 nan\n"),
              "tape: line 1: place m has \"nan\", should be metres within -10 .. 10");
    EXPECT_EQ(refusal("place m 0 0 0\nplace m 0 0 1\n"), "tape: line 2: place m is there twice");
    for (const char* number : {"0", "-1", "1e9", "nan", "1kg", "0us", "2s"})
        EXPECT_NE(refusal(std::string("0:a 1:b ") + number), "") << number;
}

// The corners go round the board as seen along its columns and rows.
TEST(BoardMeasurements, CornersAreWhereTheyShouldBe)
{
    const TransducerArray board = TransducerArray::fromJson(
        R"({"name": "one", "frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10.1,
            "directivity": "point", "boards": [{"position_m": [0, 0, 0], "normal": [0, 0, 1],
            "columnsAlong": [1, 0, 0], "columns": 18, "rows": 14, "pitch_m": 0.01016}]})",
        "one");
    const BoardMarks marks(board);
    EXPECT_EQ(marks.corner(0, 'a'), 0);
    EXPECT_EQ(marks.corner(0, 'b'), 17);
    EXPECT_EQ(marks.corner(0, 'c'), 18 * 14 - 1);
    EXPECT_EQ(marks.corner(0, 'd'), 18 * 13);
    EXPECT_THROW(planBoards(board, {}), base::InputError);
}
