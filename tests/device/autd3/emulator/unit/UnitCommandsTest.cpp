// Each command: exact lengths, ranges, results.

#include "tests/device/autd3/emulator/UnitBench.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace midair::device::emulation
{
namespace
{

class EmulatedUnitCommands : public ::testing::Test
{
protected:
    EmulatedUnitCommands() { bench.open(); }
    UnitBench bench;
};

TEST_F(EmulatedUnitCommands, each_wants_its_length_exactly)
{
    const std::pair<const char*, std::size_t> lengths[] = {{"05", 64},
                                                           {"11", 14},
                                                           {"12", 10},
                                                           {"21", 10},
                                                           {"22", 10},
                                                           {"30", 10},
                                                           {"40", 249},
                                                           {"41", 32},
                                                           {"42", 512},
                                                           {"60", 1}};
    for (const auto& [command, length] : lengths)
        for (const std::size_t wrong : {length - 1, length + 1})
            EXPECT_EQ(bench.command(0, fmt::format("{} 00*{}", command, wrong)), 0x02)
                << command << " with " << wrong;
    for (const char* command : {"01", "03", "04", "06", "E7", "E8", "EB", "EC"})
        EXPECT_EQ(bench.command(0, fmt::format("{} 55*9", command)), 0) << command;
    for (const char* command : {"02", "07", "08", "10", "14", "50", "52", "FF"})
        EXPECT_EQ(bench.command(0, command), 0x01) << command;
    EXPECT_EQ(bench.report().updateCommands, 0U);
    EXPECT_EQ(bench.command(0, "70"), 0x01);
    EXPECT_EQ(bench.report().updateCommands, 1U);
}

TEST_F(EmulatedUnitCommands, slots_are_written_within_1024_and_whole)
{
    const char* good[] = {"15 00 01 00 00 00*498",
                          "15 01 02 FE 03 00*996",
                          "13 00 08 05 FF 00 00 00*1245",
                          "13 01 04 0B FF F5 03 00*1375"};
    const char* bad[] = {"15 02 01 00 00 00*498",
                         "15 00 00 00 00",
                         "15 00 03 00 00 00*1440",
                         "15 01 02 FF 03 00*996",
                         "15 01 01 00 04 00*498",
                         "15 00 01 00 00 00*497",
                         "15 00 01 00 00 00*499",
                         "15 00 01 00",
                         "13 02 08 01 FF 00 00 00*249",
                         "13 00 06 01 FF 00 00 00*249",
                         "13 00 08 00 FF 00 00",
                         "13 00 08 01 FF 00 04 00*249",
                         "13 01 04 0B FF F6 03 00*1375",
                         "13 00 04 01 FF 00 00 00*126",
                         "13 00 08 FF FF 00 00 00*249"};
    for (const char* command : good)
        EXPECT_EQ(bench.command(0, command), 0x00) << command;
    for (const char* command : bad)
        EXPECT_EQ(bench.command(0, command), 0x02) << command;
}

TEST_F(EmulatedUnitCommands, registers_have_ranges)
{
    EXPECT_EQ(bench.command(0, bench.patternConfig(1, 65535, 1024, 0)), 0);
    EXPECT_EQ(bench.command(0, bench.patternConfig(0, 0, 2, 0)), 0x02);
    EXPECT_EQ(bench.command(0, bench.patternConfig(0, 1, 0, 0)), 0x02);
    EXPECT_EQ(bench.command(0, bench.patternConfig(0, 1, 1025, 0)), 0x02);
    EXPECT_EQ(bench.command(0, bench.patternConfig(2, 1, 2, 0)), 0x02);
    EXPECT_EQ(bench.command(0, bench.patternConfig(0, 1, 1, 1)),
              0x02); // rounds: two slots at least
    EXPECT_EQ(bench.command(0, "11 00 00 01 00 02 00 00 00 00 00 00 00 FF FF"), 0x02); // foci
    EXPECT_EQ(bench.command(0, "21 00 00 01 00 02 00 00 00 FF FF"), 0);
    EXPECT_EQ(bench.command(0, "21 00 00 01 00 01 00 00 00 FF FF"), 0x02);
    EXPECT_EQ(bench.command(0, "21 00 00 01 00 00 00 01 00 FF FF"), 0); // 65536
    EXPECT_EQ(bench.command(0, "21 00 00 01 00 01 00 01 00 FF FF"), 0x02);
    EXPECT_EQ(bench.command(0, "20 00 00 01 00 00 00 80"), 0x02); // an odd offset
    EXPECT_EQ(bench.command(0, "20 00 00 FE FF 00 00 80 80"), 0);
    EXPECT_EQ(bench.command(0, "20 00 00 FE FF 00 00 80 80 80"), 0x02);
    EXPECT_EQ(bench.command(0, "20 00 00 00 00 00 00"), 0); // no samples are no error
    EXPECT_EQ(bench.command(0, "42 00 02 00*510"), 0);      // nor is a width of 512
    EXPECT_EQ(bench.command(0, "60 02"), 0x02);
}

TEST_F(EmulatedUnitCommands, a_strict_silencer_refuses_dividers_under_its_steps)
{
    EXPECT_EQ(bench.command(0, "30 02 00 00 01 00 01 0A 00 28 00"),
              0); // after Clear: divider 65535
    // Registers take any; the FPGA looks when they are to be played.
    EXPECT_EQ(bench.command(0, bench.patternConfig(1, 39, 2, 0)), 0);
    EXPECT_EQ(bench.command(0, bench.activation(0, 0xFF)), 0); // the other bank isn't heard
    EXPECT_EQ(bench.command(0, bench.activation(1, 0xFF)), 0x04);
    EXPECT_EQ(bench.state(0) & 0x04U, 0U);
    EXPECT_EQ(bench.command(0, bench.patternConfig(1, 40, 2, 0)), 0);
    EXPECT_EQ(bench.command(0, bench.activation(1, 0xFF)), 0);
    EXPECT_EQ(bench.command(0, "21 01 00 09 00 02 00 00 00 FF FF"), 0);
    EXPECT_EQ(bench.command(0, "22 01 FF 00*8"), 0x04);
    EXPECT_EQ(bench.command(0, "21 01 00 0A 00 02 00 00 00 FF FF"), 0);
    EXPECT_EQ(bench.command(0, "22 01 FF 00*8"), 0);
    EXPECT_EQ(bench.command(0, "30 02 00 00 01 00 01 0A 00 29 00"), 0x04); // 40 plays already
    EXPECT_EQ(bench.command(0, "30 03 00 00 01 00 01 0A 00 29 00"), 0);    // by rate none is strict
    EXPECT_EQ(bench.command(0, "30 00 00 00 01 00 01 0A 00 29 00"), 0);
    EXPECT_EQ(bench.command(0, "03"), 0); // not strict
    EXPECT_EQ(bench.command(0, bench.patternConfig(1, 39, 2, 0)), 0);
    EXPECT_EQ(bench.command(0, bench.activation(1, 0xFF)), 0);
}

// With rounds the bank that plays is heard until the switch, with the registers that are written.
TEST_F(EmulatedUnitCommands, a_strict_silencer_looks_at_the_bank_that_plays_until_the_switch)
{
    EXPECT_EQ(bench.command(0, "30 02 00 00 01 00 01 0A 00 28 00"), 0);
    EXPECT_EQ(bench.command(0, bench.patternConfig(0, 39, 2, 0)), 0);
    EXPECT_EQ(bench.command(0, bench.patternConfig(1, 40, 2, 1)), 0);
    EXPECT_EQ(bench.command(0, bench.activation(1, 0x00)), 0x04);
    EXPECT_EQ(bench.command(0, bench.patternConfig(0, 40, 2, 0)), 0);
    EXPECT_EQ(bench.command(0, bench.activation(1, 0x00)), 0);
}

TEST_F(EmulatedUnitCommands, the_silencer_wants_what_it_uses_alone)
{
    EXPECT_EQ(bench.command(0, "30 00 00 00 00 00 00 01 00 01 00"), 0);
    EXPECT_EQ(bench.command(0, "30 00 00 00 01 00 01 00 00 01 00"), 0x02);
    EXPECT_EQ(bench.command(0, "30 01 00 00 01 00 01 00 00 00 00"), 0);
    EXPECT_EQ(bench.command(0, "30 01 00 00 01 00 00 01 00 01 00"), 0x02);
    EXPECT_EQ(bench.command(0, "30 FC FF 00 01 00 01 01 00 01 00"), 0); // other bits are ignored
}

TEST_F(EmulatedUnitCommands, settings_that_make_no_sense_are_refused_whole)
{
    const std::string good = UnitBench::cpuConfig(1'000'000, 100);
    EXPECT_EQ(bench.command(0, good), 0);
    // Polls, polls of the flash, delay of an update, Syncs, samples, requests: not 0; and limits.
    for (const auto& [at, bytes] : {std::pair<int, const char*>{4, "00 00 00 00"},
                                    {8, "00 00 00 00"},
                                    {16, "00 00"},
                                    {18, "00 00"},
                                    {26, "00 00"},
                                    {44, "00 00 00 80"},
                                    {50, "00 00"},
                                    {52, "11 00"},
                                    {62, "01 00"},
                                    {62, "04 00"},
                                    {62, "03 01"}})
    {
        std::string bad = UnitBench::cpuConfig(2'000'000, 200);
        bad.replace(3 + 3 * static_cast<std::size_t>(at), std::string(bytes).size(), bytes);
        EXPECT_EQ(bench.command(0, bad), 0x02) << at << ": " << bytes;
        EXPECT_EQ(bench.chain.unit(0).cpu().config().margin_ns, kMillisecond_ns);
        EXPECT_EQ(bench.chain.unit(0).cpu().config().failsafe_ns, 100 * kMillisecond_ns);
    }
}

TEST_F(EmulatedUnitCommands, modes_have_to_fit_the_rounds)
{
    bench.command(0, bench.patternConfig(0, 1, 2, 0));
    bench.command(0, bench.patternConfig(1, 1, 2, 1));
    const std::uint64_t time_ns = 10'000'000'000;
    EXPECT_EQ(bench.command(0, bench.activation(0, 0x01, time_ns)), 0x05);
    EXPECT_EQ(bench.command(0, bench.activation(0, 0x00)), 0x05);
    EXPECT_EQ(bench.command(0, bench.activation(1, 0xFF)), 0x05);
    EXPECT_EQ(bench.command(0, bench.activation(0, 0xF0)), 0x02); // not emulated
    EXPECT_EQ(bench.command(0, bench.activation(2, 0xFF)), 0x02);
    EXPECT_EQ(bench.command(0, bench.activation(0, 0x07)), 0x02);
    EXPECT_EQ(bench.command(0, bench.activation(0, 0xFF)), 0);
    EXPECT_EQ(bench.command(0, bench.activation(1, 0x01, time_ns)), 0);
}

TEST_F(EmulatedUnitCommands, a_timed_switch_nearer_than_the_margin_is_refused)
{
    bench.command(0, bench.patternConfig(1, 1, 2, 1));
    const auto now_ns = static_cast<std::uint64_t>(bench.chain.unit(0).clock().at(bench.now_ns));
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, now_ns + 9'999'999)), 0x06); // default 10 ms
    EXPECT_EQ(bench.command(0, UnitBench::cpuConfig(1'000'000, 500)), 0);
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, now_ns + 999'999)), 0x06);
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, 0)), 0x06);
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, now_ns + 1'000'000)), 0);
}

