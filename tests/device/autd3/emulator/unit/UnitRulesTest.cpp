// The rules of ids, numbers and the queue, one by one.

#include "tests/device/autd3/emulator/UnitBench.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace midair::device::emulation
{
namespace
{

ChainOptions units(int count)
{
    ChainOptions options;
    options.units = count;
    return options;
}

TEST(EmulatedUnitIds, other_versions_are_answered_to_anybody)
{
    ChainOptions options = units(1);
    options.protocolVersion = 3;
    UnitBench bench(options);
    EXPECT_EQ(bench.askOne(kNoId, "02 63 34 12"), hex("03 63 34 12 01"));
    EXPECT_EQ(bench.askOne(kGroup, "02 00 01 00 00 00"), hex("03 00 01 00 01"));
}

TEST(EmulatedUnitIds, what_is_too_short_or_unknown_or_to_the_wrong_one_gets_silence)
{
    UnitBench bench(units(1));
    EXPECT_TRUE(bench.ask(kGroup, hex("02 03 01")).empty());
    EXPECT_TRUE(bench.ask(kGroup, {}).empty());
    EXPECT_TRUE(bench.ask(kNoId, hex("02 08 01 00")).empty());
    EXPECT_TRUE(bench.ask(kNoId, hex("02 00 01 00 00 00")).empty()); // has no id
    EXPECT_TRUE(bench.ask(3, hex("02 01 01 00")).empty());
    EXPECT_TRUE(bench.ask(kNoId, hex("02 01 01 00 00*1449")).empty()); // over 1452
    EXPECT_EQ(bench.ask(kNoId, hex("02 01 01 00 00*1448")).size(), 1U);
    bench.open();
    EXPECT_TRUE(bench.ask(kGroup, hex("02 00 01 00 03 04")).empty());
    EXPECT_TRUE(bench.ask(0, hex("02 00 01 00 03")).empty());    // no command
    EXPECT_TRUE(bench.ask(kGroup, hex("02 03 01 00")).empty());  // Discover, with an id
    EXPECT_EQ(bench.askOne(0, "02 07 09 00 55 66").size(), 16U); // more than a body is ignored
}

TEST(EmulatedUnitIds, an_id_is_assigned_once_and_moves_the_address)
{
    UnitBench bench(units(1));
    EXPECT_EQ(bench.askOne(kNoId, "02 04 01 00 FF 00"), hex("02 04 01 00 03"));
    EXPECT_EQ(bench.askOne(kNoId, "02 04 01 00 05 02"), hex("02 04 01 00 03"));
    EXPECT_EQ(bench.askOne(kNoId, "02 04 01 00 05"), hex("02 04 01 00 03"));
    EXPECT_EQ(bench.askOne(kNoId, "02 05 01 00"), hex("02 05 01 00 02"));
    EXPECT_EQ(bench.askOne(kNoId, "02 06 01 00 00*8"), hex("02 06 01 00 02"));
    EXPECT_EQ(bench.lastFrom, kNoId);
    EXPECT_EQ(bench.askOne(kNoId, "02 04 01 00 05 00"), hex("02 04 01 00 00"));
    EXPECT_EQ(bench.lastFrom, 5);
    EXPECT_TRUE(bench.ask(kNoId, hex("02 04 01 00 06 00")).empty()); // nobody is there any more
    EXPECT_TRUE(bench.ask(5, hex("02 04 01 00 06 00")).empty());
    EXPECT_EQ(bench.askOne(5, "02 06 01 00 00*8"), hex("02 06 01 00 04")); // a slave
    EXPECT_EQ(bench.askOne(5, "02 06 01 00 00*7"), hex("02 06 01 00 04"));
    UnitBench master(units(1));
    EXPECT_EQ(master.askOne(kNoId, "02 01 01 00").at(7), 0xFF); // the port isn't known yet
    master.ask(kNoId, hex("02 04 01 00 00 01"));
    EXPECT_EQ(master.askOne(0, "02 01 01 00").at(7), 0x00);
    EXPECT_EQ(master.askOne(0, "02 06 01 00 00*7"), hex("02 06 01 00 03"));
    EXPECT_EQ(master.askOne(0, "02 06 01 00 00 CA 9A 3B FF FF FF 7F"), hex("02 06 01 00 03"));
    EXPECT_EQ(master.askOne(0, "02 01 01 00").at(6) & 0x38, 0x20);
    EXPECT_EQ(master.askOne(0, "02 06 01 00 00*8"), hex("02 06 01 00 00"));
    EXPECT_EQ(master.askOne(0, "02 01 01 00").at(6) & 0x30, 0x30); // follows nobody, so at once
}

TEST(EmulatedUnitIds, ResetId_takes_the_id_and_closes_the_way_after_20_ms)
{
    UnitBench bench(units(2));
    bench.open();
    EXPECT_EQ(bench.ask(kGroup, hex("02 02 01 00")).size(), 2U);
    bench.pass(19.9);
    EXPECT_EQ(bench.ask(1, hex("02 01 01 00")).size(), 1U);
    bench.pass(0.2);
    EXPECT_TRUE(bench.ask(1, hex("02 01 01 00")).empty());
    EXPECT_EQ(bench.ask(kGroup, hex("02 03 01 00")).size(), 1U); // the nearest alone
    // One that gets an id within the 20 ms keeps it: a new id ends what the last had to do.
    bench.ask(kGroup, hex("02 02 01 00"));
    EXPECT_EQ(bench.ask(kNoId, hex("02 04 01 00 00 01")).size(), 1U);
    bench.pass(21);
    EXPECT_EQ(bench.ask(0, hex("02 01 01 00")).size(), 1U);
}

TEST(EmulatedUnitIds, the_next_unit_hears_when_the_way_is_opened)
{
    UnitBench bench(units(3));
    EXPECT_EQ(bench.ask(kGroup, hex("02 03 01 00")).size(), 1U);
    bench.ask(kNoId, hex("02 04 01 00 00 01"));
    EXPECT_TRUE(bench.ask(kGroup, hex("02 03 01 00")).empty());
    EXPECT_EQ(bench.askOne(0, "02 05 01 00"), hex("02 05 01 00 00 01"));
    EXPECT_EQ(bench.ask(kGroup, hex("02 03 01 00")).size(), 1U);
    bench.ask(kNoId, hex("02 04 01 00 01 00"));
    bench.ask(1, hex("02 05 01 00"));
    bench.ask(kNoId, hex("02 04 01 00 02 00"));
    EXPECT_EQ(bench.askOne(2, "02 05 01 00"), hex("02 05 01 00 00 00")); // the last
    EXPECT_EQ(bench.ask(kGroup, hex("02 01 01 00")).size(), 3U);
    const Bytes last = bench.askOne(2, "02 01 01 00");
    EXPECT_EQ(last.at(6) & 0x07, 0x03); // passes on, nothing behind it
}

TEST(EmulatedUnitIds, a_reboot_forgets_the_id_and_closes_the_way)
{
    ChainOptions options = units(3);
    options.boot_ns = 100 * kMillisecond_ns;
    UnitBench bench(options);
    bench.pass(101);
    bench.open();
    EXPECT_EQ(bench.command(1, bench.rawSlot(0, 5, 1, 2)), 0);
    bench.chain.happen(ChainFaults::Kind::REBOOT, 1, bench.now_ns);
    EXPECT_TRUE(bench.ask(1, hex("02 07 01 00")).empty());
    EXPECT_TRUE(bench.ask(2, hex("02 07 01 00")).empty()); // behind it
    EXPECT_EQ(bench.ask(0, hex("02 07 01 00")).size(), 1U);
    bench.pass(101);
    EXPECT_EQ(bench.ask(kGroup, hex("02 03 01 00")).size(), 1U);
    EXPECT_TRUE(bench.ask(2, hex("02 07 01 00")).empty());
}

TEST(EmulatedUnitClocks, flags_come_after_a_settling_time_and_the_clock_is_the_grandmasters)
{
    ChainOptions options = units(2);
    options.settle_ns = 1000 * kMillisecond_ns;
    options.drift_ppm = 20;
    UnitBench bench(options);
    bench.ask(kNoId, hex("02 04 01 00 00 01"));
    bench.ask(0, hex("02 05 01 00"));
    bench.ask(kNoId, hex("02 04 01 00 01 00"));
    EXPECT_EQ(bench.askOne(0, "02 01 01 00").at(6) & 0x38, 0x20);
    bench.askOne(0, "02 00 01 00 00 00");
    EXPECT_EQ(bench.askOne(0, "02 00 01 00 00 01").at(5), 0x08); // Synchronize without a pulse
    bench.ask(0, hex("02 06 01 00 00*8"));
    bench.pass(999);
    EXPECT_EQ(bench.askOne(1, "02 01 01 00").at(6) & 0x18, 0);
    bench.pass(2);
    EXPECT_EQ(bench.askOne(0, "02 01 01 00").at(6) & 0x38, 0x38);
    EXPECT_EQ(bench.askOne(1, "02 01 01 00").at(6) & 0x38, 0x18);
    const Time_ns ahead_ns = bench.chain.unit(0).clock().at(bench.now_ns) - 1'001'000'000;
    EXPECT_NEAR(ahead_ns, 1'001'000'000 * 20e-6, 2); // its own rate, not the host's
    EXPECT_EQ(bench.chain.unit(1).clock().at(bench.now_ns) - 1'001'000'000, ahead_ns);

    bench.chain.happen(ChainFaults::Kind::SYNC_LOST, 1, bench.now_ns);
    EXPECT_EQ(bench.askOne(1, "02 01 01 00").at(6) & 0x18, 0);
    bench.pass(1000);
    EXPECT_GT(std::abs(bench.chain.unit(0).clock().at(bench.now_ns) -
                       bench.chain.unit(1).clock().at(bench.now_ns)),
              20'000);
    bench.chain.happen(ChainFaults::Kind::SYNC_BACK, 1, bench.now_ns);
    bench.pass(1001);
    EXPECT_EQ(bench.askOne(1, "02 01 01 00").at(6) & 0x18, 0x18);
    EXPECT_EQ(bench.chain.unit(1).cpu().telemetry.resync, 1U);
}

TEST(EmulatedUnitNumbers, what_is_out_of_turn_is_not_done)
{
    UnitBench bench(units(1));
    bench.open();
    const int due = bench.next[0];
    const Bytes late = bench.askOne(0, fmt::format("02 00 01 00 {:02X} 60 01", due + 1));
    EXPECT_EQ(late.at(4), due - 1);
    EXPECT_FALSE(bench.chain.unit(0).cpu().fan());
    EXPECT_EQ(bench.command(0, "60 01"), 0);
    EXPECT_TRUE(bench.chain.unit(0).cpu().fan());
    EXPECT_EQ(bench.report().telemetry.outOfTurn, 1U);
}

TEST(EmulatedUnitNumbers, numbers_go_round_and_Reset_begins_at_0)
{
    UnitBench bench(units(1));
    bench.open();
    for (int i = 0; i < 300; ++i)
        ASSERT_EQ(bench.command(0, "04"), 0) << i;
    EXPECT_EQ(bench.askOne(0, "02 00 01 00 C8 00").at(4), 0xFF);
    EXPECT_EQ(bench.askOne(0, "02 00 01 00 00 04").at(4), 0);
}

TEST(EmulatedUnitNumbers, a_repeat_is_never_done_twice_and_answered_when_it_is_done)
{
    ChainOptions options = units(1);
    options.perFrame_ns = kMillisecond_ns;
    UnitBench bench(options);
    bench.ask(kNoId, hex("02 04 01 00 00 01"));
    EXPECT_TRUE(bench.ask(0, hex("02 00 01 00 00 00")).empty());
    bench.pass(1);
    EXPECT_EQ(bench.answers().size(), 1U);
    EXPECT_TRUE(bench.ask(0, hex("02 00 02 00 00 60 01")).empty());
    EXPECT_TRUE(bench.ask(0, hex("02 00 03 00 00 60 00")).empty()); // only two bytes are compared
    bench.pass(1);
    const std::vector<Bytes> done = bench.answers();
    ASSERT_EQ(done.size(), 1U);
    EXPECT_EQ(done[0].at(2), 0x02); // the message number of its frame
    EXPECT_EQ(bench.askOne(0, "02 00 04 00 00 60 00").at(2), 0x04);
    EXPECT_TRUE(bench.chain.unit(0).cpu().fan());
    EXPECT_EQ(bench.report().telemetry.repeats, 2U);
    EXPECT_EQ(bench.report().telemetry.done, 1U); // Reset isn't counted
}

TEST(EmulatedUnitNumbers, an_eighth_frame_is_dropped_and_may_be_sent_again)
{
    ChainOptions options = units(1);
    options.perFrame_ns = kMillisecond_ns;
    UnitBench bench(options);
    bench.ask(kNoId, hex("02 04 01 00 00 01"));
    bench.ask(0, hex("02 00 01 00 00 00"));
    bench.pass(2);
    bench.answers();
    for (int i = 0; i < 8; ++i)
        bench.ask(0, hex(fmt::format("02 00 01 00 {:02X} 04", i)));
    bench.pass(20);
    EXPECT_EQ(bench.answers().size(), 7U);
    EXPECT_EQ(bench.report().telemetry.queueFull, 1U);
    bench.ask(0, hex("02 00 01 00 07 04"));
    bench.pass(2);
    const std::vector<Bytes> again = bench.answers();
    ASSERT_EQ(again.size(), 1U);
    EXPECT_EQ(again[0].at(4), 7);
}

// Only what is done is answered again: of a frame that was out of turn there is nothing to tell.
TEST(EmulatedUnitNumbers, a_repeat_of_what_was_out_of_turn_gets_silence)
{
    UnitBench bench(units(1));
    bench.open();
    const int due = bench.next[0];
    const std::string late = fmt::format("02 00 01 00 {:02X} 04", due + 1);
    EXPECT_EQ(bench.ask(0, hex(late)).size(), 1U);
    EXPECT_TRUE(bench.ask(0, hex(late)).empty());
    EXPECT_EQ(bench.report().telemetry.outOfTurn, 1U);
    EXPECT_EQ(bench.report().telemetry.repeats, 1U);
    EXPECT_EQ(bench.command(0, "04"), 0);
    EXPECT_EQ(bench.askOne(0, late).at(4), due + 1); // in turn by now, and not the last received
}

TEST(EmulatedUnitNumbers, what_is_done_is_told_to_who_spoke_last)
{
    ChainOptions options = units(1);
    options.perFrame_ns = kMillisecond_ns;
    UnitBench bench(options);
    bench.ask(kNoId, hex("02 04 01 00 00 01"));
    const Bytes reset = hex("02 00 01 00 00 00");
    const Bytes beat = hex("02 07 02 00");
    bench.chain.send(0, reset.data(), reset.size(), 11, bench.now_ns);
    bench.chain.send(0, beat.data(), beat.size(), 22, bench.now_ns);
    bench.pass(2);
    std::vector<std::uint64_t> peers;
    EmulatedChain::Answer answer;
    while (bench.chain.receive(answer, bench.now_ns))
        peers.push_back(answer.peer);
    EXPECT_EQ(peers, (std::vector<std::uint64_t>{22, 22}));
}

TEST(EmulatedUnitNumbers, an_error_uses_the_number_up)
{
    UnitBench bench(units(1));
    bench.open();
    bench.chain.failCommands(0, 0x07, 1);
    EXPECT_EQ(bench.command(0, "60 01"), 0x07);
    EXPECT_FALSE(bench.chain.unit(0).cpu().fan());
    EXPECT_EQ(bench.command(0, "60 01"), 0);
    EXPECT_EQ(bench.report().telemetry.errors, 1U);
}

TEST(EmulatedUnitNumbers, the_queue_outlives_ResetId)
{
    UnitBench bench(units(1));
    bench.open();
    const int due = bench.next[0];
    bench.ask(kGroup, hex("02 02 01 00"));
    bench.pass(30);
    bench.ask(kNoId, hex("02 04 01 00 00 01"));
    EXPECT_EQ(bench.askOne(0, "02 00 01 00 00 04").at(4), due - 1); // out of turn
}

} // namespace
} // namespace midair::device::emulation
