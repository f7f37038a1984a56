// What plays when: banks, slots, rounds, switches, and what the transducers put out of it.

#include "haptics/base/DutyLaw.h"
#include "haptics/base/Units.h"
#include "tests/device/autd3/emulator/UnitBench.h"

#include <cmath>
#include <complex>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace midair::device::emulation
{
namespace
{

class EmulatedUnitPlaying : public ::testing::Test
{
protected:
    EmulatedUnitPlaying()
    {
        bench.open();
        bench.command(0, UnitBench::cpuConfig(1'000'000, 0));
        bench.command(0, widths());
    }

    static std::string widths()
    {
        std::string text = "42";
        for (int duty = 0; duty < 256; ++duty)
        {
            const int width = (512 * duty + 255) / 510;
            text += fmt::format(" {:02X} {:02X}", width & 255, width >> 8);
        }
        return text;
    }

    Time_ns unitTime() const { return bench.chain.unit(0).clock().at(bench.now_ns); }
    /// Lets time pass until the unit's clock reads \a time_ns.
    void passUntil(Time_ns time_ns) { bench.pass(double(time_ns - unitTime()) / 1e6); }
    int duty() { return bench.chain.field(bench.now_ns).duty[100]; }
    std::complex<float> output(int i = 100) { return bench.chain.output(bench.now_ns)[i]; }

    UnitBench bench;
};

// Slots 0, 1, 2 .. of a bank have intensities first, first + 1, ..
void fill(UnitBench& bench, int bank, int slots, int first)
{
    for (int slot = 0; slot < slots; ++slot)
        ASSERT_EQ(bench.command(0, bench.rawSlot(bank, slot, 0, first + slot)), 0);
}

TEST_F(EmulatedUnitPlaying, for_ever_slots_are_counted_from_time_0)
{
    fill(bench, 1, 3, 11);
    bench.command(0, bench.patternConfig(1, 4, 3, 0)); // 0.1 ms each
    EXPECT_EQ(bench.command(0, bench.activation(1, 0xFF)), 0);
    const Time_ns grid_ns = (unitTime() / 300'000 + 5) * 300'000;
    for (int slot = 0; slot < 7; ++slot)
    {
        passUntil(grid_ns + slot * 100'000 + 1'000);
        EXPECT_EQ(duty(), 11 + slot % 3) << slot;
        passUntil(grid_ns + slot * 100'000 + 99'000);
        EXPECT_EQ(duty(), 11 + slot % 3) << slot;
    }
    EXPECT_EQ(bench.state(0), 0x04U);
}

TEST_F(EmulatedUnitPlaying, rounds_begin_at_slot_0_and_the_last_slot_stands)
{
    fill(bench, 1, 3, 11);
    bench.command(0, bench.patternConfig(1, 4, 3, 2));
    const Time_ns start_ns = (unitTime() / 100'000 + 50) * 100'000 + 62'500;
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, std::uint64_t(start_ns + 3'000))), 0);
    passUntil(start_ns - 1'000); // cut to 3125 ns, so no later than start_ns
    EXPECT_EQ(duty(), 0);
    EXPECT_EQ(bench.state(0), 0x48U);
    passUntil(start_ns + 1);
    EXPECT_EQ(duty(), 11);
    // The first slot is cut short where the grid goes on.
    const int played[] = {12, 13, 11, 12, 13, 13, 13};
    for (int i = 0; i < 7; ++i)
    {
        passUntil(start_ns + 37'500 + i * 100'000 + 1'000);
        EXPECT_EQ(duty(), played[i]) << i;
    }
    EXPECT_EQ(bench.state(0), 0x14U);
    bench.pass(50'000);
    EXPECT_EQ(duty(), 13);
}

TEST_F(EmulatedUnitPlaying, by_index_a_bank_begins_when_its_slot_becomes_0)
{
    fill(bench, 1, 4, 21);
    bench.command(0, bench.patternConfig(1, 4, 4, 1));
    passUntil((unitTime() / 400'000 + 1) * 400'000 + 50'000);
    const Time_ns next_ns = (unitTime() / 400'000 + 1) * 400'000;
    EXPECT_EQ(bench.command(0, bench.activation(1, 0)), 0);
    passUntil(next_ns - 1'000);
    EXPECT_EQ(duty(), 0);
    passUntil(next_ns + 1'000);
    EXPECT_EQ(duty(), 21);
}

TEST_F(EmulatedUnitPlaying, a_switch_that_waits_cannot_be_moved_but_taken_back)
{
    fill(bench, 0, 2, 31);
    fill(bench, 1, 2, 41);
    bench.command(0, bench.patternConfig(0, 1, 2, 1));
    bench.command(0, bench.patternConfig(1, 1, 2, 1));
    const auto at = [this](double ms) { return std::uint64_t(unitTime() + Time_ns(ms * 1e6)); };
    EXPECT_EQ(bench.command(0, bench.activation(0, 1, at(2))), 0); // bank 0 plays: nothing happens
    EXPECT_EQ(bench.state(0) & 0x40U, 0U);
    const Time_ns first_ns = unitTime() + 5'000'000;
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, std::uint64_t(first_ns))), 0);
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, at(50))), 0); // done, and nothing happens
    passUntil(first_ns - 10'000);
    EXPECT_EQ(bench.state(0) & 0x44U, 0x40U);
    passUntil(first_ns + 10'000);
    EXPECT_EQ(bench.state(0) & 0x44U, 0x04U);
    EXPECT_EQ(duty(), 41);

    EXPECT_EQ(bench.command(0, bench.activation(0, 1, at(5))), 0);
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, at(7))), 0); // bank 1 plays again
    bench.pass(30);
    EXPECT_EQ(bench.state(0), 0x14U);
    EXPECT_EQ(duty(), 42);
}

TEST_F(EmulatedUnitPlaying, an_activation_at_once_ends_a_wait)
{
    fill(bench, 0, 1, 31);
    fill(bench, 1, 2, 41);
    bench.command(0, bench.patternConfig(0, 1, 1, 0));
    bench.command(0, bench.patternConfig(1, 1, 2, 1));
    EXPECT_EQ(bench.command(0, bench.activation(1, 1, std::uint64_t(unitTime() + 3'000'000))), 0);
    EXPECT_EQ(bench.command(0, bench.activation(0, 0xFF)), 0);
    bench.pass(10);
    EXPECT_EQ(bench.state(0), 0x08U);
    EXPECT_EQ(duty(), 31);
}

TEST_F(EmulatedUnitPlaying, registers_become_valid_with_any_activation_of_either_bank)
{
    fill(bench, 0, 2, 31);
    bench.command(0, bench.patternConfig(0, 1, 2, 0));
    EXPECT_EQ(bench.state(0), 0x08U); // written, not valid
    fill(bench, 1, 2, 41);
    bench.command(0, bench.patternConfig(1, 1, 2, 1));
    bench.command(0, bench.activation(1, 1, std::uint64_t(unitTime() + 9'000'000)));
    EXPECT_EQ(bench.state(0), 0x40U); // bank 0 plays, with two slots
}

TEST_F(EmulatedUnitPlaying, writes_into_what_plays_or_waits_are_counted)
{
    fill(bench, 0, 1, 31); // the slot that plays after Clear
    EXPECT_EQ(bench.report().writesIntoBanks, 1U);
    EXPECT_EQ(bench.report().writesIntoSlots, 1U);
    fill(bench, 1, 2, 41);
    EXPECT_EQ(bench.report().writesIntoBanks, 1U);
    bench.command(0, bench.patternConfig(1, 1, 2, 1));
    bench.command(0, bench.activation(1, 1, std::uint64_t(unitTime() + 3'000'000)));
    fill(bench, 1, 1, 50); // waits
    EXPECT_EQ(bench.report().writesIntoBanks, 2U);
    EXPECT_EQ(bench.report().writesIntoSlots, 1U);
    bench.pass(5);
    fill(bench, 1, 1, 51); // its last slot stands, this is the first
    EXPECT_EQ(bench.report().writesIntoBanks, 3U);
    EXPECT_EQ(bench.report().writesIntoSlots, 1U);
    fill(bench, 0, 1, 51); // idle by now
    EXPECT_EQ(bench.report().writesIntoBanks, 3U);
}

TEST_F(EmulatedUnitPlaying, four_bit_phases_are_two_in_a_byte_and_17_levels_apart)
{
    EXPECT_EQ(bench.command(0, "13 01 04 01 C8 00 00 F1*125"), 0);
    bench.command(0, bench.patternConfig(1, 1, 1, 0));
    bench.command(0, bench.activation(1, 0xFF));
    bench.pass(1);
    const DriveSignal field = bench.chain.field(bench.now_ns);
    EXPECT_EQ(field.phase[0], 256 - 17); // the low half; a delay there is an advance here
    EXPECT_EQ(field.phase[1], 256 - 255);
    EXPECT_EQ(field.phase[248], 256 - 17);
    EXPECT_EQ(field.duty[248], 200);
}

TEST_F(EmulatedUnitPlaying, our_duties_pass_one_to_one_by_our_widths)
{
    for (const int level : {0, 1, 100, 254, 255})
    {
        bench.command(0, bench.rawSlot(0, 0, 64, level));
        bench.pass(1);
        EXPECT_EQ(duty(), level);
        // The width is rounded to 1/512 of the period.
        EXPECT_NEAR(std::abs(output()), base::dutyAmplitude(level), base::kPi / 1024 + 1e-6);
        if (level > 0)
        {
            EXPECT_NEAR(std::arg(output()), -base::kPi / 2, 1e-6);
        }
    }
}

TEST_F(EmulatedUnitPlaying, by_the_default_widths_pressure_goes_with_intensity)
{
    bench.command(0, "03");
    bench.command(0, "30 00 00 00 01 00 01 01 00 01 00");
    for (const int level : {0, 17, 128, 255})
    {
        bench.command(0, bench.rawSlot(0, 0, 0, level));
        bench.pass(1);
        EXPECT_NEAR(std::abs(output()), level / 255.0, base::kPi / 1024 + 1e-6) << level;
    }
}

TEST_F(EmulatedUnitPlaying, correction_is_added_and_the_mask_silences)
{
    bench.command(0, bench.rawSlot(0, 0, 200, 255));
    bench.command(0, "40 60*249"); // 96
    bench.command(0, "41 FF*12 EF FF*19");
    bench.pass(1);
    const DriveSignal field = bench.chain.field(bench.now_ns);
    EXPECT_EQ(field.phase[0], (256 - (200 + 96) % 256) % 256);
    EXPECT_EQ(field.duty[100], 0); // bit 4 of byte 12
    EXPECT_EQ(field.duty[99], 255);
    EXPECT_LT(std::abs(output(100)), 1e-6F);
    EXPECT_GT(std::abs(output(99)), 0.99F);
}

TEST_F(EmulatedUnitPlaying, the_silencer_glides_in_steps_the_short_way_round)
{
    bench.command(0, bench.rawSlot(0, 0, 250, 200));
    bench.pass(5);
    EXPECT_EQ(bench.command(0, "30 00 00 00 01 00 01 14 00 28 00"), 0); // 20 and 40 periods
    passUntil((unitTime() / kPeriod_ns + 1) * kPeriod_ns);
    bench.command(0, bench.rawSlot(0, 0, 14, 100));
    const auto level = [&](std::complex<float> q)
    { return std::fmod(-std::arg(q) / base::kTwoPi * 256 + 256, 256); };
    for (int periods = 0; periods <= 44; periods += 4)
    {
        const double phase = std::fmod(250 + 20.0 * std::min(periods, 40) / 40, 256);
        const double intensity = 200 - 100.0 * std::min(periods, 20) / 20;
        EXPECT_NEAR(level(output()), phase, 0.51) << periods;
        EXPECT_NEAR(std::abs(output()), base::dutyAmplitude(intensity), 0.01) << periods;
        bench.pass(0.1);
    }
}

TEST_F(EmulatedUnitPlaying, the_silencer_glides_by_rate)
{
    EXPECT_EQ(bench.command(0, "30 01 00 00 02 80 00 01 00 01 00"), 0); // 2 and 1/2 level a period
    passUntil((unitTime() / kPeriod_ns + 1) * kPeriod_ns);
    bench.command(0, bench.rawSlot(0, 0, 10, 200));
    bench.pass(0.25); // 10 periods
    EXPECT_NEAR(std::abs(output()), base::dutyAmplitude(20), 0.01);
    EXPECT_NEAR(std::arg(output()), -base::kTwoPi * 5 / 256, 0.03);
}

TEST_F(EmulatedUnitPlaying, the_modulation_multiplies_intensities)
{
    bench.command(0, bench.rawSlot(0, 0, 0, 200));
    bench.command(0, "20 01 00 00 00 00 00 FF 80 00 80");
    bench.command(0, "21 01 00 28 00 04 00 00 00 FF FF"); // 1 ms each
    EXPECT_EQ(bench.command(0, "22 01 FF 00*8"), 0);
    passUntil((unitTime() / 4'000'000 + 1) * 4'000'000);
    for (const int sample : {255, 128, 0, 128, 255})
    {
        bench.pass(0.5);
        EXPECT_NEAR(std::abs(output()), base::dutyAmplitude(200 * sample / 255.0), 0.01) << sample;
        bench.pass(0.5);
    }
    EXPECT_EQ(bench.state(0) & 0x02U, 0x02U);
    EXPECT_EQ(duty(), 200); // the field is what it was
}

// Fields of fifteen minutes are not rendered one by one: the last ones are.
TEST_F(EmulatedUnitPlaying, a_long_pause_is_rendered_at_once)
{
    fill(bench, 1, 3, 101);
    bench.command(0, bench.patternConfig(1, 1, 3, 0));
    bench.command(0, bench.activation(1, 0xFF));
    bench.pass(900'000);
    EXPECT_NEAR(std::abs(output()), base::dutyAmplitude(duty()), 0.02);
}

} // namespace
} // namespace midair::device::emulation
