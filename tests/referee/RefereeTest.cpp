#include "tests/LongTests.h"
#include "tests/referee/Verdict.h"

#include <algorithm>
#include <filesystem>
#include <ostream>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace midair;
using namespace midair::referee;

namespace midair::referee
{

/// For names of tests; GoogleTest calls it so.
static void PrintTo(const Scene& scene, std::ostream* out) // NOLINT(readability-identifier-naming)
{
    *out << scene.name;
}

} // namespace midair::referee

namespace
{

Recorded recordOf(const Scene& scene, int updates)
{
    const std::string file =
        ::testing::TempDir() + "midair_referee_" + std::to_string(::getpid()) + ".midair";
    Recorded recorded = record(scene, updates, file);
    std::filesystem::remove(file);
    return recorded;
}

Scene sceneNamed(const std::string& name)
{
    for (const Scene& scene : allScenes())
        if (scene.name == name) return scene;
    throw std::runtime_error("no scene " + name);
}

/// The figures that are off, with the largest difference of each.
std::string complaints(const Verdict& verdict)
{
    std::string all;
    for (const auto& [name, worst] : verdict.figures)
        if (worst.failures > 0)
            all += name + ": told " + std::to_string(worst.told) + ", recomputed " +
                   std::to_string(worst.truth) + " in update " + std::to_string(worst.update) +
                   "; ";
    for (const std::string& name : verdict.missing)
        all += name + " is recomputed by nobody; ";
    return all;
}

std::set<std::string> figuresThatAreOff(const Verdict& verdict)
{
    std::set<std::string> names;
    for (const auto& [name, worst] : verdict.figures)
        if (worst.failures > 0) names.insert(name);
    return names;
}

class Referee : public ::testing::TestWithParam<Scene>
{
};

} // namespace

TEST_P(Referee, FindsTheReportsTrue)
{
    // All three kinds of steps, the ones that are skipped included.
    const Recorded recorded = recordOf(GetParam(), 24);
    const Verdict verdict = judge(recorded);
    EXPECT_TRUE(verdict.passed()) << complaints(verdict);
    const Scene& scene = GetParam();
    int joined = 0, several = 0;
    for (const Update& update : recorded.updates)
    {
        joined += update.isJoined ? 1 : 0;
        several += update.parts.size() > 1 ? 1 : 0;
    }
    EXPECT_EQ(verdict.updates, 24 + joined);
    EXPECT_EQ(joined > 0, scene.cycle > 1);
    EXPECT_EQ(several > 0, scene.cycle > 1 || scene.subsets > 1);
    EXPECT_EQ(verdict.figures.count("surface.mean_Pa") > 0, scene.isMeasured);
    EXPECT_TRUE(verdict.skipped > 0 || GetParam().swing > 0.0);
    EXPECT_GT(verdict.worstMove_m, 0.0) << "no row of G was kept";
}

TEST_P(Referee, FindsAThousandReportsTrue)
{
    if (!longTestsAsked()) GTEST_SKIP() << "minutes: tests/run.sh --long";
    const Verdict verdict = judge(recordOf(GetParam(), 1000));
    EXPECT_TRUE(verdict.passed()) << complaints(verdict);
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         Referee,
                         ::testing::ValuesIn(allScenes()),
                         [](const auto& scene)
                         {
                             std::string name = scene.param.name;
                             std::replace_if(
                                 name.begin(),
                                 name.end(),
                                 [](unsigned char c) { return std::isalnum(c) == 0; },
                                 '_');
                             return name;
                         });

// Each figure in turn is made 2 % larger, or one more, in one report: that figure, and no other,
// is off.
TEST(RefereeItself, CatchesEveryFigureThatIsFalse)
{
    // Errors far above single precision, and points that fall short.
    std::vector<Recorded> all = {recordOf(sceneNamed("coarse array, 9"), 5),
                                 recordOf(sceneNamed("25, some out of reach"), 3)};
    // What 1 K costs is measured where the surface is.
    std::vector<Recorded> withSurface = {recordOf(sceneNamed("board, surface"), 10)};
    for (const auto& figure : haptics::kFigures)
    {
        if (kNotRecomputed.count(figure.name) > 0) continue;
        SCOPED_TRACE(figure.name);
        bool isCaught = false;
        const bool isOfSurface = std::string(figure.name).rfind("kelvin", 0) == 0;
        const bool isOfRest = std::string(figure.name) == "reflectorRms"; // 0 of what moves
        for (Recorded& recorded : isOfSurface ? withSurface : all)
        {
            haptics::SolveReport& report = recorded.updates.back().report;
            const haptics::SolveReport kept = report;
            const double told =
                std::visit([&](auto value) { return double(report.*value); }, figure.value);
            const bool isCount = std::holds_alternative<int haptics::SolveReport::*>(figure.value);
            // 2 % can't be told there.
            if (!isCount && !isOfRest && told < floorOf(figure.name)) continue;
            if (isOfRest)
                report.reflectorRms += 1.0;
            else if (isCount)
                report.*std::get<int haptics::SolveReport::*>(figure.value) += 1;
            else
                report.*std::get<double haptics::SolveReport::*>(figure.value) *= 1.02;
            const Verdict verdict = judge(recorded);
            EXPECT_FALSE(verdict.passed());
            EXPECT_EQ(figuresThatAreOff(verdict), std::set<std::string>{figure.name});
            report = kept;
            isCaught = true;
        }
        EXPECT_TRUE(isCaught) << "it is too small in all scenes";
    }
}

