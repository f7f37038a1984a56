#include "device/autd3/protocol/Commands.h"

#include "device/autd3/protocol/Messages.h"
#include "tests/device/autd3/protocol/HexText.h"

#include <numeric>

#include <gtest/gtest.h>

using namespace midair::device::autd3;

namespace
{

/// What is sent in one session with unit 0 of two, as the wire format's examples have it.
struct Row
{
    const char* what;
    std::vector<std::uint8_t> sent;
    const char* text;
};

void expectRows(const std::vector<Row>& rows)
{
    for (const Row& row : rows)
        EXPECT_EQ(row.sent, bytesOf(row.text)) << row.what;
}

UnitPattern counting()
{
    UnitPattern pattern;
    std::iota(pattern.phase.begin(), pattern.phase.end(), std::uint8_t{0});
    pattern.intensity.fill(0xFF);
    return pattern;
}

UnitPattern even(std::uint8_t phase)
{
    UnitPattern pattern;
    pattern.phase.fill(phase);
    return pattern;
}

} // namespace

TEST(Autd3Commands, openings_are_as_in_the_examples)
{
    expectRows({
        {"ResetId", message(Kind::RESET_ID, 1), "02 02 01 00"},
        {"Discover", message(Kind::DISCOVER, 2), "02 03 02 00"},
        {"AssignId", assignId(3, 0, true), "02 04 03 00 00 01"},
        {"AssignId to a slave", assignId(3, 1, false), "02 04 03 00 01 00"},
        {"UnblockDownstream", message(Kind::UNBLOCK_DOWNSTREAM, 4), "02 05 04 00"},
        {"SetTime", setTime(5, 0), "02 06 05 00 00*8"},
        {"SetTime later", setTime(5, kTextTime_ns), "02 06 05 00 (T)"},
        {"ReadUnitInfo", message(Kind::READ_UNIT_INFO, 6), "02 01 06 00"},
        {"Heartbeat", message(Kind::HEARTBEAT, 7), "02 07 07 00"},
        {"number", message(Kind::HEARTBEAT, 0x1234), "02 07 34 12"},
    });
}

TEST(Autd3Commands, settings_are_as_in_the_examples)
{
    CpuConfig cpu;
    cpu.switchMargin_ns = 1'000'000;
    cpu.failsafe_ms = 100;
    expectRows({
        {"Reset", frame(1, 0, Command::reset()), "02 00 01 00 00 00"},
        {"ReadFirmwareInfo", frame(2, 0, Command::readFirmware()), "02 00 02 00 00 EB"},
        {"Clear", frame(3, 1, Command::clear()), "02 00 03 00 01 03"},
        {"Synchronize", frame(4, 2, Command::synchronize()), "02 00 04 00 02 01"},
        {"SetCpuConfig",
         frame(5, 3, Command::configureCpu(cpu)),
         "02 00 05 00 03 05 40 42 0F 00 40 42 0F 00 00 94 35 77 90 D0 03 00 64 00 08 00 03 00 06 "
         "00 E8 03 40 00 10 27 00 00 64 00 00 00 32 00 00 00 01 00 00 00 20 A1 07 00 64 00 20 00 "
         "05 00 30 00 40 00 08 00 00 00 03 00"},
        {"SetSilencer",
         frame(6, 4, Command::setSilencer({40, 10})),
         "02 00 06 00 04 30 00 00 00 01 00 01 0A 00 28 00"},
        {"SetOutputMask",
         frame(8, 6, Command::setOutputMask({17})),
         "02 00 08 00 06 41 FF FF FD FF*28 01"},
        {"SetOutputMask of all",
         frame(0x19, 0x16, Command::silenceAll()),
         "02 00 19 00 16 41 00*32"},
        {"Nop", frame(0x0E, 0x0D, Command::nop()), "02 00 0E 00 0D 04"},
        {"ReadFpgaState", frame(0x0F, 0x0C, Command::readFpgaState()), "02 00 0F 00 0C E7"},
        {"ReleaseFailsafe", frame(0x1E, 0x1B, Command::releaseFailsafe()), "02 00 1E 00 1B 06"},
        {"ReadTelemetry", frame(0x1F, 0x1C, Command::readTelemetry()), "02 00 1F 00 1C E8"},
    });
    const auto widths = frame(7, 5, Command::setPulseWidths(dutyWidths()));
    ASSERT_EQ(widths.size(), 6u + 512u);
    const std::vector<std::uint8_t> begin(widths.begin(), widths.begin() + 14);
    EXPECT_EQ(begin, bytesOf("02 00 07 00 05 42 00 00 01 00 02 00 03 00"));
}