TEST_F(EmulatedUnitCommands, the_failsafe_gates_all_though_all_is_acknowledged)
{
    bench.command(0, UnitBench::cpuConfig(1'000'000, 100));
    bench.command(0, bench.rawSlot(0, 0, 0, 255));
    EXPECT_EQ(bench.state(0) & 0x80U, 0U);
    bench.pass(99);
    EXPECT_EQ(bench.askOne(0, "02 07 01 00").size(), 17U); // a heartbeat feeds it
    bench.pass(99);
    EXPECT_EQ(bench.state(0) & 0x80U, 0U);
    EXPECT_GT(std::abs(bench.chain.output(bench.now_ns)[0]), 0.99F);
    bench.pass(101);
    EXPECT_LT(std::abs(bench.chain.output(bench.now_ns)[0]), 1e-6F);
    bench.pass(1);
    EXPECT_EQ(bench.command(0, bench.rawSlot(1, 0, 0, 255)), 0);
    EXPECT_EQ(bench.command(0, bench.patternConfig(1, 1, 1, 0)), 0);
    EXPECT_EQ(bench.command(0, bench.activation(1, 0xFF)), 0);
    EXPECT_EQ(bench.state(0) & 0x84U, 0x84U);
    bench.pass(1);
    EXPECT_LT(std::abs(bench.chain.output(bench.now_ns)[0]), 1e-6F);
    EXPECT_EQ(bench.command(0, "06"), 0);
    bench.pass(1);
    EXPECT_GT(std::abs(bench.chain.output(bench.now_ns)[0]), 0.99F);
    EXPECT_EQ(bench.report().telemetry.failsafe, 1U);
}

