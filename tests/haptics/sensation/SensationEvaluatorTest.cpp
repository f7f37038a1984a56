// Each step of an evaluation against its closed form, and whole patterns against expected samples:
// stored ones from closed forms, and those of others where ../shared is beside the tree.
#include "haptics/sensation/SensationEvaluator.h"

#include "haptics/base/Units.h"
#include "haptics/base/text/Words.h"
#include "tests/haptics/sensation/Patterns.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace midair::haptics;
using namespace patterns;

namespace
{

using Row = std::vector<std::string>;

std::vector<Row> rowsOf(const std::filesystem::path& path)
{
    std::ifstream in(path);
    std::vector<Row> rows;
    for (std::string line; std::getline(in, line);)
        rows.push_back(midair::base::splitAt(midair::base::trimmed(line), ','));
    return rows;
}

double at(const Row& row, const Row& header, const std::string& name)
{
    for (std::size_t k = 0; k < header.size(); ++k)
        if (header[k] == name) return std::stod(row.at(k));
    return std::numeric_limits<double>::quiet_NaN();
}

/// Compares a pattern with the samples beside it: 1e-6 mm, 1e-9 of the intensity, the same stop.
void expectSamples(const std::filesystem::path& file)
{
    SCOPED_TRACE(file);
    const auto sensation = std::make_shared<const Sensation>(loadSensation(file.string()));
    const SensationEvaluator evaluator(sensation);
    SensationValues values(*sensation);
    SensationState state;
    std::filesystem::path beside = file;
    const std::vector<Row> rows = rowsOf(beside.replace_extension(".csv"));
    const std::vector<Row> set = rowsOf(beside.replace_extension(".params.csv"));
    ASSERT_GT(rows.size(), 50U);
    const Row& header = rows.front();
    const bool isRandom = header.size() > 7;
    std::size_t next = 1;
    for (std::size_t k = 1; k < rows.size(); ++k)
    {
        const double time_ms = at(rows[k], header, "t_ms");
        for (; next < set.size() && std::stod(set[next][0]) <= time_ms; ++next)
            EXPECT_TRUE(values.set(set[next][1], std::stod(set[next][2]))) << set[next][1];
        const SensationSample sample = evaluator.evaluate(time_ms, values, state);
        ASSERT_NEAR(sample.position_mm.x(), at(rows[k], header, "x_mm"), 1e-6) << time_ms;
        ASSERT_NEAR(sample.position_mm.y(), at(rows[k], header, "y_mm"), 1e-6) << time_ms;
        ASSERT_NEAR(sample.position_mm.z(), at(rows[k], header, "z_mm"), 1e-6) << time_ms;
        ASSERT_NEAR(sample.patternTime_ms, at(rows[k], header, "pattern_time_ms"), 1e-6);
        ASSERT_EQ(sample.isStopped, at(rows[k], header, "stop") == 1.0) << time_ms;
        const double low = at(rows[k], header, isRandom ? "intensity_lo" : "intensity");
        const double high = at(rows[k], header, isRandom ? "intensity_hi" : "intensity");
        ASSERT_GE(sample.intensity, low - 1e-9) << time_ms;
        ASSERT_LE(sample.intensity, high + 1e-9) << time_ms;
    }
}

int expectSamplesIn(const std::filesystem::path& folder)
{
    int patterns = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
    {
        std::filesystem::path beside = entry.path();
        if (beside.extension() != ".adaptics" ||
            !std::filesystem::exists(beside.replace_extension(".csv")))
            continue;
        expectSamples(entry.path());
        ++patterns;
    }
    return patterns;
}

/// Evaluates a pattern at ascending times.
class Evaluation
{
public:
    explicit Evaluation(const Json& pattern) : values(*read(pattern)), _evaluator(read(pattern)) {}

    SensationSample operator()(double time_ms)
    {
        return _evaluator.evaluate(time_ms, values, _state);
    }

    SensationValues values;

private:
    SensationEvaluator _evaluator;
    SensationState _state;
};

/// From 0 to 100 mm in 100 ms: x is the time in the pattern.
Json ruler()
{
    return pattern({standard(0.0, coords(0, 0, 0)), standard(100.0, coords(100, 0, 0))});
}

} // namespace

TEST(SensationEvaluator, MeetsTheStoredSamples)
{
    EXPECT_EQ(expectSamplesIn(MIDAIR_TEST_DATA "/sensations"), 2);
}

