// A program that is told to stop stops: by itself, or, where its frames hang, silent and by force.
#include "samples/shared/views/Signals.h"
#include "tests/Eventually.h"
#include "tests/samples/Ending.h"

#include <csignal>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace midair::samples;

namespace
{

void say(int to, const char* what)
{
    EXPECT_EQ(::write(to, what, 1), 1);
}

[[noreturn]] void hang()
{
    for (;;)
        ::pause();
}

} // namespace

TEST(StopSignal, EndsWhatHangsWithin2sSilentFirst)
{
    for (const int number : {SIGTERM, SIGINT, SIGHUP})
    {
        const Ending ending = endingOf(
            [](int to)
            {
                catchStopSignals();
                const SilenceAtStop silence([to] { say(to, "s"); });
                say(to, "r");
                hang();
                return 0;
            },
            number);
        EXPECT_EQ(ending.signal, number);
        EXPECT_EQ(ending.said, "s") << number;
        EXPECT_LT(ending.seconds, 2.0 + ending.busy_s) << number;
        EXPECT_GT(ending.seconds, 1.0) << "a slow frame has its time";
    }
}

TEST(StopSignal, EndsWhatHangsWhereItsSilenceHangsToo)
{
    const Ending ending = endingOf(
        [](int to)
        {
            catchStopSignals();
            const SilenceAtStop silence([] { hang(); });
            say(to, "r");
            hang();
            return 0;
        },
        SIGTERM);
    EXPECT_EQ(ending.signal, SIGTERM);
    EXPECT_LT(ending.seconds, 2.0 + ending.busy_s);
}

TEST(StopSignal, LetsAProgramThatHeardOfItEndByItself)
{
    const Ending ending = endingOf(
        [](int to)
        {
            catchStopSignals();
            const SilenceAtStop silence([to] { say(to, "s"); });
            say(to, "r");
            eventually([] { return isStopAsked(); });
            letPass(2.5); // writes its report
            return 7;
        },
        SIGTERM);
    EXPECT_EQ(ending.code, 7);
    EXPECT_EQ(ending.said, "") << "it silences by itself";
}

TEST(StopSignal, TheSecondEndsItAtOnce)
{
    const Ending ending = endingOf(
        [](int to)
        {
            catchStopSignals();
            say(to, "r");
            hang();
            return 0;
        },
        SIGINT,
        SIGINT);
    EXPECT_EQ(ending.signal, SIGINT);
    EXPECT_LT(ending.seconds, 0.9 + ending.busy_s);
}

TEST(StopSignal, AHangupThatIsIgnoredStaysSo)
{
    const Ending ending = endingOf(
        [](int to)
        {
            std::signal(SIGHUP, SIG_IGN); // as nohup does
            catchStopSignals();
            say(to, "r");
            letPass(0.3);
            return isStopAsked() ? 1 : 7;
        },
        SIGHUP);
    EXPECT_EQ(ending.code, 7);
}
