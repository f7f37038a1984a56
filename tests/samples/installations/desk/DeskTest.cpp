#include "tests/samples/installations/Run.h"

#include <csignal>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace
{

/// An AUTD3 unit that another process emulates while this lives.
class EmulatedUnit
{
public:
    EmulatedUnit() :
        _output(::popen(("echo $$; exec '" MIDAIR_BIN "/midair-device' emulate autd3 --units 1 "
                         "--port 0 --seconds 300"),
                        "r"))
    {
        _process = std::stoi(line());
        const std::string said = line();
        const std::size_t at = said.find("autd3:");
        if (at != std::string::npos) uri = said.substr(at);
    }
    ~EmulatedUnit()
    {
        ::kill(_process, SIGTERM);
        ::pclose(_output);
    }
    EmulatedUnit(const EmulatedUnit&) = delete;
    EmulatedUnit& operator=(const EmulatedUnit&) = delete;

    std::string uri; ///< empty: this machine has no ::1

private:
    std::string line()
    {
        std::string text;
        for (int c = 0; (c = std::fgetc(_output)) != EOF && c != '\n';)
            text += static_cast<char>(c);
        return text;
    }

    std::FILE* _output;
    int _process = 0;
};

/// \a visits: of which one has to be without a fault, where a busy machine may make one.
void expectDesk(const std::string& arguments, const char* array, int transducers, int visits = 1)
{
    const OwnFolder out("desk");
    Visit run;
    const auto isWhole = [&run]
    {
        const auto& fields = run.report.at("fields");
        return fields.at("lost") == 0 && fields.at("refused") == 0 && fields.at("faults") == 0;
    };
    do
        run = visit("desk", "--frames 400 " + arguments, out);
    while (--visits > 0 && run.outcome.code == 0 && !isWhole());
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    EXPECT_EQ(run.report.at("array"), array);
    EXPECT_EQ(run.report.at("transducers"), transducers);
    EXPECT_GT(run.report.at("fields").at("played"), 20) << run.outcome.output;
    EXPECT_GT(run.report.at("scene").at("pointsAtMost"), 5);
    EXPECT_GT(run.report.at("scene").at("presses").at("quick"), 0);
    EXPECT_GT(run.report.at("scene").at("presses").at("trembling"), 0);
}

} // namespace

TEST(Desk, TheDeskPlaysOnTheArrayOfItsDevice)
{
    expectDesk("--device sim:?board=sonicsurface", "sonicsurface", 256);
}

TEST(Desk, TheDeskPlaysOnAnAutd3Unit)
{
    const EmulatedUnit unit;
    if (unit.uri.empty()) GTEST_SKIP() << "no ::1";
    // A busy machine may keep units in another process waiting for longer than 100 ms.
    expectDesk("--set earLimit=none --device '" + unit.uri + "&failsafe=5s'", "autd3", 249, 3);
}

TEST(Desk, AMutedDeskIsSilent)
{
    const OwnFolder out("muted");
    const Visit run = visit("desk", "--frames 200 --muted", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    EXPECT_EQ(run.report.at("silence").at("framesMuted"), 200);
    EXPECT_EQ(run.report.at("silence").at("playedMuted"), 0);
    EXPECT_EQ(run.report.at("framesPlaying"), 0);
    EXPECT_EQ(run.report.at("state"), "muted");
}

TEST(Desk, NobodyThereIsSilence)
{
    const OwnFolder out("alone");
    const Visit run = visit("desk", "--frames 520 --linger 0.5", out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    expectQuiet(run.report);
    // The ring of 36 mm has its size when the array is opened, before the first frame.
    for (const auto& message : run.report.at("messages"))
        for (const char* size : {"object.units", "object.large", "object.small"})
            EXPECT_NE(message.at("code"), size) << message;
    EXPECT_GT(run.report.at("framesPlaying"), 100);
    EXPECT_GT(run.report.at("silence").at("framesAlone"), 60);
}

TEST(Desk, SayWhatIsWrong)
{
    const OwnFolder out("wrong");
    const std::vector<std::pair<std::string, std::string>> kWrong = {
        {"--window 10x10", "--window: is \"10x10\", should be WIDTHxHEIGHT in pixels"},
        {"--set loudness", "--set: is \"loudness\", should be NAME=VALUE"},
        {"--set maxPressure=loud", "maxPressure is \"loud\""},
        {"--frames 0", "--frames"},
    };
    for (const auto& [arguments, text] : kWrong)
    {
        const Visit run = visit("desk", arguments, out);
        EXPECT_NE(run.outcome.code, 0) << arguments;
        EXPECT_NE(run.outcome.output.find(text), std::string::npos) << run.outcome.output;
    }
    EXPECT_EQ(visit("desk", "--help", out).outcome.code, 0);
}