TEST(SensationEvaluator, MeetsTheSharedSamples)
{
    const std::filesystem::path folder = MIDAIR_ROOT "/../shared/cases/sensations";
    if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no ../shared/cases/sensations";
    EXPECT_GE(expectSamplesIn(folder), 4);
}

TEST(SensationEvaluator, LimitsDefinedParametersAndPassesOthersOn) // step 1
{
    Json json = pattern({standard(0.0, coords(0, 0, 0))});
    Json& frame = json["keyframes"][0];
    frame["brush"] = circle(parameter("undefined"), parameter("low"));
    frame["intensity"] = intensity(parameter("high"));
    define(json, "high", {{"default", 9.0}, {"max", 2.0}});
    define(json, "low", {{"default", -5.0}, {"min", 3.0}});
    Evaluation evaluate(json);
    EXPECT_EQ(evaluate(0.0).intensity, 2.0);
    EXPECT_EQ(evaluate(1.0).brush.draw_Hz, 3.0);
    EXPECT_EQ(evaluate(2.0).brush.x_mm, 0.0); // neither defined nor set
    EXPECT_TRUE(evaluate.values.set("undefined", 1e4));
    EXPECT_TRUE(evaluate.values.set("high", -1.0));
    EXPECT_FALSE(evaluate.values.set("unused", 1.0));
    EXPECT_FALSE(evaluate.values.set("high", std::nan("")));
    EXPECT_EQ(evaluate(3.0).brush.x_mm, 1e4);
    EXPECT_EQ(evaluate(4.0).intensity, -1.0);
}

TEST(SensationEvaluator, ChangesSpeedWithoutAJump) // step 2
{
    Json json = ruler();
    json["pattern_transform"]["playback_speed"] = parameter("speed");
    define(json, "speed", {{"default", 2.0}});
    Evaluation evaluate(json);
    EXPECT_DOUBLE_EQ(evaluate(10.0).position_mm.x(), 20.0);
    evaluate.values.set("speed", 0.5);
    EXPECT_DOUBLE_EQ(evaluate(10.0).position_mm.x(), 20.0);
    EXPECT_DOUBLE_EQ(evaluate(20.0).position_mm.x(), 25.0);
    evaluate.values.set("speed", -1.0);
    EXPECT_DOUBLE_EQ(evaluate(25.0).patternTime_ms, 20.0);
}

TEST(SensationEvaluator, TakesTheFirstJumpThatHoldsOneAnEvaluation) // step 3
{
    Json json = ruler();
    json["keyframes"].push_back(pause(30.0));
    json["keyframes"][2]["cjumps"] = Json::array({jump("unknown", "lt", 1.0, 90.0),
                                                  jump("p", "gt", 0.0, 5.0),
                                                  jump("p", "gt_eq", 0.0, 10.0),
                                                  jump("p", "lt_eq", 0.0, 70.0)});
    define(json, "p", {{"default", 0.0}});
    Evaluation evaluate(json);
    EXPECT_EQ(evaluate(29.0).patternTime_ms, 29.0);
    EXPECT_EQ(evaluate(33.0).patternTime_ms, 10.0); // what was overshot is lost
    EXPECT_EQ(evaluate(53.0).patternTime_ms, 10.0); // met again at 30
    EXPECT_EQ(evaluate(54.0).patternTime_ms, 11.0);
    evaluate.values.set("p", 1.0);
    EXPECT_EQ(evaluate(1000.0).patternTime_ms, 5.0);
    evaluate.values.set("p", -1.0);
    EXPECT_EQ(evaluate(1025.0).patternTime_ms, 70.0);
    // A keyframe at the place of a jump isn't looked at.
    Json same = ruler();
    same["keyframes"][1]["cjumps"] = Json::array({jump("p", "lt", 1.0, 100.0)});
    define(same, "p", {{"default", 0.0}});
    Evaluation stays(same);
    EXPECT_EQ(stays(100.0).patternTime_ms, 100.0);
    EXPECT_EQ(stays(101.0).patternTime_ms, 101.0);
}

