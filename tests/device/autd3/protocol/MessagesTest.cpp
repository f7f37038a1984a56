#include "device/autd3/protocol/Messages.h"

#include "tests/device/autd3/protocol/HexText.h"

#include <gtest/gtest.h>

using namespace midair::device::autd3;

namespace
{

Answer answerOf(const std::string& text)
{
    Answer answer;
    std::string error;
    EXPECT_TRUE(readAnswer(bytesOf(text), answer, error)) << text << ": " << error;
    return answer;
}

std::string whyNot(const std::string& text)
{
    Answer answer;
    answer.number = 0x7777;
    std::string error;
    EXPECT_FALSE(readAnswer(bytesOf(text), answer, error)) << text;
    EXPECT_EQ(answer.number, 0x7777) << "changed by what is refused: " << text;
    return error;
}

} // namespace

TEST(Autd3Messages, answers_are_read_as_in_the_examples)
{
    const Answer wrong = answerOf("02 03 34 12 01"); // to a version that it doesn't speak
    EXPECT_EQ(wrong.number, 0x1234);
    EXPECT_EQ(wrong.status, 1);
    EXPECT_EQ(answerOf("02 02 01 00 00").kind, Kind::RESET_ID);
    EXPECT_EQ(answerOf("02 03 02 00 00").kind, Kind::DISCOVER);
    EXPECT_EQ(answerOf("02 04 03 00 00").kind, Kind::ASSIGN_ID);
    EXPECT_TRUE(answerOf("02 05 04 00 00 01").hasDownstream);
    EXPECT_FALSE(answerOf("02 05 04 00 00 00").hasDownstream);
    EXPECT_EQ(answerOf("02 06 05 00 00").status, 0);
    const UnitInfo info = answerOf("02 01 06 00 00 00 3F 00 00 00 0A 00 00 (T) 00*4").info;
    EXPECT_EQ(info.id, 0);
    EXPECT_EQ(info.flags, 0x3F);
    EXPECT_EQ(info.firmware.text(), "0.10.0");
    EXPECT_EQ(info.time_ns, kTextTime_ns);
}

TEST(Autd3Messages, frame_replies_are_read_as_in_the_examples)
{
    const Answer beat = answerOf("02 07 07 00 FF 00 3F 00 (T)");
    EXPECT_EQ(beat.kind, Kind::HEARTBEAT);
    EXPECT_EQ(beat.reply.acknowledged, 0xFF);
    EXPECT_EQ(beat.reply.flags, 0x3F);
    EXPECT_EQ(beat.reply.id, 0);
    EXPECT_EQ(beat.reply.time_ns, kTextTime_ns);
    EXPECT_TRUE(beat.reply.data.empty());
    // After a read a heartbeat has what that has read, as any answer has.
    EXPECT_EQ(answerOf("02 07 07 00 0C 00 3F 00 (T) 40").reply.data, bytesOf("40"));
    EXPECT_EQ(answerOf("02 07 07 00 0C 00 3F 00 (T) 11*40").reply.data, bytesOf("11*40"));
    const Answer late = answerOf("02 00 0D 00 0B 06 3F 00 (T)");
    EXPECT_EQ(late.reply.acknowledged, 0x0B);
    EXPECT_EQ(late.reply.result, TOO_NEAR);
    const Answer state = answerOf("02 00 0F 00 0C 00 3F 00 (T) 40");
    EXPECT_EQ(state.reply.data, bytesOf("40"));
    const Answer firmware = answerOf("02 00 02 00 00 00 3F 00 (T) 00 0A 00 00 0A 00 8C 01");
    FirmwareInfo info;
    ASSERT_TRUE(readFirmwareInfo(firmware.reply.data, info));
    EXPECT_EQ(info.cpu.text(), "0.10.0");
    EXPECT_EQ(info.fpga.text(), "0.10.0");
    EXPECT_TRUE(info.isEmulator);
    const Answer telemetry = answerOf("02 00 1F 00 1C 00 3F 00 (T) 00*4 01 00*3 01 00*3 03 00*3 "
                                      "1B 00*3 01 00*3 00*16");
    EXPECT_EQ(telemetry.reply.data.size(), 40u);
}

TEST(Autd3Messages, another_version_is_told_by_the_answer)
{
    const Answer answer = answerOf("03 01 06 00 01");
    EXPECT_EQ(answer.version, 3);
    EXPECT_EQ(answer.number, 6);
    EXPECT_EQ(answer.status, 1);
    EXPECT_EQ(answerOf("03 00 06 00 01").version, 3);
}

TEST(Autd3Messages, a_unit_without_id_refuses_a_heartbeat)
{
    const Answer answer = answerOf("02 07 06 00 02");
    EXPECT_EQ(answer.status, 2);
    EXPECT_NE(statusText(answer.status).find("no id"), std::string::npos);
}

TEST(Autd3Messages, what_is_no_answer_is_refused_with_a_reason)
{
    EXPECT_NE(whyNot("").find("0 bytes"), std::string::npos);
    EXPECT_NE(whyNot("02 03 02").find("3 bytes"), std::string::npos);
    EXPECT_NE(whyNot("02 08 02 00 00").find("kind 8"), std::string::npos);
    EXPECT_NE(whyNot("02 FF 02 00 00").find("kind 255"), std::string::npos);
    for (const char* text : {"02 03 02 00",
                             "02 03 02 00 00 00",
                             "02 05 04 00 00",
                             "02 05 04 00 00 02",
                             "02 05 04 00 00 01 00",
                             "02 01 06 00 00",
                             "02 01 06 00 00*20",
                             "02 00 01 00 00",
                             "02 00 01 00 00*11",
                             "02 00 01 00 00*53",
                             "02 07 01 00 00*53",
                             "03 00 01 00 00*12",
                             "03 00 01 00"})
        EXPECT_FALSE(whyNot(text).empty());
}

TEST(Autd3Messages, firmware_of_another_length_is_refused)
{
    FirmwareInfo info;
    EXPECT_FALSE(readFirmwareInfo(bytesOf("00 0A 00 00 0A 00 8C"), info));
    EXPECT_FALSE(readFirmwareInfo(bytesOf("00*9"), info));
}
