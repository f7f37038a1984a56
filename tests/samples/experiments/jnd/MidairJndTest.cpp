// Runs the built program as a user would.

#include "samples/experiments/jnd/TrialFile.h"
#include "tests/samples/Shell.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

using midair::samples::Trial;
using midair::samples::TrialFile;

namespace
{

namespace fs = std::filesystem;

const std::string kProgram = MIDAIR_BIN "/midair-jnd";
/// Somebody who is quick, in few and short trials.
std::string quick(const std::string& more, double minutes = 3.0, const std::string& step = "5")
{
    return " --headless --pictures 0 --participant P01 --simulate --times 2 --reference 0 "
           "--between "
           "0 --rest 0 --minutes " +
           std::to_string(minutes) + " --step " + step + " " + more;
}

/// A folder of its own, gone at its end.
class MidairJnd : public testing::Test
{
public:
    MidairJnd() : folder(testing::TempDir() + "midair-jnd-program-" + std::to_string(::getpid()))
    {
        fs::remove_all(folder);
        fs::create_directories(folder);
    }
    ~MidairJnd() override { fs::remove_all(folder); }

    /// \a before: what stands before the program's name.
    Outcome jnd(const std::string& arguments, const std::string& before = "") const
    {
        return shell("cd " + folder + " && " + before + " " + kProgram + " " + arguments);
    }
    TrialFile results(const std::string& name) const
    {
        return TrialFile::load(folder + "/" + name);
    }

    const std::string folder;
};

bool says(const Outcome& outcome, const std::string& what)
{
    return outcome.output.find(what) != std::string::npos;
}

} // namespace

TEST_F(MidairJnd, LeadsASimulatedParticipantThroughRealFields)
{
    for (const std::string experiment : {"oblique", "shifted"})
    {
        const std::string step = experiment == "oblique" ? "5" : "3";
        const Outcome run = jnd(quick("--line 0.05 --experiment " + experiment, 3.0, step));
        ASSERT_EQ(run.code, 0) << run.output;
        EXPECT_TRUE(says(run, "threshold, fit of all answers")) << run.output;
        const TrialFile file = results("jnd-" + experiment + "-P01.csv");
        EXPECT_TRUE(file.staircase.isFinished());
        EXPECT_GE(file.trials.size(), 8u);
        for (const Trial& trial : file.trials)
        {
            EXPECT_LT(trial.rms, 0.01);
            EXPECT_GT(trial.loudness, 0.1);
            EXPECT_NEAR(trial.level_Pa, 10000.0, 100.0);
            EXPECT_GE(trial.line_s, 0.049);
        }
        EXPECT_TRUE(fs::exists(folder + "/jnd-" + experiment + "-P01.png"));
        // Once more: it is finished, so nothing is played or added.
        const Outcome again = jnd(quick("--line 0.05 --experiment " + experiment, 3.0, step));
        EXPECT_EQ(again.code, 0) << again.output;
        EXPECT_EQ(results("jnd-" + experiment + "-P01.csv").trials.size(), file.trials.size());
    }
}

TEST_F(MidairJnd, LosesNothingWhenItIsKilledAnywhere)
{
    ASSERT_EQ(jnd(quick("--line 0.05 --results whole.csv")).code, 0);
    const TrialFile whole = results("whole.csv");
    std::mt19937 random(18);
    bool isDone = false;
    int kills = 0;
    for (; !isDone && kills < 200; ++kills)
    {
        // On a slow machine it has to live longer to get anywhere.
        const double after_s =
            0.3 + std::uniform_real_distribution<double>(0.0, 0.8 + 0.1 * kills)(random);
        const Outcome run = jnd(quick("--line 0.05 --results killed.csv"),
                                "timeout -s KILL " + std::to_string(after_s));
        isDone = run.code == 0;
    }
    if (!isDone)
    {
        ASSERT_EQ(jnd(quick("--line 0.05 --results killed.csv")).code, 0);
    }
    EXPECT_GE(kills, 2) << "it wasn't killed";
    const TrialFile killed = results("killed.csv");
    ASSERT_EQ(killed.trials.size(), whole.trials.size());
    for (std::size_t k = 0; k < whole.trials.size(); ++k)
    {
        EXPECT_DOUBLE_EQ(killed.trials[k].value, whole.trials[k].value);
        EXPECT_EQ(killed.trials[k].isFelt, whole.trials[k].isFelt);
        EXPECT_EQ(killed.trials[k].run, whole.trials[k].run);
        EXPECT_LT(std::abs(killed.trials[k].level_Pa / whole.trials[k].level_Pa - 1.0), 0.01);
    }
    EXPECT_DOUBLE_EQ(thresholdOf(killed.staircase.turns()).value,
                     thresholdOf(whole.staircase.turns()).value);
}