TEST(SensationEvaluator, PausesAndStopsMoveTimes) // step 4
{
    Json json = ruler();
    json["keyframes"].push_back(pause(40.0));
    json["keyframes"].push_back(pause(80.0));
    json["keyframes"][0]["intensity"] = intensity(number(0.2));
    Evaluation evaluate(json);
    EXPECT_DOUBLE_EQ(evaluate(30.0).position_mm.x(), 0.0);  // the next keyframe is a pause
    EXPECT_DOUBLE_EQ(evaluate(90.0).position_mm.x(), 50.0); // from 80, not from 0
    // Before a stop brush and intensity go towards the values behind it, and reach them there.
    Json stopped = ruler();
    stopped["keyframes"][0]["intensity"] = intensity(number(0.2));
    stopped["keyframes"][1]["intensity"] = intensity(number(1.0));
    stopped["keyframes"].push_back(stop(50.0));
    Evaluation evaluateStopped(stopped);
    EXPECT_DOUBLE_EQ(evaluateStopped(25.0).intensity, 0.6);
    EXPECT_FALSE(evaluateStopped(49.0).isStopped);
    const SensationSample at50 = evaluateStopped(50.0);
    EXPECT_TRUE(at50.isStopped);
    EXPECT_DOUBLE_EQ(at50.intensity, 0.2);                         // from the stop on, towards 1
    EXPECT_DOUBLE_EQ(evaluateStopped(75.0).position_mm.x(), 50.0); // the same
    EXPECT_DOUBLE_EQ(evaluateStopped(75.0).intensity, 0.6);
}

