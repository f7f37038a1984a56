#include "samples/experiments/jnd/TrialRunner.h"

#include <gtest/gtest.h>

using midair::samples::PlayedNow;
using midair::samples::TrialRunner;
using midair::samples::TrialTimes;
using Phase = TrialRunner::Phase;

namespace
{

const PlayedNow kPlayed{true, true, {}};
const PlayedNow kSilent{false, true, "there is no such field"};
const PlayedNow kMuted{false, false, "the array is muted"};

/// Reference 1 s, silence 0.5 s, line 2 s, rest 1 s.
class TrialRuns : public testing::Test
{
public:
    TrialRunner runner{TrialTimes{1.0, 0.5, 2.0, 1.0}};
    TrialRuns() { runner.ask(20.0); }

    /// Begins, and goes on to the line, which has just begun at 2 s.
    void goToLine()
    {
        runner.begin(0.0);
        for (const double now_s : {0.1, 0.6, 1.2})
            EXPECT_TRUE(runner.step(now_s, kPlayed).voided.empty());
        runner.step(1.8, kSilent);
        ASSERT_EQ(runner.phase(), Phase::LINE);
        runner.step(2.0, kPlayed);
    }
};

} // namespace

TEST_F(TrialRuns, PlayReferenceSilenceLineSilence)
{
    EXPECT_FALSE(runner.wanted());
    runner.begin(0.0);
    EXPECT_EQ(runner.wanted(), 0.0);
    runner.step(0.3, kSilent); // solving takes its time, which doesn't count
    runner.step(0.4, kPlayed);
    runner.step(1.3, kPlayed);
    EXPECT_EQ(runner.wanted(), 0.0);
    runner.step(1.5, kPlayed);
    EXPECT_FALSE(runner.wanted());
    runner.step(2.1, kSilent);
    EXPECT_EQ(runner.wanted(), 20.0);
    runner.step(2.2, kPlayed);
    EXPECT_TRUE(runner.answer(true));
    const TrialRunner::Step step = runner.step(3.2, kPlayed);
    ASSERT_TRUE(step.counted);
    EXPECT_TRUE(*step.counted);
    EXPECT_NEAR(step.answer_s, 1.0, 1e-9);
    EXPECT_NEAR(step.line_s, 1.0, 1e-9);
    EXPECT_FALSE(runner.wanted());
    runner.ask(17.5);
    runner.step(3.9, kSilent);
    EXPECT_EQ(runner.phase(), Phase::RESTING);
    runner.step(4.3, kSilent);
    EXPECT_EQ(runner.phase(), Phase::REFERENCE);
    EXPECT_DOUBLE_EQ(runner.value(), 17.5);
}

TEST_F(TrialRuns, LimitTheTimeOfTheLine)
{
    goToLine();
    runner.step(3.9, kPlayed);
    EXPECT_EQ(runner.wanted(), 20.0);
    EXPECT_FALSE(runner.step(4.1, kPlayed).counted);
    EXPECT_FALSE(runner.wanted());
    EXPECT_EQ(runner.phase(), Phase::ANSWER);
    runner.step(60.0, kSilent); // it may be thought about
    EXPECT_TRUE(runner.answer(false));
    const TrialRunner::Step step = runner.step(61.0, kSilent);
    ASSERT_TRUE(step.counted);
    EXPECT_FALSE(*step.counted);
    EXPECT_NEAR(step.line_s, 2.1, 1e-9);
    EXPECT_NEAR(step.answer_s, 59.0, 1e-9);
}

TEST_F(TrialRuns, TakeNoAnswerBeforeTheLineIsFelt)
{
    EXPECT_FALSE(runner.answer(true));
    runner.begin(0.0);
    runner.step(0.1, kPlayed);
    EXPECT_FALSE(runner.answer(true));
    runner.step(1.2, kPlayed);
    EXPECT_FALSE(runner.answer(true));
    runner.step(1.8, kSilent);
    EXPECT_FALSE(runner.answer(true)); // wanted, not played yet
    runner.step(1.9, kPlayed);
    EXPECT_TRUE(runner.answer(true));
    EXPECT_TRUE(runner.answer(false)); // the first one counts
    EXPECT_EQ(runner.step(2.0, kPlayed).counted, true);
    EXPECT_FALSE(runner.answer(true));
}

TEST_F(TrialRuns, DoNotCountWhatWasMuted)
{
    goToLine();
    runner.answer(true);
    const TrialRunner::Step step = runner.step(2.5, kMuted);
    EXPECT_FALSE(step.counted);
    EXPECT_EQ(step.voided, "the array is muted");
    EXPECT_FALSE(runner.wanted());
    for (double now_s = 3.0; now_s < 30.0; now_s += 1.0)
        EXPECT_TRUE(runner.step(now_s, kMuted).voided.empty()) << "told once";
    EXPECT_EQ(runner.phase(), Phase::STOPPED);
    runner.step(31.0, kSilent);
    EXPECT_EQ(runner.phase(), Phase::REFERENCE);
    EXPECT_DOUBLE_EQ(runner.value(), 20.0) << "the same once more";
    EXPECT_FALSE(runner.step(31.1, kPlayed).counted) << "the answer of before is forgotten";
}

TEST_F(TrialRuns, DoNotCountWhatBrokeOffOrWasNeverPlayed)
{
    goToLine();
    EXPECT_EQ(runner.step(2.5, kSilent).voided, "the line was interrupted: there is no such field");
    runner.begin(10.0);
    EXPECT_TRUE(runner.step(14.9, kSilent).voided.empty());
    EXPECT_EQ(runner.step(15.1, kSilent).voided,
              "the line wasn't played within 5 s: there is no such field");
}

TEST_F(TrialRuns, DoNotCountWhatIsMutedBetweenTheLines)
{
    runner.begin(0.0);
    runner.step(0.1, kPlayed);
    runner.step(1.2, kPlayed);
    EXPECT_EQ(runner.step(1.3, kMuted).voided, "the array is muted");
}

TEST(TrialRunner, NeedsNoReference)
{
    TrialRunner runner(TrialTimes{0.0, 0.5, 2.0, 1.0});
    runner.ask(20.0);
    runner.begin(0.0);
    EXPECT_EQ(runner.wanted(), 20.0);
}
