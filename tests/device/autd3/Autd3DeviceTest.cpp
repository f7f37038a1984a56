#include "device/drive/DriveEncoder.h"
#include "device/drive/DriveSignal.h"
#include "tests/Eventually.h"
#include "tests/device/autd3/Rehearsal.h"

#include <algorithm>
#include <complex>

#include <gtest/gtest.h>

using namespace midair::device;
using namespace midair::device::autd3;
using emulation::ChainFaults;

namespace
{

std::uint64_t settled(const DeviceReport& report)
{
    return report.played + report.dropped + report.lost + report.refused + report.pending;
}

/// Sends \a count fields, \a atOnce of them once those before are settled.
void stream(Rehearsal& rehearsal, int count, int atOnce = 1)
{
    for (int n = 1; n <= count; ++n)
    {
        ASSERT_TRUE(rehearsal.sendWatched(n));
        ASSERT_TRUE(n % atOnce != 0 || rehearsal.settles());
    }
    ASSERT_TRUE(rehearsal.settles());
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(count)));
}

auto output(Rehearsal& rehearsal)
{
    return rehearsal.with([](Rehearsal::Chain& chain, Rehearsal::Time_ns now_ns)
                          { return chain.output(now_ns); });
}

void expectSafe(Rehearsal& rehearsal)
{
    const emulation::ChainReport report = rehearsal.report();
    EXPECT_EQ(report.writesIntoBanks, 0u) << "a write into the bank that plays";
    EXPECT_EQ(report.writesIntoSlots, 0u);
    EXPECT_EQ(report.updateCommands, 0u);
    // Where this program isn't run for some ms in the wrong moment, it knows and tells.
    EXPECT_LE(report.fields.torn, rehearsal.torn()) << report.fields.longestTear_ns << " ns";
    EXPECT_EQ(report.fields.unknown, 0u);
    const DeviceReport device = rehearsal.device->report();
    EXPECT_EQ(device.sent, settled(device));
}

} // namespace

TEST(Autd3Device, is_silent_until_a_field_comes)
{
    Rehearsal rehearsal(2);
    rehearsal.open();
    EXPECT_TRUE(rehearsal.isSilent());
    EXPECT_EQ(rehearsal.device->report().state, DeviceState::READY);
    EXPECT_EQ(rehearsal.device->report().firmware, "0.10.0");
    expectSafe(rehearsal);
}

TEST(Autd3Device, plays_what_it_is_sent_and_says_so)
{
    Rehearsal rehearsal(3);
    rehearsal.open();
    const DriveSignal signal = rehearsal.mixed(5);
    ASSERT_TRUE(rehearsal.device->send(signal));
    ASSERT_TRUE(rehearsal.eventuallyPlays(signal));
    ASSERT_TRUE(rehearsal.settles());
    EXPECT_EQ(rehearsal.device->report().played, 1u);
    std::vector<std::complex<float>> q;
    decode(signal, q);
    EXPECT_EQ(rehearsal.device->played(), q);
    expectSafe(rehearsal);
}

// What leaves the transducers is what the drive means, though units take phases as delays.
TEST(Autd3Device, puts_out_what_the_drive_means)
{
    Rehearsal rehearsal(2);
    rehearsal.open();
    const DriveSignal signal = rehearsal.mixed(5);
    rehearsal.device->send(signal);
    ASSERT_TRUE(rehearsal.eventuallyPlays(signal));
    std::vector<std::complex<float>> q;
    decode(signal, q);
    ASSERT_EQ(output(rehearsal).size(), q.size());
    EXPECT_TRUE(eventually( // the silencer glides
        [&]
        {
            const auto out = output(rehearsal);
            bool isMeant = true;
            for (std::size_t i = 0; i < q.size(); ++i)
                isMeant = isMeant && std::abs(out[i] - q[i]) < 3.2e-3;
            return isMeant;
        }));
}

TEST(Autd3Device, boards_are_in_the_order_that_is_named)
{
    Rehearsal rehearsal(3);
    rehearsal.options.order = {2, 0, 1};
    rehearsal.open();
    DriveSignal signal = rehearsal.mixed(1);
    rehearsal.device->send(signal);
    DriveSignal wanted = signal;
    for (std::size_t unit = 0; unit < 3; ++unit)
        for (std::size_t k = 0; k < 249; ++k)
        {
            const auto board = static_cast<std::size_t>(rehearsal.options.order[unit]);
            wanted.phase[unit * 249 + k] = signal.phase[board * 249 + k];
            wanted.duty[unit * 249 + k] = signal.duty[board * 249 + k];
        }
    EXPECT_TRUE(rehearsal.eventuallyPlays(wanted));
}

