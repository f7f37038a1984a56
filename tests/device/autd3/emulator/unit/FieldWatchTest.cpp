#include "device/autd3/emulator/unit/FieldWatch.h"

#include "tests/device/autd3/emulator/UnitBench.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace midair::device::emulation
{
namespace
{

constexpr Time_ns kTolerance_ns = 50'000;

DriveSignal even(int units, int phase, int duty)
{
    DriveSignal signal = silentSignal(units * kUnitTransducers);
    std::fill(signal.phase.begin(), signal.phase.end(), static_cast<std::uint8_t>(phase));
    std::fill(signal.duty.begin(), signal.duty.end(), static_cast<std::uint8_t>(duty));
    return signal;
}

/// Three opened units whose silencer is off, and whose margin is 1 ms.
class EmulatedFieldWatch : public ::testing::Test
{
protected:
    static ChainOptions options()
    {
        ChainOptions options;
        options.units = 3;
        options.tolerance_ns = kTolerance_ns;
        return options;
    }
    EmulatedFieldWatch() : bench(options())
    {
        bench.open();
        for (int unit = 0; unit < 3; ++unit)
        {
            bench.command(unit, UnitBench::cpuConfig(1'000'000, 0));
            for (int bank = 0; bank < 2; ++bank)
            {
                bench.command(unit, bench.rawSlot(bank, 1, 0, 0));
                bench.command(unit, bench.patternConfig(bank, 1, 2, 1));
            }
        }
    }

    void write(int unit, int bank, int level)
    {
        for (int slot = 0; slot < 2; ++slot)
            ASSERT_EQ(bench.command(unit, bench.rawSlot(bank, slot, level, 255)), 0);
    }
    int activate(int unit, int bank, double ahead_ms)
    {
        const Time_ns now_ns = bench.chain.unit(0).clock().at(bench.now_ns);
        return bench.command(
            unit, bench.activation(bank, 1, std::uint64_t(now_ns + Time_ns(ahead_ms * 1e6))));
    }
    FieldWatchReport seen() const { return bench.report().fields; }

    UnitBench bench;
};

TEST_F(EmulatedFieldWatch, fields_that_change_together_are_whole)
{
    for (int field = 1; field <= 4; ++field)
    {
        for (int unit = 0; unit < 3; ++unit)
            write(unit, field % 2, field);
        for (int unit = 0; unit < 3; ++unit)
            EXPECT_EQ(activate(unit, field % 2, 2), 0);
        bench.pass(3);
    }
    EXPECT_EQ(seen().whole, 4U);
    EXPECT_EQ(seen().torn, 0U);
    EXPECT_EQ(seen().worstSkew_ns, 0);
    EXPECT_EQ(bench.report().writesIntoBanks, 0U);
}

TEST_F(EmulatedFieldWatch, a_unit_that_changes_late_or_never_tears_the_field)
{
    for (int unit = 0; unit < 3; ++unit)
        write(unit, 1, 9);
    activate(0, 1, 2);
    activate(1, 1, 2);
    activate(2, 1, 4);
    bench.pass(3);
    EXPECT_EQ(seen().torn, 1U); // it lasts
    EXPECT_EQ(seen().whole, 0U);
    bench.pass(3);
    EXPECT_EQ(seen().torn, 1U);
    EXPECT_EQ(seen().longestTear_ns, 2'000'000);
    for (int unit = 0; unit < 2; ++unit)
        write(unit, 0, 10);
    activate(0, 0, 2);
    activate(1, 0, 2);
    bench.pass(3);
    EXPECT_EQ(seen().torn, 2U);
}

TEST_F(EmulatedFieldWatch, fields_that_are_known_are_compared)
{
    bench.chain.watch().expect(1, even(3, 256 - 9, 255));
    bench.chain.watch().expect(2, even(3, 256 - 10, 255));
    for (int unit = 0; unit < 3; ++unit)
        write(unit, 1, unit == 1 ? 10 : 9);
    for (int unit = 0; unit < 3; ++unit)
        activate(unit, 1, 2);
    bench.pass(4);
    EXPECT_EQ(seen().torn, 1U); // all switched, but to different fields
    EXPECT_EQ(seen().numbersPlayed, 0U);
    for (int unit = 0; unit < 3; ++unit)
        write(unit, 0, 10);
    for (int unit = 0; unit < 3; ++unit)
        activate(unit, 0, 2);
    bench.pass(4);
    EXPECT_EQ(seen().torn, 1U);
    EXPECT_EQ(seen().lastNumber, 2U);
    EXPECT_EQ(seen().numbersPlayed, 1U);
    EXPECT_EQ(seen().unknown, 0U);
    for (int unit = 0; unit < 3; ++unit)
        write(unit, 1, 77);
    for (int unit = 0; unit < 3; ++unit)
        activate(unit, 1, 2);
    bench.pass(4);
    EXPECT_EQ(seen().unknown, 3U); // nobody sent that
}

TEST_F(EmulatedFieldWatch, a_switch_that_is_taken_back_tears_nothing)
{
    for (int field = 1; field <= 2; ++field)
    {
        for (int unit = 0; unit < 3; ++unit)
            write(unit, field % 2, field);
        for (int unit = 0; unit < 3; ++unit)
            activate(unit, field % 2, 2);
        bench.pass(3);
    }
    for (int unit = 0; unit < 3; ++unit)
        write(unit, 1, 3);
    activate(0, 1, 4);
    activate(1, 1, 4);
    activate(0, 0, 5); // back
    activate(1, 0, 5);
    bench.pass(10);
    EXPECT_EQ(seen().whole, 2U);
    EXPECT_EQ(seen().torn, 0U);
}

TEST_F(EmulatedFieldWatch, what_is_dark_is_left_out_until_it_plays_again)
{
    bench.chain.happen(ChainFaults::Kind::REBOOT, 2, bench.now_ns);
    bench.chain.happen(ChainFaults::Kind::FAILSAFE, 1, bench.now_ns);
    write(0, 1, 5);
    activate(0, 1, 2);
    bench.pass(3);
    EXPECT_EQ(seen().whole, 1U);
    EXPECT_EQ(seen().torn, 0U);
    EXPECT_EQ(bench.command(1, "06"), 0); // released, and silent beside a unit that plays
    bench.pass(3);
    EXPECT_EQ(seen().torn, 1U);
}

TEST_F(EmulatedFieldWatch, a_write_into_what_plays_is_a_field_that_nobody_sent)
{
    bench.chain.watch().expect(1, even(3, 256 - 9, 255));
    for (int unit = 0; unit < 3; ++unit)
        write(unit, 1, 9);
    for (int unit = 0; unit < 3; ++unit)
        activate(unit, 1, 2);
    bench.pass(4);
    bench.command(1, bench.rawSlot(1, 1, 99, 255));
    bench.pass(4);
    EXPECT_EQ(seen().torn, 1U);
    EXPECT_EQ(seen().unknown, 1U);
    EXPECT_EQ(bench.report().writesIntoSlots, 1U);
}

} // namespace
} // namespace midair::device::emulation