// The CPU counts its own milliseconds: what it hears late in one counts from its beginning.
TEST_F(EmulatedUnitCommands, the_failsafe_may_come_a_millisecond_early)
{
    bench.pass(1 - std::fmod(static_cast<double>(bench.now_ns) / 1e6, 1) + 0.9);
    bench.command(0, UnitBench::cpuConfig(1'000'000, 100));
    bench.pass(99);
    EXPECT_FALSE(bench.chain.unit(0).fpga().gated());
    bench.pass(0.11);
    EXPECT_TRUE(bench.chain.unit(0).fpga().gated());
}

TEST_F(EmulatedUnitCommands, Clear_ends_the_failsafe_and_forgets_what_was_counted)
{
    bench.command(0, UnitBench::cpuConfig(1'000'000, 100));
    EXPECT_EQ(bench.command(0, "60 07"), 0x02);
    bench.pass(150);
    EXPECT_EQ(bench.report().telemetry.failsafe, 1U);
    EXPECT_EQ(bench.command(0, "03"), 0);
    EXPECT_FALSE(bench.chain.unit(0).fpga().gated());
    EXPECT_EQ(bench.read(0, "E8"), hex("00*16 01 00*23")); // Clear itself is counted
    EXPECT_EQ(bench.report().trips, 1U);
    bench.pass(501); // the default by now
    EXPECT_TRUE(bench.chain.unit(0).fpga().gated());
    EXPECT_EQ(bench.report().trips, 2U);
}