TEST(RefereeItself, CatchesEveryFigureOfTheSurfaceThatIsFalse)
{
    Recorded recorded = recordOf(sceneNamed("board, surface"), 10);
    haptics::SurfaceStatistics& told = recorded.updates.back().report.surface;
    const haptics::SurfaceStatistics kept = told;
    for (const auto& figure : haptics::kSurfaceFigures)
    {
        SCOPED_TRACE(figure.name);
        if (std::holds_alternative<int haptics::SurfaceStatistics::*>(figure.value))
            told.*std::get<int haptics::SurfaceStatistics::*>(figure.value) += 1;
        else
        {
            double& value = told.*std::get<double haptics::SurfaceStatistics::*>(figure.value);
            value = value > 0.0 ? 1.02 * value : 0.02; // a held field doesn't vibrate
        }
        const std::set<std::string> off = figuresThatAreOff(judge(recorded));
        EXPECT_EQ(off, std::set<std::string>{std::string("surface.") + figure.name});
        told = kept;
    }
    EXPECT_TRUE(judge(recorded).passed()) << complaints(judge(recorded));
}

TEST(RefereeItself, CatchesFieldsInTurnThatAreForOtherPoints)
{
    Recorded recorded = recordOf(sceneNamed("pipeline, 3 subsets"), 3);
    ASSERT_TRUE(judge(recorded).passed()) << complaints(judge(recorded));
    std::vector<Part>& parts = recorded.updates.back().parts;
    ASSERT_EQ(parts.size(), 3u);
    std::swap(parts[0].field, parts[1].field);
    EXPECT_GT(figuresThatAreOff(judge(recorded)).count("rms"), 0u);
    std::swap(parts[0].field, parts[1].field);
    recorded.updates.back().report.levelJump *= 1.02;
    EXPECT_EQ(figuresThatAreOff(judge(recorded)), std::set<std::string>{"levelJump"});
}

TEST(RefereeItself, CatchesWhatWasNotPlayed)
{
    Recorded recorded = recordOf(sceneNamed("coarse array, 9"), 4);
    EXPECT_TRUE(judge(recorded).passed()) << complaints(judge(recorded));
    Recorded other = recorded;
    other.updates.back().parts[0].field = 0; // the field of another update
    EXPECT_FALSE(judge(other).passed());
    other = recorded;
    for (std::size_t i = 0; i < 26; ++i) // a tenth of the transducers, a level of phase each
        other.fields.back().phase[10 * i % 256] += 8;
    EXPECT_FALSE(judge(other).passed());
    other = recorded;
    for (std::uint8_t& duty : other.fields.back().duty)
        duty = static_cast<std::uint8_t>(duty * 9 / 10);
    EXPECT_FALSE(judge(other).passed());
}

TEST(RefereeItself, CatchesAPressureOverTheCap)
{
    Recorded recorded = recordOf(sceneNamed("pipeline, capped"), 2);
    Verdict verdict = judge(recorded);
    EXPECT_TRUE(verdict.passed()) << complaints(verdict);
    EXPECT_GT(verdict.overCap, 0.9);
    recorded.cap_Pa *= 0.9;
    EXPECT_FALSE(judge(recorded).passed());
}

TEST(RefereeItself, CatchesAFigureThatIsNoNumber)
{
    Recorded recorded = recordOf(sceneNamed("coarse array, 9"), 2);
    recorded.updates.back().report.rms = std::nan("");
    EXPECT_EQ(figuresThatAreOff(judge(recorded)), std::set<std::string>{"rms"});
}

TEST(RefereeItself, CatchesRowsThatAreKeptTooLong)
{
    Recorded recorded = recordOf(sceneNamed("coarse array, 9"), 22);
    ASSERT_TRUE(judge(recorded).passed());
    // Steps of 5 nm bring a point to 45 nm from its row before the next step of 1 mm; 86 nm are
    // allowed.
    recorded.updates[19].parts[0].points.positions.row(0).array() += 2e-4;
    EXPECT_FALSE(judge(recorded).passed());
}

// sinc^2 within its first zeros holds 0.9028 of its energy, and all of it in the end.
TEST(RefereeItself, KnowsTheSpectrumOfAHeldChange)
{
    EXPECT_NEAR(audiblePart(20e3), 0.9028 - 2 * 20.0 / 20e3, 1e-4);
    EXPECT_NEAR(audiblePart(1000.0), 0.9549, 1e-3);
    EXPECT_NEAR(audiblePart(20.0), 1.0 - 0.9028, 2e-3);
}
