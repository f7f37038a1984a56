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
    for (const char* command : {"01", "03", "04", "06", "E7", "E8", "EB"})
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
    EXPECT_EQ(bench.command(0, "20 00 00 00 00 00 00"), 0x02);
    EXPECT_EQ(bench.command(0, "42 00 02 00*510"), 0x02); // a width of 512
    EXPECT_EQ(bench.command(0, "60 02"), 0x02);
}

TEST_F(EmulatedUnitCommands, a_strict_silencer_refuses_dividers_under_its_steps)
{
    EXPECT_EQ(bench.command(0, "30 02 00 00 01 00 01 0A 00 28 00"),
              0); // after Clear: divider 65535
    EXPECT_EQ(bench.command(0, bench.patternConfig(0, 39, 2, 0)), 0x04);
    EXPECT_EQ(bench.command(0, bench.patternConfig(0, 40, 2, 0)), 0);
    EXPECT_EQ(bench.command(0, "21 00 00 09 00 02 00 00 00 FF FF"), 0x04);
    EXPECT_EQ(bench.command(0, "21 00 00 0A 00 02 00 00 00 FF FF"), 0);
    EXPECT_EQ(bench.command(0, bench.activation(0, 0xFF)), 0);
    EXPECT_EQ(bench.command(0, "30 02 00 00 01 00 01 0A 00 29 00"), 0x04); // one plays already
    EXPECT_EQ(bench.command(0, "30 00 00 00 01 00 01 0A 00 29 00"), 0);
    EXPECT_EQ(bench.command(0, "03"), 0); // strict again
    EXPECT_EQ(bench.command(0, bench.patternConfig(0, 39, 2, 0)), 0x04);
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
    EXPECT_EQ(bench.command(0, "05 40 42 0F 00 00*60"), 0);                        // 1 ms
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, now_ns + 999'999)), 0x06);
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, 0)), 0x06);
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, now_ns + 1'000'000)), 0);
}

TEST_F(EmulatedUnitCommands, the_failsafe_gates_all_though_all_is_acknowledged)
{
    bench.command(0, "05 40 42 0F 00 00*44 64 00 00*14"); // 100 ms
    bench.command(0, bench.rawSlot(0, 0, 0, 255));
    EXPECT_EQ(bench.state(0) & 0x80U, 0U);
    bench.pass(99);
    EXPECT_EQ(bench.askOne(0, "02 07 01 00").size(), 16U); // a heartbeat feeds it
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

TEST_F(EmulatedUnitCommands, ReleaseFailsafe_is_refused_while_its_cause_lasts)
{
    bench.command(0, "05 40 42 0F 00 00*56 32 00 03 00"); // 50 ms without lock
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