TEST(Autd3Device, fields_change_on_all_units_together)
{
    Rehearsal rehearsal(4);
    rehearsal.open();
    stream(rehearsal, 30);
    EXPECT_EQ(rehearsal.device->report().played, 30u);
    expectSafe(rehearsal);
}

TEST(Autd3Device, the_newest_wins)
{
    Rehearsal rehearsal(4);
    rehearsal.open();
    stream(rehearsal, 200, 10);
    const DeviceReport report = rehearsal.device->report();
    EXPECT_GT(report.dropped, 0u);
    EXPECT_GT(report.played, 10u);
    EXPECT_EQ(report.lost, 0u);
    expectSafe(rehearsal);
}

TEST(Autd3Device, switches_at_once_where_that_is_asked_for)
{
    Rehearsal rehearsal(2);
    rehearsal.options.timed = false;
    rehearsal.chain.tolerance_ns = 1'000'000'000; // apart by what this program was not run
    rehearsal.open();
    stream(rehearsal, 30);
    EXPECT_EQ(rehearsal.device->report().played, 30u);
    expectSafe(rehearsal);
}

// As samples/guides/AUTD3.md says.
TEST(Autd3Device, says_how_many_fields_its_cable_carries)
{
    Rehearsal timed(16);
    timed.options.lead_s = 3e-3;
    timed.open();
    EXPECT_NEAR(timed.device->ability().fieldsPerSecond, 221, 1);
    EXPECT_TRUE(timed.device->ability().part.empty());
    Rehearsal atOnce(16);
    atOnce.options.timed = false;
    atOnce.options.whenLost = WhenLost::ONE_IS_MISSED;
    atOnce.open();
    EXPECT_NEAR(atOnce.device->ability().fieldsPerSecond, 840, 2);
    EXPECT_EQ(atOnce.device->ability().part[3 * 249], 3); // each may be lost by itself
}

TEST(Autd3Device, masks_transducers)
{
    Rehearsal rehearsal(2);
    rehearsal.options.silent = {{17}, {0, 248}};
    rehearsal.open();
    rehearsal.device->send(rehearsal.even(9));
    ASSERT_TRUE(rehearsal.settles());
    const std::complex<float> silent;
    auto out = output(rehearsal);
    EXPECT_TRUE(eventually( // the silencer glides
        [&]
        {
            out = output(rehearsal);
            return std::count(out.begin(), out.end(), silent) <= 3;
        }));
    for (std::size_t i = 0; i < out.size(); ++i)
        EXPECT_EQ(std::abs(out[i]) == 0, i == 17 || i == 249 || i == 249 + 248) << i;
}

TEST(Autd3Device, falls_silent_at_once_and_plays_the_next_field)
{
    Rehearsal rehearsal(3);
    rehearsal.open();
    for (int n = 1; n <= 5; ++n)
    {
        rehearsal.device->send(rehearsal.mixed(n));
        ASSERT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(n)));
        rehearsal.device->silence();
        ASSERT_TRUE(eventually([&] { return rehearsal.isSilent(); }));
        const auto played = rehearsal.device->played();
        EXPECT_EQ(played, std::vector<std::complex<float>>(played.size()));
    }
    rehearsal.device->send(rehearsal.mixed(9));
    rehearsal.device->silence();
    rehearsal.device->send(rehearsal.mixed(10));
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(10)));
    expectSafe(rehearsal);
}

// However a silence meets the writing and switching of fields: the last word counts.
TEST(Autd3Device, silences_in_the_middle_of_everything)
{
    Rehearsal rehearsal(3);
    rehearsal.open();
    for (int n = 1; n <= 60; ++n)
    {
        rehearsal.device->send(rehearsal.mixed(n));
        letPass(137e-6 * (n % 40));
        rehearsal.device->silence();
        if (n % 3 == 0) rehearsal.device->silence();
    }
    EXPECT_TRUE(eventually([&] { return rehearsal.isSilent(); }));
    ASSERT_TRUE(rehearsal.settles());
    EXPECT_TRUE(rehearsal.hears(20));
    EXPECT_TRUE(rehearsal.isSilent());
    rehearsal.device->send(rehearsal.mixed(99));
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(99)));
    expectSafe(rehearsal);
}

TEST(Autd3Device, closing_is_silent)
{
    Rehearsal rehearsal(3);
    rehearsal.open();
    rehearsal.device->send(rehearsal.mixed(1));
    ASSERT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(1)));
    rehearsal.device.reset();
    EXPECT_TRUE(rehearsal.isSilent());
}

TEST(Autd3Device, refuses_a_field_of_another_length)
{
    Rehearsal rehearsal(1);
    rehearsal.open();
    EXPECT_FALSE(rehearsal.device->send(silentSignal(248)));
    EXPECT_EQ(rehearsal.device->report().refused, 1u);
}

