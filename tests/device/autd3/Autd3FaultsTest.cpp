#include "device/drive/DriveSignal.h"
#include "tests/Eventually.h"
#include "tests/LongTests.h"
#include "tests/device/autd3/Rehearsal.h"

#include <functional>
#include <string>

#include <gtest/gtest.h>

using namespace midair::device;
using namespace midair::device::autd3;
using emulation::ChainFaults;

namespace
{

void streamFields(Rehearsal& rehearsal, int count)
{
    for (int n = 1; n <= count; ++n)
    {
        rehearsal.sendWatched(n);
        ASSERT_TRUE(rehearsal.settles());
    }
}

/// Streams over a cable with \a faults: late, but whole, and the last one plays.
Autd3Device::Figures streamWith(const ChainFaults& faults)
{
    Rehearsal rehearsal(4);
    rehearsal.open();
    rehearsal.setFaults(faults);
    streamFields(rehearsal, 30);
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(30)));
    const emulation::ChainReport report = rehearsal.report();
    // Where this program isn't run for some ms in the wrong moment, it knows and tells.
    EXPECT_LE(report.fields.torn, rehearsal.torn()) << report.fields.longestTear_ns << " ns";
    EXPECT_EQ(report.fields.unknown, 0u);
    EXPECT_EQ(report.writesIntoBanks, 0u);
    EXPECT_EQ(rehearsal.device->report().lost, 0u);
    EXPECT_EQ(rehearsal.device->report().state, DeviceState::READY);
    return rehearsal.figures();
}

std::string whyNotOpened(const std::function<void(Rehearsal&)>& prepare, int units = 2)
{
    Rehearsal rehearsal(units);
    prepare(rehearsal);
    try
    {
        rehearsal.open();
    }
    catch (const DeviceError& error)
    {
        return error.what();
    }
    return "it opened";
}

bool has(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

} // namespace

TEST(Autd3Faults, survives_loss)
{
    ChainFaults faults;
    faults.drop = 0.03;
    EXPECT_GT(streamWith(faults).repeats, 0u);
}

TEST(Autd3Faults, survives_copies)
{
    ChainFaults faults;
    faults.duplicate = 0.3;
    streamWith(faults);
}

TEST(Autd3Faults, survives_a_changed_order)
{
    ChainFaults faults;
    faults.reorder = 0.05;
    faults.jitter_ns = 100'000;
    streamWith(faults);
}

TEST(Autd3Faults, refuses_garbage_and_counts_it)
{
    ChainFaults faults;
    faults.garbage = 0.5;
    EXPECT_GT(streamWith(faults).refusals, 0u);
}

TEST(Autd3Faults, a_lost_answer_to_an_id_is_no_loss)
{
    Rehearsal rehearsal(3);
    rehearsal.chain.faults.lostAssignments = 2;
    rehearsal.open();
    rehearsal.device->send(rehearsal.mixed(1));
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(1)));
}

TEST(Autd3Faults, opens_on_a_bad_network)
{
    Rehearsal rehearsal(3);
    rehearsal.chain.faults.drop = 0.03;
    rehearsal.chain.faults.duplicate = 0.1;
    rehearsal.chain.faults.garbage = 0.1;
    rehearsal.chain.faults.jitter_ns = 200'000;
    rehearsal.open();
    rehearsal.device->send(rehearsal.mixed(1));
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(1)));
}

TEST(Autd3Faults, a_sequence_is_written_whole_over_a_bad_network)
{
    Rehearsal rehearsal(2);
    rehearsal.open();
    ChainFaults faults;
    faults.drop = 0.03;
    faults.duplicate = 0.05;
    faults.reorder = 0.02;
    rehearsal.setFaults(faults);
    DriveSequence sequence;
    sequence.rate_Hz = 40e3 / 1000; // slow enough to see each
    for (int n = 0; n < 100; ++n)
        sequence.signals.push_back(rehearsal.mixed(n));
    ASSERT_TRUE(rehearsal.device->sendSequence(sequence));
    ASSERT_TRUE(rehearsal.settles());
    EXPECT_EQ(rehearsal.device->report().played, 1u);
    // Each slot that is seen is one of the sequence's, on all units.
    int looks = 0;
    int seen = 0;
    EXPECT_TRUE(eventually(
        [&]
        {
            const DriveSignal now = rehearsal.field();
            for (const DriveSignal& signal : sequence.signals)
                if (now.phase == signal.phase && now.duty == signal.duty)
                {
                    ++seen;
                    break;
                }
            return ++looks == 500;
        }));
    EXPECT_GE(seen, 475); // one unit may be seen a period before the other
}