TEST_F(MidairJnd, CountsNothingThatWasNotPlayed)
{
    const Outcome muted = jnd(quick("--line 0.05 --muted", 0.03));
    EXPECT_TRUE(says(muted, "waiting: the array is muted")) << muted.output;
    EXPECT_TRUE(results("jnd-oblique-P01.csv").trials.empty());

    const Outcome faulty =
        jnd(quick("--line 0.05 --results faulty.csv --device 'sim:?drop=1'", 0.12));
    EXPECT_TRUE(says(faulty, "trial 1 doesn't count")) << faulty.output;
    EXPECT_TRUE(results("faulty.csv").trials.empty());
    EXPECT_FALSE(results("faulty.csv").voided.empty());

    const Outcome weak = jnd(quick("--line 0.05 --results weak.csv --pressure 60000", 0.12));
    EXPECT_TRUE(says(weak, "of its 60000 Pa at a point")) << weak.output;
    EXPECT_TRUE(results("weak.csv").trials.empty());
}

TEST_F(MidairJnd, PlaysATrialAgainThatWasMutedInTheMiddle)
{
    const Outcome run =
        shell("( cd " + folder + "; " + kProgram +
              quick("--line 2 --lapse 0 --results muted.csv", 3.0, "15") +
              " & p=$!; for i in $(seq 300); do grep -q '^1,1' muted.csv 2>/dev/null && break; "
              "sleep 0.1; done; sleep 0.4; kill -USR1 $p; sleep 3; kill -USR2 $p; wait $p )");
    EXPECT_EQ(run.code, 0) << run.output;
    EXPECT_TRUE(says(run, "doesn't count and is repeated: the array is muted")) << run.output;
    const TrialFile file = results("muted.csv");
    const auto isMuted = [](const std::string& why)
    { return why.find("doesn't count: the array is muted") != std::string::npos; };
    // Besides, a machine that is busy for a second breaks lines off.
    EXPECT_EQ(std::count_if(file.voided.begin(), file.voided.end(), isMuted), 1);
    EXPECT_TRUE(file.staircase.isFinished());
}

TEST_F(MidairJnd, RefusesOtherSessionsAndNames)
{
    ASSERT_EQ(jnd(quick("--line 0.05 --results one.csv")).code, 0);
    const Outcome other = jnd("--headless --participant P02 --simulate --results one.csv --step 5 "
                              "--times 2 --reference 0 --between 0 --rest 0 --line 0.05");
    EXPECT_NE(other.code, 0);
    EXPECT_TRUE(says(other, "participant is \"P01\" and \"P02\"")) << other.output;
    const Outcome name = jnd("--headless --participant Anna --simulate");
    EXPECT_NE(name.code, 0);
    EXPECT_TRUE(says(name, "names aren't stored")) << name.output;
    const Outcome step = jnd("--headless --participant P03 --simulate --step 4");
    EXPECT_NE(step.code, 0);
    EXPECT_TRUE(says(step, "a whole part of its maximum")) << step.output;
    EXPECT_FALSE(fs::exists(folder + "/jnd-oblique-P03.csv"));
}

TEST_F(MidairJnd, RehearsesAndPlotsWithoutAnArray)
{
    const Outcome rehearsed = jnd("rehearse --sessions 50");
    EXPECT_EQ(rehearsed.code, 0) << rehearsed.output;
    EXPECT_TRUE(says(rehearsed, "Oblique line: 50 simulated sessions a row")) << rehearsed.output;
    EXPECT_TRUE(says(rehearsed, "Shifted line: 50")) << rehearsed.output;
    ASSERT_EQ(jnd(quick("--line 0.05")).code, 0);
    std::string text;
    {
        std::ifstream in(folder + "/jnd-oblique-P01.csv");
        text.assign(std::istreambuf_iterator<char>(in), {});
    }
    text.replace(text.find("P01"), 3, "P02");
    std::ofstream(folder + "/jnd-oblique-P02.csv") << text;
    const Outcome plotted = jnd("plot jnd-oblique-P01.csv jnd-oblique-P02.csv --out group.png");
    EXPECT_EQ(plotted.code, 0) << plotted.output;
    EXPECT_TRUE(says(plotted, "mean of 2 participants")) << plotted.output;
    EXPECT_TRUE(fs::exists(folder + "/group.png"));
    text.replace(text.find("P02"), 3, "P03");
    const std::size_t line = text.find("\"line_s\":");
    ASSERT_NE(line, std::string::npos) << text;
    text.replace(line, text.find(',', line) - line, "\"line_s\":2.0");
    std::ofstream(folder + "/other.csv") << text;
    const Outcome mixed = jnd("plot jnd-oblique-P01.csv other.csv --out mixed.png");
    EXPECT_NE(mixed.code, 0);
    EXPECT_TRUE(says(mixed, "can't be averaged with \"jnd-oblique-P01.csv\": line_s is "))
        << mixed.output;
    const Outcome twice = jnd("plot jnd-oblique-P01.csv jnd-oblique-P01.csv");
    EXPECT_EQ(twice.code, 2);
    EXPECT_TRUE(says(twice, "participant P01")) << twice.output;
}