TEST(Autd3Device, plays_a_sequence_on_board)
{
    Rehearsal rehearsal(2);
    rehearsal.options.heartbeat_s = 10e-3;
    rehearsal.open();
    DriveSequence sequence;
    sequence.rate_Hz = 1000;
    for (int n = 0; n < 37; ++n) // some with one intensity, some not
        sequence.signals.push_back(n % 4 == 3 ? rehearsal.mixed(n) : rehearsal.even(5 * n));
    ASSERT_TRUE(rehearsal.device->sendSequence(sequence));
    ASSERT_TRUE(rehearsal.settles());
    EXPECT_EQ(rehearsal.device->report().played, 1u);
    const std::uint64_t before = rehearsal.report().fromHost;
    std::vector<bool> seen(sequence.signals.size());
    const bool all = eventually(
        [&]
        {
            const DriveSignal now = rehearsal.field();
            for (std::size_t n = 0; n < seen.size(); ++n)
                if (now.phase == sequence.signals[n].phase && now.duty == sequence.signals[n].duty)
                    seen[n] = true;
            return std::find(seen.begin(), seen.end(), false) == seen.end();
        });
    EXPECT_TRUE(all);
    EXPECT_LT(rehearsal.report().fromHost - before, 3000u); // no fields, which are 1000 a second
    // A field takes its place, and a sequence that of a field.
    rehearsal.device->send(rehearsal.mixed(99));
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(99)));
    ASSERT_TRUE(rehearsal.device->sendSequence(sequence));
    EXPECT_TRUE(rehearsal.eventuallyPlays(sequence.signals[36]));
    rehearsal.device->silence();
    EXPECT_TRUE(eventually([&] { return rehearsal.isSilent(); }));
    EXPECT_EQ(rehearsal.report().writesIntoBanks, 0u);
}

TEST(Autd3Device, fills_a_bank)
{
    Rehearsal rehearsal(1);
    rehearsal.open();
    DriveSequence sequence;
    sequence.rate_Hz = 40e3;
    for (int n = 0; n < kMostSlots; ++n)
        sequence.signals.push_back(rehearsal.mixed(n));
    ASSERT_EQ(rehearsal.device->ability().sequenceFields, kMostSlots);
    ASSERT_TRUE(rehearsal.device->sendSequence(sequence));
    EXPECT_TRUE(rehearsal.settles());
    EXPECT_EQ(rehearsal.device->report().played, 1u);
    sequence.signals.push_back(rehearsal.mixed(0));
    EXPECT_FALSE(rehearsal.device->sendSequence(sequence));
    EXPECT_EQ(rehearsal.report().writesIntoBanks, 0u);
}

TEST(Autd3Device, a_field_is_played_before_a_sequence_that_is_not_there_yet)
{
    Rehearsal rehearsal(2);
    rehearsal.chain.wirePerByte_ns = 80;
    rehearsal.open();
    DriveSequence sequence;
    for (int n = 0; n < kMostSlots; ++n)
        sequence.signals.push_back(rehearsal.mixed(n));
    // Again, as a thread that sleeps long enough sees the sequence written before its field is
    // sent.
    for (int n = 0; n < 10 && rehearsal.device->report().dropped == 0; ++n)
    {
        ASSERT_TRUE(rehearsal.device->sendSequence(sequence));
        ASSERT_TRUE(rehearsal.hears(10)); // it is being written
        ASSERT_TRUE(rehearsal.device->send(rehearsal.even(7)));
        ASSERT_TRUE(rehearsal.eventuallyPlays(rehearsal.even(7)));
        ASSERT_TRUE(rehearsal.settles());
    }
    EXPECT_EQ(rehearsal.device->report().dropped, 1u);
    expectSafe(rehearsal);
}

TEST(Autd3Device, takes_no_rate_that_the_units_clock_has_not)
{
    Rehearsal rehearsal(1);
    rehearsal.open();
    DriveSequence sequence;
    sequence.signals = {rehearsal.even(1), rehearsal.even(2)};
    for (const double rate_Hz : {300.0, 999.0, 0.5, 30e3})
    {
        sequence.rate_Hz = rate_Hz;
        EXPECT_FALSE(rehearsal.device->sendSequence(sequence)) << rate_Hz;
    }
    for (const double rate_Hz : {40e3, 20e3, 1000.0, 40.0, 40e3 / 3, 40e3 / 65535})
    {
        sequence.rate_Hz = rate_Hz;
        EXPECT_TRUE(rehearsal.device->sendSequence(sequence)) << rate_Hz;
    }
    EXPECT_EQ(rehearsal.device->ability().sequenceClock_Hz, 40e3);
}