TEST(Autd3Faults, another_number_of_units_is_told)
{
    const auto wants = [](int wanted)
    { return [wanted](Rehearsal& rehearsal) { rehearsal.options = Rehearsal(wanted).options; }; };
    const std::string fewer = whyNotOpened(wants(3));
    EXPECT_TRUE(has(fewer, "2 units") && has(fewer, "units=3")) << fewer;
    const std::string more = whyNotOpened(wants(1));
    EXPECT_TRUE(has(more, "more than 1") && has(more, "units=1")) << more;
}

TEST(Autd3Faults, another_protocol_or_firmware_is_refused_by_its_numbers)
{
    const std::string version =
        whyNotOpened([](Rehearsal& rehearsal) { rehearsal.chain.protocolVersion = 3; });
    EXPECT_TRUE(has(version, "version 3") && has(version, "speaks 2")) << version;
    const std::string cpu =
        whyNotOpened([](Rehearsal& rehearsal) { rehearsal.chain.firmware[1] = 9; });
    EXPECT_TRUE(has(cpu, "0.9.0") && has(cpu, "0.10")) << cpu;
    const std::string fpga =
        whyNotOpened([](Rehearsal& rehearsal) { rehearsal.chain.gateware[1] = 11; });
    EXPECT_TRUE(has(fpga, "0.10.0 (CPU)") && has(fpga, "0.11.0 (FPGA)")) << fpga;
}

TEST(Autd3Faults, nobody_is_told)
{
    ChainFaults::Event unplugged;
    unplugged.kind = ChainFaults::Kind::UNPLUG;
    const std::string why =
        whyNotOpened([&](Rehearsal& rehearsal) { rehearsal.chain.faults.events = {unplugged}; });
    EXPECT_TRUE(has(why, "answers on")) << why;
}

TEST(Autd3Faults, a_unit_that_starts_anew_silences_all_until_the_next_field)
{
    Rehearsal rehearsal(3);
    rehearsal.open();
    rehearsal.device->send(rehearsal.mixed(1));
    ASSERT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(1)));
    rehearsal.happen(ChainFaults::Kind::REBOOT, 1);
    ASSERT_TRUE(eventually([&] { return rehearsal.device->report().state == DeviceState::LOST; }));
    EXPECT_TRUE(has(rehearsal.device->report().message, "unit 1"))
        << rehearsal.device->report().message;
    EXPECT_FALSE(rehearsal.device->send(rehearsal.mixed(2)));
    ASSERT_TRUE(eventually([&] { return rehearsal.isSilent(); }));
    ASSERT_TRUE(eventually([&] { return rehearsal.device->report().state == DeviceState::READY; }));
    EXPECT_EQ(rehearsal.device->report().reconnects, 1u);
    EXPECT_TRUE(rehearsal.isSilent());
    rehearsal.device->send(rehearsal.mixed(3));
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(3)));
}

TEST(Autd3Faults, the_others_play_on_where_that_is_asked_for)
{
    Rehearsal rehearsal(3);
    rehearsal.options.whenLost = WhenLost::ONE_IS_MISSED;
    rehearsal.open();
    rehearsal.device->send(rehearsal.mixed(1));
    ASSERT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(1)));
    rehearsal.happen(ChainFaults::Kind::REBOOT, 2);
    ASSERT_TRUE(eventually([&] { return !rehearsal.device->report().complaint.empty(); }));
    EXPECT_TRUE(has(rehearsal.device->report().complaint, "unit 2"));
    EXPECT_EQ(rehearsal.device->report().state, DeviceState::READY);
    ASSERT_TRUE(rehearsal.device->send(rehearsal.mixed(2)));
    DriveSignal wanted = rehearsal.mixed(2);
    EXPECT_TRUE(eventually(
        [&]
        {
            const DriveSignal now = rehearsal.field();
            return std::equal(now.duty.begin(), now.duty.begin() + 498, wanted.duty.begin()) &&
                   std::equal(now.phase.begin(), now.phase.begin() + 498, wanted.phase.begin());
        }));
}

