#include "plugin/overlays/hud/HudSheets.h"

#include <gtest/gtest.h>

using namespace osgMidair;
namespace bridge = midair::bridge;

namespace
{

ArrayNews newsIn(ArrayState state)
{
    ArrayNews news;
    news.statistics.state = state;
    news.statistics.device = "sim: unplugged";
    return news;
}

HapticMessage
message(HapticMessage::Severity severity, const std::string& text, const std::string& path = "")
{
    HapticMessage made;
    made.severity = severity;
    made.path = path;
    made.text = path.empty() ? text : path + ": " + text;
    made.isActive = true;
    return made;
}

} // namespace

TEST(HudContent, AnAlarmSaysWhatTheArrayDoesAndWhy)
{
    EXPECT_EQ(alarmOf(newsIn(ArrayState::PLAYING), nullptr).word, "");
    EXPECT_EQ(alarmOf(newsIn(ArrayState::OPENING), nullptr).word, "");
    EXPECT_EQ(alarmOf(newsIn(ArrayState::MUTED), nullptr).word, "MUTED");
    EXPECT_EQ(alarmOf(newsIn(ArrayState::LOST), nullptr).word, "LOST");
    EXPECT_EQ(alarmOf(newsIn(ArrayState::LOST), nullptr).reason, "sim: unplugged");
    EXPECT_EQ(alarmOf(newsIn(ArrayState::FAULT), nullptr).word, "FAULT");

    ArrayNews muted = newsIn(ArrayState::PLAYING); // the thread has not come to it yet
    muted.isMuted = true;
    EXPECT_EQ(alarmOf(muted, nullptr).word, "MUTED");

    ArrayNews capped = newsIn(ArrayState::PLAYING);
    capped.statistics.capFactor = 0.4;
    capped.statistics.maxPressure_Pa = 800.0;
    const HudAlarm alarm = alarmOf(capped, nullptr);
    EXPECT_EQ(alarm.word, "CAPPED");
    EXPECT_EQ(alarm.reason, "limited to 800 Pa: 40 % of the drive");
    EXPECT_FALSE(alarm.isSilence);
    capped.statistics.exposure.limit_dB = 110.0;
    EXPECT_EQ(alarmOf(capped, nullptr).reason,
              "limited to 800 Pa and 110 dB at ears: 40 % of the drive");
    HapticMessage& binding = capped.statistics.told.emplace_back();
    binding.isActive = true;
    binding.code = "cap.ears";
    EXPECT_EQ(alarmOf(capped, nullptr).reason, "limited to 110 dB at ears: 40 % of the drive");
    binding.code = "cap.pressure";
    EXPECT_EQ(alarmOf(capped, nullptr).reason, "limited to 800 Pa: 40 % of the drive");
    capped.statistics.told.clear();
    capped.statistics.maxPressure_Pa = 0.0;
    EXPECT_EQ(alarmOf(capped, nullptr).reason, "limited to 110 dB at ears: 40 % of the drive");
}

TEST(HudContent, SilenceHasAReason)
{
    const auto silent = [](const ArrayNews& news, const bridge::HologramResult* result)
    {
        const HudAlarm alarm = alarmOf(news, result);
        EXPECT_EQ(alarm.word, "SILENT");
        return alarm.reason;
    };
    bridge::HologramResult nothing;
    ArrayNews news = newsIn(ArrayState::SILENT);
    EXPECT_EQ(silent(news, &nothing), "no haptic object in sight");
    news.statistics.objects = 1;
    EXPECT_EQ(silent(news, &nothing), "there is nothing to play");
    news.statistics.told = {
        message(HapticMessage::WARNING, "has no triangles", "HapticScene/Group 'mug'")};
    EXPECT_EQ(silent(news, &nothing), "has no triangles ('mug')");
    nothing.sequence.report.message = "no level of the device is low enough";
    EXPECT_EQ(silent(news, &nothing), "no level of the device is low enough");
    news.isEnabled = false;
    EXPECT_EQ(silent(news, &nothing), "the scene is disabled (Enabled)");

    ArrayNews closed = newsIn(ArrayState::CLOSED);
    EXPECT_EQ(alarmOf(closed, nullptr).word, "") << "before the first field nothing is wrong";
    closed.statistics.told = {message(HapticMessage::FAULT, "no such device")};
    EXPECT_EQ(silent(closed, nullptr), "no such device");
    closed.statistics.told[0].isActive = false;
    EXPECT_EQ(alarmOf(closed, nullptr).word, "") << "it is over";
}

TEST(HudContent, MessagesBeginWithTheWorstAndWithTheirCause)
{
    ArrayNews news = newsIn(ArrayState::SILENT);
    news.statistics.told = {message(HapticMessage::FAULT, "no such device"),
                            message(HapticMessage::NOTICE, "is played otherwise"),
                            message(HapticMessage::WARNING, "is left out", "HapticScene/Group"),
                            message(HapticMessage::WARNING, "is unpainted")};
    const std::vector<std::string> wanted = {
        "no such device", "is unpainted", "is left out (Group)", "is played otherwise"};
    EXPECT_EQ(messagesOf(news, {}), wanted);
    EXPECT_EQ(messagesOf(news, {"SILENT", "no such device"}),
              std::vector<std::string>(wanted.begin() + 1, wanted.end()))
        << "what is said in large letters isn't said again";
    news.statistics.told[0].isActive = false; // it was found in the end
    news.statistics.told[0].until_s = 1.0;
    news.statistics.told[3].isActive = false; // it has happened
    EXPECT_EQ(
        messagesOf(news, {}),
        (std::vector<std::string>{"is left out (Group)", "is played otherwise", "is unpainted"}));
}

TEST(HudContent, WhatMattersComesFirst)
{
    bridge::HologramResult result;
    result.state = ArrayState::PLAYING;
    result.sequence.report.level_Pa = 1234.0;
    result.sequence.report.rms = 0.02;
    result.sequence.report.max = 0.05;
    result.latency_ms = 3.5;
    result.fingertip = {6.2e-3, 0.0, midair::haptics::PlayedAs::CIRCLING};
    ArrayNews news = newsOf(result);
    const HudRows rows = rowsOf(&result, news, {});
    ASSERT_GE(rows.size(), 5U);
    const HudRows first(rows.begin(), rows.begin() + 5);
    const HudRows wanted = {{"state", "playing"},
                            {"pressure", "1234 Pa (peak)"},
                            {"fingertip", "6.2 mN, clear"},
                            {"error rms", "2.00 % (max 5.00 %)"},
                            {"latency", "3.5 ms"}};
    EXPECT_EQ(first, wanted);
    EXPECT_EQ(rowsOf(nullptr, news, {}), HudRows({{"state", "playing"}})) << "before any field";
    news.isMuted = true;
    EXPECT_EQ(rowsOf(&result, news, {})[1].second, "0 of 1234 Pa (peak)");
    EXPECT_EQ(rowsOf(&result, news, {})[2].second, "nothing");
    result.sequence.report = {}; // of contacts that nobody touches
    EXPECT_EQ(rowsOf(&result, news, {})[1].second, "none");
    EXPECT_EQ(rowsOf(&result, news, {})[3].second, "none");
}
