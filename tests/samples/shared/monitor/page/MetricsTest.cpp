// What Prometheus reads, by the rules of its text format, and by its own tool where it is
// installed.
#include "samples/shared/monitor/page/MonitorTexts.h"
#include "tests/samples/shared/monitor/FakeInstallation.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace midair::samples;
using osgMidair::ArrayState;

namespace
{

MonitorState stateOf(const FakeInstallation& installation)
{
    MonitorState state;
    state.name = "midair-demo: \"star\"\\\n";
    state.now_s = 100.0;
    state.view.isRead = true;
    state.view.reading = installation.read();
    state.view.read_s = 99.9;
    state.view.frame_s = 99.8;
    state.view.messages["device.lost"] = {osgMidair::HapticMessage::FAULT, 2, 5};
    state.picture.sum_ms = 1500.0;
    state.answers = {{200, 7}, {401, 1}};
    return state;
}

/// Reads the text format strictly; sample by name and labels.
std::map<std::string, double> parsed(const std::string& text)
{
    static const std::regex comment(R"(# (HELP|TYPE) ([a-z][a-z0-9_]*) (.+))");
    static const std::regex sample(
        R"re(([a-z][a-z0-9_]*)(\{([a-z_]+="([^"\\\n]|\\[\\"n])*",?)+\})? (NaN|[+-]Inf|-?[0-9.]+(e[+-]?[0-9]+)?))re");
    std::map<std::string, double> samples;
    std::map<std::string, std::string> types;
    std::set<std::string> helped;
    std::string current;
    EXPECT_EQ(text.back(), '\n');
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
    {
        std::smatch match;
        if (std::regex_match(line, match, comment))
        {
            if (match[1] == "HELP")
                EXPECT_TRUE(helped.insert(match[2]).second) << line;
            else
            {
                EXPECT_EQ(helped.count(match[2]), 1U) << line;
                EXPECT_TRUE(match[3] == "gauge" || match[3] == "counter") << line;
                EXPECT_TRUE(types.emplace(match[2], match[3]).second) << line;
            }
            current = match[2];
            continue;
        }
        EXPECT_TRUE(std::regex_match(line, match, sample)) << line;
        const std::string name = match[1];
        EXPECT_EQ(name, current) << "samples stand together, below their comments: " << line;
        const bool isTotal = name.size() > 6 && name.substr(name.size() - 6) == "_total";
        EXPECT_EQ(isTotal, types[name] == "counter") << line;
        EXPECT_TRUE(
            samples.emplace(name + match[2].str(), std::strtod(match[5].str().c_str(), nullptr))
                .second)
            << line;
    }
    EXPECT_EQ(helped.size(), types.size());
    return samples;
}

} // namespace

TEST(MonitorMetrics, KeepToTheTextFormatAndSayWhatIs)
{
    const FakeInstallation installation;
    std::map<std::string, double> samples = parsed(metricsText(stateOf(installation)));
    EXPECT_EQ(samples.at("midair_up"), 1.0);
    EXPECT_EQ(samples.at("midair_array_state{state=\"playing\"}"), 1.0);
    EXPECT_EQ(samples.at("midair_array_state{state=\"muted\"}"), 0.0);
    EXPECT_EQ(samples.at("midair_fields_sent_total"), 7.0);
    EXPECT_EQ(samples.at("midair_field_rms"), 0.0125);
    EXPECT_EQ(samples.at("midair_field_solve_seconds"), 0.002);
    EXPECT_EQ(samples.at("midair_field_mean_phase_step_radians"), 0.5);
    EXPECT_EQ(samples.at("midair_exposure_level_decibels"), 117.5);
    EXPECT_EQ(samples.at("midair_messages_total{code=\"device.lost\",severity=\"fault\"}"), 5.0);
    EXPECT_EQ(samples.at("midair_page_answers_total{code=\"401\"}"), 1.0);
    EXPECT_EQ(samples.at("midair_page_picture_readback_seconds_total"), 1.5);
    EXPECT_EQ(samples.count("midair_array_info{name=\"midair-demo: \\\"star\\\"\\\\\\n\","
                            "array=\"octagon\",device=\"sim: 3984 transducers\"}"),
              1U);
    EXPECT_NEAR(samples.at("midair_frame_age_seconds"), 0.2, 1e-9);
}

// A series would begin anew with each of them.
TEST(MonitorMetrics, NameTheDeviceWithoutItsCountersAndErrors)
{
    FakeInstallation installation;
    const auto deviceOf = [&](const std::string& status, ArrayState state)
    {
        installation.change(
            [&](MonitorReading& reading)
            {
                reading.statistics.device = status;
                reading.statistics.state = state;
            });
        const std::string text = metricsText(stateOf(installation));
        const std::size_t begin = text.find("device=\"") + 8;
        return text.substr(begin, text.find('"', begin) - begin);
    };
    EXPECT_EQ(deviceOf("usb:7: firmware 3, 80 transducers", ArrayState::PLAYING),
              "usb:7: firmware 3");
    EXPECT_EQ(deviceOf("usb:7: not there; 12 sent, 3 lost", ArrayState::LOST), "usb:7: not there");
    EXPECT_EQ(deviceOf("not open: device \"usb:7\": busy, try 9", ArrayState::CLOSED), "not open");
}

TEST(MonitorMetrics, KeepToTheFormatWhateverTheNumbersAndTextsAre)
{
    FakeInstallation installation;
    installation.change(
        [](MonitorReading& reading)
        {
            reading.array = "a\"b\\c\nd\re\xFF";
            reading.statistics.figures = {{"rms", std::nan("")},
                                          {"surface.mean_Pa", HUGE_VAL},
                                          {"loudness", -HUGE_VAL},
                                          {"level_Pa", 1e-300}};
        });
    std::map<std::string, double> samples = parsed(metricsText(stateOf(installation)));
    EXPECT_TRUE(std::isnan(samples.at("midair_field_rms")));
    EXPECT_TRUE(std::isinf(samples.at("midair_field_surface_mean_pascals")));
    EXPECT_EQ(labelValue("a\"b\\c\nd\re\xFF"), "a\\\"b\\\\c\\nd e\xEF\xBF\xBD");
}

TEST(MonitorMetrics, AreWhatPrometheusToolAccepts)
{
    if (std::system("command -v promtool >/dev/null 2>&1") != 0)
        GTEST_SKIP() << "promtool isn't installed (Debian: prometheus)";
    const std::string path = testing::TempDir() + "metrics" + std::to_string(::getpid());
    const FakeInstallation installation;
    std::ofstream(path) << metricsText(stateOf(installation));
    EXPECT_EQ(std::system(("promtool check metrics < " + path).c_str()), 0);
    std::remove(path.c_str());
}