TEST(Autd3Faults, a_failsafe_that_tripped_is_found_and_released)
{
    Rehearsal rehearsal(3);
    rehearsal.open();
    rehearsal.device->send(rehearsal.mixed(1));
    ASSERT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(1)));
    rehearsal.happen(ChainFaults::Kind::FAILSAFE, 2);
    ASSERT_TRUE(eventually([&] { return rehearsal.device->report().faults > 0; }));
    EXPECT_TRUE(has(rehearsal.device->report().message, "unit 2"));
    EXPECT_TRUE(has(rehearsal.device->report().message, "fail-safe"));
    EXPECT_EQ(rehearsal.device->report().silences, 1u);
    ASSERT_TRUE(eventually([&] { return rehearsal.isSilent(); }));
    rehearsal.device->send(rehearsal.mixed(2));
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(2)));
    EXPECT_EQ(rehearsal.report().writesIntoBanks, 0u);
}

TEST(Autd3Faults, silence_comes_by_itself_when_nothing_gets_through)
{
    Rehearsal rehearsal(2);
    rehearsal.open();
    rehearsal.device->send(rehearsal.mixed(1));
    ASSERT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(1)));
    rehearsal.happen(ChainFaults::Kind::UNPLUG);
    EXPECT_TRUE(eventually([&] { return rehearsal.isSilent(); }));
    EXPECT_TRUE(eventually([&] { return rehearsal.device->report().state == DeviceState::LOST; }));
    rehearsal.happen(ChainFaults::Kind::REPLUG);
    ASSERT_TRUE(eventually([&] { return rehearsal.device->report().state == DeviceState::READY; }));
    EXPECT_TRUE(rehearsal.isSilent());
    rehearsal.device->send(rehearsal.mixed(2));
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(2)));
}

TEST(Autd3Faults, a_field_that_a_unit_refuses_is_played_by_none)
{
    Rehearsal rehearsal(3);
    rehearsal.open();
    int n = 1;
    rehearsal.device->send(rehearsal.mixed(n));
    ASSERT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(n)));
    while (rehearsal.device->report().lost == 0 && n < 20) // a question for its state may fail, too
    {
        rehearsal.with(
            [](Rehearsal::Chain& chain, Rehearsal::Time_ns)
            {
                chain.failCommands(1, 0x07, 1);
                return 0;
            });
        rehearsal.device->send(rehearsal.mixed(++n));
        ASSERT_TRUE(rehearsal.settles());
    }
    const DeviceReport report = rehearsal.device->report();
    EXPECT_EQ(report.lost, 1u);
    EXPECT_TRUE(has(report.message, "unit 1") && has(report.message, "07")) << report.message;
    EXPECT_TRUE(rehearsal.plays(rehearsal.mixed(n - 1)));
    rehearsal.device->send(rehearsal.mixed(99));
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(99)));
    EXPECT_LE(rehearsal.report().fields.torn, rehearsal.torn());
}

TEST(Autd3Faults, a_unit_that_comes_back_is_taken_up)
{
    if (!longTestsAsked()) GTEST_SKIP() << "10 s; with --long";
    Rehearsal rehearsal(2);
    rehearsal.options.whenLost = WhenLost::ONE_IS_MISSED;
    rehearsal.open();
    const auto reconnects = [&] { return rehearsal.device->report().reconnects; };
    rehearsal.happen(ChainFaults::Kind::REBOOT, 1);
    // Not sooner than 10 s after it was opened.
    ASSERT_TRUE(eventually([&] { return reconnects() == 1; }));
    rehearsal.device->send(rehearsal.mixed(1));
    EXPECT_TRUE(rehearsal.eventuallyPlays(rehearsal.mixed(1)));
    EXPECT_TRUE(rehearsal.device->report().complaint.empty());
}

TEST(Autd3Faults, a_clock_that_is_lost_is_told)
{
    Rehearsal rehearsal(2);
    rehearsal.open();
    rehearsal.happen(ChainFaults::Kind::SYNC_LOST, 1);
    EXPECT_TRUE(eventually([&] { return has(rehearsal.device->report().complaint, "unit 1"); }));
}
