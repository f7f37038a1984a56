// Files and pipes of a thermometer, in the thread that reads them.
#include "engine-bridge/air/AirTemperature.h"
#include "tests/Eventually.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace midair::bridge;

namespace
{

std::string fileOf(const std::string& name)
{
    const std::string path =
        testing::TempDir() + "midair-temperature-" + std::to_string(::getpid()) + "-" + name;
    std::filesystem::remove(path);
    return path;
}

/// Takes news, look by look, until \a isIt holds for one.
TemperatureSource::News until(midair::test::SetClock& clock,
                              TemperatureSource& source,
                              const std::function<bool(const TemperatureSource::News&)>& isIt)
{
    TemperatureSource::News news;
    EXPECT_TRUE(eventually(
        [&]
        {
            clock.pass(TemperatureSource::kLook_s);
            news = source.take();
            return isIt(news);
        }));
    return news;
}

TemperatureSource::News untilReading(midair::test::SetClock& clock, TemperatureSource& source)
{
    return until(clock, source, [](const auto& news) { return news.temperature_C.has_value(); });
}

} // namespace

TEST(TemperatureSource, TheLastLineOfAFileCountsAlsoOnceItIsWrittenAnew)
{
    const std::string path = fileOf("file");
    std::ofstream(path) << "# C\n18.5\n21.25\n\n";
    midair::test::SetClock clock;
    TemperatureSource source(path, clock);
    EXPECT_EQ(untilReading(clock, source).temperature_C, 21.25);
    std::ofstream(path, std::ios::app) << "21.5\n";
    EXPECT_EQ(untilReading(clock, source).temperature_C, 21.5);
    std::ofstream(path) << "22.5\n"; // as long as the line before
    EXPECT_EQ(untilReading(clock, source).temperature_C, 22.5);
    // Without an end of line it may be half a number, and counts once it has stayed.
    std::ofstream(path) << "23.75";
    EXPECT_EQ(untilReading(clock, source).temperature_C, 23.75);
    std::filesystem::remove(path);
    EXPECT_NE(until(clock, source, [](const auto& news) { return news.isClosed; })
                  .problem.find("can't be opened: "),
              std::string::npos);
    std::ofstream(path) << "24\n";
    EXPECT_EQ(untilReading(clock, source).temperature_C, 24.0);
    EXPECT_FALSE(source.take().isClosed);
    std::filesystem::remove(path);
}

TEST(TemperatureSource, APipeIsReadAsItIsWritten)
{
    const std::string path = fileOf("pipe");
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    midair::test::SetClock clock;
    TemperatureSource source(path, clock);
    for (const char* line : {"19.5\n", "20.", "5\n"}) // of three writers, one after the other
    {
        // Opens once somebody reads.
        std::ofstream pipe(path);
        pipe << line << std::flush;
        if (std::string(line) == "20.")
        {
            clock.pass(0.6); // in which a file's would count
            EXPECT_FALSE(source.take().temperature_C);
            continue;
        }
        pipe.close();
        EXPECT_EQ(untilReading(clock, source).temperature_C, line[0] == '1' ? 19.5 : 20.5);
    }
    const std::string noise(1000, '9');
    std::ofstream(path) << noise << "\nwarm\n" << std::flush;
    EXPECT_EQ(until(clock, source, [](const auto& news) { return news.bad == 2; }).problem,
              "\"warm\" is not a reading, should be a number from -40 to 60 C");
    std::filesystem::remove(path);
}

// Never a device, and nothing that is endless.
TEST(TemperatureSource, DevicesAndFoldersAreRefused)
{
    for (const char* path : {"/dev/zero", "/tmp"})
    {
        midair::test::SetClock clock;
        TemperatureSource source(path, clock);
        EXPECT_EQ(until(clock, source, [](const auto& news) { return news.isClosed; }).problem,
                  "is a device or a folder, should be a file or a named pipe")
            << path;
    }
}

// It ends at once, also while nobody writes into its pipe.
TEST(TemperatureSource, EndsAtOnce)
{
    const std::string path = fileOf("idle");
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    const auto begin = std::chrono::steady_clock::now();
    {
        midair::test::SetClock clock;
        TemperatureSource source(path, clock);
        int pipe = -1; // can be opened once somebody reads
        EXPECT_TRUE(eventually(
            [&]
            {
                pipe = ::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
                return pipe >= 0;
            }));
        ::close(pipe);
    }
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(60));
    std::filesystem::remove(path);
}