TEST(Autd3Commands, patterns_are_as_in_the_examples)
{
    const UnitPattern count = counting();
    const UnitPattern half = even(0x80);
    const BankConfig once = {1, 2, false};
    expectRows({
        {"bank 0 once",
         frame(9, 7, Command::configureBank(0, once)),
         "02 00 09 00 07 11 00 01 01 00 02 00 00 00 00 00 00 00 00 00"},
        {"bank 1 once",
         frame(0x0A, 8, Command::configureBank(1, once)),
         "02 00 0A 00 08 11 01 01 01 00 02 00 00 00 00 00 00 00 00 00"},
        {"raw",
         frame(0x0B, 9, Command::writeRaw(1, 0, {&count, &count})),
         "02 00 0B 00 09 15 01 02 00 00 00..F8 FF*249 00..F8 FF*249"},
        {"switch at 0.1 s",
         frame(0x0C, 0x0A, Command::activateBank(1, SwitchMode::AT_TIME, 100'000'000)),
         "02 00 0C 00 0A 12 01 01 00 E1 F5 05 00 00 00 00"},
        {"switch in the past",
         frame(0x0D, 0x0B, Command::activateBank(1, SwitchMode::AT_TIME, 1)),
         "02 00 0D 00 0B 12 01 01 01 00*7"},
        {"100 slots at 1 kHz",
         frame(0x11, 0x0E, Command::configureBank(0, {40, 100, true})),
         "02 00 11 00 0E 11 00 01 28 00 64 00 00 00 00 00 00 00 FF FF"},
        {"at once",
         frame(0x14, 0x11, Command::activateBank(0, SwitchMode::AT_ONCE)),
         "02 00 14 00 11 12 00 FF 00*8"},
    });
    UnitPattern quarter = even(0x40);
    EXPECT_EQ(frame(0x12, 0x0F, Command::writePhases(0, 98, 0xFF, {&half, &quarter})),
              bytesOf("02 00 12 00 0F 13 00 08 02 FF 62 00 80*249 40*249"));
}

TEST(Autd3Commands, no_frame_is_longer_than_a_datagram_may_be)
{
    const UnitPattern pattern = counting();
    const std::vector<const UnitPattern*> two(kMostRawSlots, &pattern);
    const std::vector<const UnitPattern*> five(kMostPhaseSlots, &pattern);
    EXPECT_LE(frame(0, 0, Command::writeRaw(0, 0, two)).size(), 1452u);
    EXPECT_LE(frame(0, 0, Command::writePhases(0, 0, 9, five)).size(), 1452u);
}

// Every command that there is: none touches the firmware.
TEST(Autd3Commands, none_is_an_update_of_the_firmware)
{
    const UnitPattern pattern = counting();
    const std::vector<Command> all = {Command::reset(),
                                      Command::synchronize(),
                                      Command::clear(),
                                      Command::nop(),
                                      Command::configureCpu({}),
                                      Command::releaseFailsafe(),
                                      Command::readFpgaState(),
                                      Command::readTelemetry(),
                                      Command::readFirmware(),
                                      Command::configureBank(0, {}),
                                      Command::activateBank(0, SwitchMode::AT_ONCE),
                                      Command::writePhases(0, 0, 0, {&pattern}),
                                      Command::writeRaw(0, 0, {&pattern}),
                                      Command::setSilencer({}),
                                      Command::setOutputMask({}),
                                      Command::silenceAll(),
                                      Command::setPulseWidths(dutyWidths())};
    for (const Command& command : all)
        EXPECT_FALSE(command.code() >= 0x70 && command.code() <= 0x78) << int(command.code());
}