TEST_F(EmulatedUnitCommands, a_unit_that_never_had_a_lock_has_lost_none)
{
    UnitBench fresh;
    fresh.ask(kNoId, hex("02 04 01 00 00 01"));
    fresh.askOne(0, "02 00 01 00 00 00");
    fresh.command(0, UnitBench::cpuConfig(1'000'000, 0, 50));
    fresh.pass(5000);
    EXPECT_FALSE(fresh.chain.unit(0).fpga().gated());
}

TEST_F(EmulatedUnitCommands, ReleaseFailsafe_is_refused_while_its_cause_lasts)
{
    bench.command(0, UnitBench::cpuConfig(1'000'000, 0, 50));
    bench.chain.happen(ChainFaults::Kind::SYNC_LOST, 0, bench.now_ns);
    bench.pass(51);
    EXPECT_EQ(bench.state(0) & 0x80U, 0x80U);
    EXPECT_EQ(bench.command(0, "06"), 0x15);
    bench.chain.happen(ChainFaults::Kind::SYNC_BACK, 0, bench.now_ns);
    bench.pass(1);
    EXPECT_EQ(bench.state(0) & 0x80U, 0x80U); // stays until it is released
    EXPECT_EQ(bench.command(0, "06"), 0);
    EXPECT_EQ(bench.state(0) & 0x80U, 0U);
    EXPECT_EQ(bench.report().telemetry.lockFailsafe, 1U);
}

TEST_F(EmulatedUnitCommands, the_failsafe_runs_from_the_first_frame_and_outlives_ResetId)
{
    UnitBench fresh;
    fresh.ask(kNoId, hex("02 04 01 00 00 01"));
    fresh.pass(5000);
    EXPECT_FALSE(fresh.chain.unit(0).fpga().gated()); // nobody spoke to it yet
    fresh.ask(0, hex("02 07 01 00"));
    fresh.ask(kGroup, hex("02 02 01 00"));
    fresh.pass(499);
    EXPECT_FALSE(fresh.chain.unit(0).fpga().gated());
    fresh.pass(2);
    EXPECT_TRUE(fresh.chain.unit(0).fpga().gated());
}

TEST_F(EmulatedUnitCommands, Clear_silences_and_restores_but_leaves_later_slots)
{
    bench.command(0, bench.rawSlot(0, 0, 0, 255));
    bench.command(0, bench.rawSlot(0, 1, 0, 200));
    bench.command(0, "60 01");
    bench.command(0, "40 10*249");
    bench.command(0, "41 00*32");
    EXPECT_EQ(bench.command(0, "03"), 0);
    EXPECT_FALSE(bench.chain.unit(0).cpu().fan());
    EXPECT_EQ(bench.state(0), 0x08U);
    EXPECT_EQ(bench.chain.unit(0).cpu().config().failsafe_ns, 500 * kMillisecond_ns);
    EXPECT_EQ(bench.chain.field(bench.now_ns).duty[0], 0);
    // What the bank held in its second slot is heard when it has two: a sender has to write both.
    bench.command(0, "30 00 00 00 01 00 01 01 00 01 00");
    bench.command(0, bench.patternConfig(0, 1, 2, 0));
    bench.command(0, bench.activation(0, 0xFF));
    bench.pass(0.025);
    const int first = bench.chain.field(bench.now_ns).duty[0];
    bench.pass(0.025);
    EXPECT_GT(first + bench.chain.field(bench.now_ns).duty[0], 0);
}

} // namespace
} // namespace midair::device::emulation