TEST(SensationEvaluator, MixesLinearlyOrInSteps) // step 5
{
    Json json = pattern({standard(10.0, coords(1, 2, 3, "step")), standard(20.0, coords(5, 6, 7))});
    json["keyframes"][0]["intensity"] = intensity(number(1.0), "step");
    json["keyframes"][1]["intensity"] = intensity(number(0.0));
    Evaluation evaluate(json);
    const SensationSample before = evaluate(5.0);
    EXPECT_EQ(before.position_mm, Eigen::Vector3d::Zero());
    EXPECT_EQ(before.intensity, 0.0);
    EXPECT_EQ(before.brush.x_mm, 0.0);
    EXPECT_EQ(evaluate(19.0).position_mm, Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(evaluate(19.5).intensity, 1.0);
    EXPECT_EQ(evaluate(20.0).position_mm, Eigen::Vector3d(5, 6, 7));
    EXPECT_EQ(evaluate(1e6).intensity, 0.0); // the last keyframe holds
}

TEST(SensationEvaluator, DrawsRandomIntensitiesForEachSample) // step 6
{
    Json json = pattern({standard(0.0, coords(0, 0, 0))});
    json["keyframes"][0]["intensity"] = intensity(number(0.0));
    json["keyframes"][0]["intensity"]["intensity"] =
        variant("random", {{"min", number(0.25)}, {"max", number(0.75)}});
    Evaluation evaluate(json);
    double sum = 0.0, square = 0.0;
    constexpr int kDraws = 20000;
    for (int k = 0; k < kDraws; ++k)
    {
        const double value = evaluate(k).intensity;
        ASSERT_GE(value, 0.25);
        ASSERT_LT(value, 0.75);
        sum += value - 0.5;
        square += (value - 0.5) * (value - 0.5);
    }
    EXPECT_NEAR(sum / kDraws, 0.0, 0.004);             // 4 sigma: 4 x 0.144/sqrt(20000)
    EXPECT_NEAR(square / kDraws, 0.25 / 12.0, 0.0008); // of a uniform one
}

TEST(SensationEvaluator, KeepsTheShapeOfTheBrushBeforeAndMixesItsSize) // step 7
{
    Json json = pattern({standard(0.0, coords(0, 0, 0)), standard(10.0, coords(0, 0, 0))});
    json["keyframes"][0]["brush"] = circle(number(10.0), number(20.0), number(8.0));
    json["keyframes"][1]["brush"] = circle(number(30.0), number(500.0), number(16.0));
    Evaluation evaluate(json);
    const DrawnBrush brush = evaluate(5.0).brush;
    EXPECT_DOUBLE_EQ(brush.x_mm, 20.0);
    EXPECT_DOUBLE_EQ(brush.modulation_Hz, 12.0);
    EXPECT_DOUBLE_EQ(brush.draw_Hz, 20.0);
    json["keyframes"][1]["brush"]["brush"] = variant("line",
                                                     {{"length", number(30.0)},
                                                      {"thickness", number(1.0)},
                                                      {"rotation", number(0.0)},
                                                      {"am_freq", number(0.0)}});
    Evaluation other(json);
    EXPECT_DOUBLE_EQ(other(5.0).brush.x_mm, 10.0); // of another kind
    const DrawnBrush line = other(10.0).brush;
    EXPECT_DOUBLE_EQ(line.draw_Hz, 100.0); // where the file has none
    EXPECT_NEAR(line.at(0.0).x(), 30.0, 1e-12);
    EXPECT_NEAR(line.at(midair::base::kPi).x(), -30.0, 1e-12); // it spans +- its length
}

TEST(SensationEvaluator, DrawsByTimeNotByTimeInThePattern) // step 7
{
    Json json = pattern({standard(0.0, coords(0, 0, 0))});
    json["keyframes"][0]["brush"] = circle(number(10.0), number(25.0), number(50.0));
    json["keyframes"][0]["intensity"] = intensity(number(1.0));
    json["pattern_transform"]["playback_speed"] = number(0.0);
    Evaluation evaluate(json);
    const SensationSample sample = evaluate(10.0); // a quarter of a turn, half a period
    EXPECT_EQ(sample.patternTime_ms, 0.0);
    EXPECT_NEAR(sample.position_mm.y(), 10.0, 1e-12);
    EXPECT_NEAR(sample.intensity, 0.0, 1e-12);
}

TEST(SensationEvaluator, MultipliesIntensitiesWithoutALimit) // step 8
{
    Json json = pattern({standard(0.0, coords(0, 0, 0))});
    json["keyframes"][0]["intensity"] = intensity(number(2.0));
    json["pattern_transform"]["intensity_factor"] = number(1.5);
    Evaluation evaluate(json);
    EXPECT_DOUBLE_EQ(evaluate(0.0).intensity, 3.0);
    EXPECT_TRUE(evaluate(1.0).isLimited);
}

TEST(SensationEvaluator, TransformsThePathButNotTheBrush) // step 9
{
    Json json = pattern({standard(0.0, coords(10, 0, 1))});
    json["keyframes"][0]["brush"] = circle(number(3.0), number(0.0));
    Json& transform = json["pattern_transform"]["geometric_transforms"];
    transform["scale"]["x"] = number(2.0);
    transform["rotation"] = number(90.0);
    transform["translate"]["z"] = number(200.0);
    const auto sensation = read(json);
    const SensationEvaluator evaluator(sensation);
    SensationState state;
    Eigen::Matrix4d frame = Eigen::Matrix4d::Identity();
    frame(0, 3) = 7.0;
    frame(3, 3) = 2.0;
    const SensationSample sample =
        evaluator.evaluate(0.0, SensationValues(*sensation), state, frame);
    EXPECT_NEAR(sample.position_mm.x(), 7.0 / 2.0 + 3.0, 1e-12);
    EXPECT_NEAR(sample.position_mm.y(), 20.0 / 2.0, 1e-12);
    EXPECT_NEAR(sample.position_mm.z(), 201.0 / 2.0, 1e-12);
}

TEST(SensationEvaluator, StopsFromAStopToTheNextKeyframe) // step 10
{
    Evaluation evaluate(
        pattern({standard(0.0, coords(0, 0, 0)), stop(10.0), standard(20.0, coords(0, 0, 0))}));
    EXPECT_FALSE(evaluate(9.0).isStopped);
    EXPECT_TRUE(evaluate(10.0).isStopped);
    EXPECT_TRUE(evaluate(19.0).isStopped);
    EXPECT_FALSE(evaluate(20.0).isStopped);
}

TEST(SensationEvaluator, PassesNaNAndInfinityOn)
{
    Json json = pattern({standard(0.0, coords(0, 0, 0))});
    const Json zero = {{"type", "constant"}, {"value", 0.0}};
    const Json one = {{"type", "constant"}, {"value", 1.0}};
    json["keyframes"][0]["intensity"] =
        intensity({{"type", "formula"},
                   {"value", {{"type", "divide"}, {"value", Json::array({one, zero})}}}});
    Evaluation evaluate(json);
    const SensationSample sample = evaluate(0.0);
    EXPECT_FALSE(sample.isFinite);
    EXPECT_TRUE(std::isinf(sample.intensity));
}
