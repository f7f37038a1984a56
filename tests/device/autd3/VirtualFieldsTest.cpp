// Fields on sixteen units in virtual time, where a minute of faults takes seconds and each run is
// the same.
#include "tests/device/autd3/VirtualRehearsal.h"

#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

using Plan = VirtualRehearsal::Plan;
using Outcome = VirtualRehearsal::Outcome;

Plan badNetwork(Plan plan)
{
    plan.faults.drop = 0.01;
    plan.faults.duplicate = 0.01;
    plan.faults.reorder = 0.01;
    plan.faults.reorder_ns = 300'000;
    plan.faults.jitter_ns = 50'000;
    return plan;
}

constexpr double kLatencies_s[] = {0, 1e-3, 2e-3, 3e-3, 5e-3}; ///< each way

/// Fields on \a units that are so far away, from the opening on.
Plan farAway(int units, bool isTimed, double latency_s)
{
    Plan plan = VirtualRehearsal::planOf(units, isTimed, 3e-3);
    plan.faults.latency_ns = static_cast<emulation::Time_ns>(latency_s * 1e9);
    plan.chain.faults = plan.faults;
    return plan;
}

std::string nameOf(int units, bool isTimed, double latency_s)
{
    return fmt::format(
        "{} units, {:g} ms, {}", units, latency_s * 1e3, isTimed ? "timed" : "at once");
}

void expectWhole(const Outcome& outcome)
{
    EXPECT_EQ(outcome.units.fields.torn, 0u) << outcome.units.fields.longestTear_ns << " ns";
    EXPECT_EQ(outcome.units.fields.unknown, 0u);
    EXPECT_EQ(outcome.units.writesIntoBanks, 0u);
    EXPECT_EQ(outcome.units.writesIntoSlots, 0u);
    EXPECT_EQ(outcome.device.lost, 0u);
    EXPECT_EQ(outcome.device.sent, outcome.device.played + outcome.device.dropped);
}

} // namespace

TEST(Autd3VirtualFields, six_hundred_a_second_change_on_all_units_together)
{
    Plan plan = VirtualRehearsal::planOf(16, true, 1e-3);
    plan.chain.wirePerByte_ns = plan.chain.perFrame_ns = plan.chain.perWord_ns = 0;
    const Outcome outcome = VirtualRehearsal::play(plan);
    expectWhole(outcome);
    EXPECT_GE(outcome.device.played, 599u);
    EXPECT_LT(outcome.latency_s(0.99), 2e-3);
    EXPECT_EQ(outcome.figures.torn, 0u);
}

TEST(Autd3VirtualFields, on_a_bad_network_fields_are_late_or_left_out_but_whole)
{
    Plan plan = badNetwork(VirtualRehearsal::planOf(16, true, 3e-3));
    plan.duration_s = 5;
    const Outcome outcome = VirtualRehearsal::play(plan);
    expectWhole(outcome);
    EXPECT_GT(outcome.device.played, 300u);
    EXPECT_GT(outcome.figures.repeats, 300u); // else nothing was tried
}

TEST(Autd3VirtualFields, at_once_a_lost_switch_tears_none_as_each_is_sent_twice)
{
    Plan plan = VirtualRehearsal::planOf(16, false, 3e-3);
    plan.chain.wirePerByte_ns = plan.chain.perFrame_ns = plan.chain.perWord_ns = 0;
    plan.faults.drop = 0.01;
    plan.fields_Hz = 1000;
    plan.duration_s = 3;
    const Outcome outcome = VirtualRehearsal::play(plan);
    expectWhole(outcome);
    EXPECT_GT(outcome.device.played, 1500u);
}

TEST(Autd3VirtualFields, what_a_computer_that_pauses_tears_is_told)
{
    Plan plan = VirtualRehearsal::planOf(16, true, 1e-3);
    plan.host.pausesPerSecond = 20;
    plan.host.pause_ns = 4'000'000;
    plan.fields_Hz = 300;
    plan.duration_s = 10;
    const Outcome outcome = VirtualRehearsal::play(plan);
    EXPECT_GT(outcome.units.fields.torn, 0u);
    EXPECT_GE(outcome.figures.torn, outcome.units.fields.torn);
    EXPECT_GE(outcome.device.faults, outcome.figures.torn);
    EXPECT_GT(outcome.device.played, 2000u);
}

TEST(Autd3VirtualFields, units_at_rest_hear_seldom_but_in_time)
{
    for (const double loss : {0.0, 0.05})
    {
        Plan plan = VirtualRehearsal::planOf(16, true, 3e-3);
        plan.faults.drop = loss;
        plan.fields_Hz = 0.5;
        plan.duration_s = 20;
        const Outcome outcome = VirtualRehearsal::play(plan);
        EXPECT_EQ(outcome.device.silences, 0u) << "a fail-safe tripped";
        EXPECT_EQ(outcome.device.faults, 0u) << outcome.device.message;
        EXPECT_EQ(outcome.device.played, 10u);
        const double eachSecond = static_cast<double>(outcome.units.fromHost) / 20 / 16;
        EXPECT_GT(eachSecond, 28);
        EXPECT_LT(eachSecond, 45 + 100 * loss); // 100 at 10 ms
    }
}

TEST(Autd3VirtualFields, are_the_same_each_time)
{
    Plan plan = badNetwork(VirtualRehearsal::planOf(3, true, 1e-3));
    plan.host.pausesPerSecond = 5;
    plan.host.pause_ns = 2'000'000;
    const Outcome first = VirtualRehearsal::play(plan);
    const Outcome second = VirtualRehearsal::play(plan);
    EXPECT_EQ(first.device.played, second.device.played);
    EXPECT_EQ(first.device.dropped, second.device.dropped);
    EXPECT_EQ(first.figures.takenBack, second.figures.takenBack);
    EXPECT_EQ(first.latencies_s, second.latencies_s);
}

// Heartbeats are sent again after 5 ms; each answer then belongs to one before the last.
TEST(Autd3VirtualFields, units_whose_answers_take_long_are_not_lost)
{
    Plan plan = VirtualRehearsal::planOf(2, true, 60e-3);
    plan.faults.latency_ns = 12'000'000;
    plan.fields_Hz = 1;
    plan.duration_s = 10;
    const Outcome outcome = VirtualRehearsal::play(plan);
    EXPECT_EQ(outcome.device.faults, 0u) << outcome.device.message;
    EXPECT_EQ(outcome.device.reconnects, 0u);
    EXPECT_EQ(outcome.figures.refusals, 0u);
}

/// By the time that a datagram takes, s.
class Autd3FarAway : public testing::TestWithParam<double>
{
};

// With the lead as it is by default: what the way takes comes on top by itself.
TEST_P(Autd3FarAway, far_units_play_whole_fields_and_none_is_lost)
{
    const double latency_s = GetParam();
    for (const int units : {1, 2, 16})
        for (const bool isTimed : {true, false})
            for (const double fields_Hz : {0.3, 200.0})
            {
                SCOPED_TRACE(nameOf(units, isTimed, latency_s));
                Plan plan = farAway(units, isTimed, latency_s);
                plan.fields_Hz = fields_Hz;
                plan.duration_s = fields_Hz < 1 ? 7 : 1.5;
                const Outcome outcome = VirtualRehearsal::play(plan);
                expectWhole(outcome);
                EXPECT_EQ(outcome.device.reconnects, 0u) << outcome.device.message;
                EXPECT_EQ(outcome.device.faults, 0u) << outcome.device.message;
                EXPECT_EQ(outcome.device.silences, 0u) << "a fail-safe tripped";
                EXPECT_EQ(outcome.figures.takenBack, 0u);
                EXPECT_EQ(outcome.figures.refusals, 0u);
                EXPECT_EQ(outcome.figures.torn, 0u);
                // Written, there and back; then told, three ways and the lead ahead.
                const double each_s = 6 * latency_s + 3e-3 + units * 0.1e-3 + 2e-3;
                const double most = plan.duration_s * std::min(fields_Hz, 1 / each_s);
                EXPECT_GE(static_cast<double>(outcome.device.played), 0.9 * most - 1);
            }
}

// A lead that is too short for what the way takes at times grows until switches are in time.
TEST(Autd3VirtualFields, the_lead_grows_where_the_way_takes_longer_at_times)
{
    for (const double jitter_s : {2e-3, 5e-3, 10e-3})
    {
        SCOPED_TRACE(jitter_s);
        Plan plan = farAway(2, true, 1e-3);
        plan.faults.jitter_ns = static_cast<emulation::Time_ns>(jitter_s * 1e9);
        plan.options.lead_s = 1e-3;
        plan.fields_Hz = 20;
        plan.duration_s = 20;
        const Outcome outcome = VirtualRehearsal::play(plan);
        EXPECT_EQ(outcome.device.reconnects, 0u) << outcome.device.message;
        EXPECT_GT(outcome.figures.takenBack, 0u); // else nothing had to grow
        EXPECT_LT(outcome.figures.takenBack, 60u);
        EXPECT_GT(outcome.figures.lead_s, 1e-3);
        EXPECT_LE(outcome.units.fields.torn, outcome.figures.torn);
        EXPECT_GT(outcome.device.played, 300u);
    }
}

// What tears a field, where datagrams are lost on a long way, is known and told; no unit is lost.
TEST_P(Autd3FarAway, far_units_on_a_bad_network_are_late_but_there)
{
    const double latency_s = GetParam();
    for (const int units : {2, 16})
    {
        SCOPED_TRACE(nameOf(units, true, latency_s));
        Plan plan = badNetwork(farAway(units, true, latency_s));
        plan.chain.faults = plan.faults;
        plan.fields_Hz = 100;
        plan.duration_s = 3;
        const Outcome outcome = VirtualRehearsal::play(plan);
        EXPECT_EQ(outcome.device.reconnects, 0u) << outcome.device.message;
        EXPECT_EQ(outcome.device.silences, 0u);
        EXPECT_EQ(outcome.units.fields.unknown, 0u);
        EXPECT_EQ(outcome.units.writesIntoBanks, 0u);
        EXPECT_LE(outcome.units.fields.torn, outcome.figures.torn);
        EXPECT_GT(outcome.device.played, 20u);
        EXPECT_GT(outcome.figures.repeats, 5u); // else nothing was tried
    }
}

TEST_P(Autd3FarAway, far_units_are_silent_as_soon_as_they_hear)
{
    const double latency_s = GetParam();
    for (const int units : {1, 2, 16})
        for (const bool isTimed : {true, false})
            for (const double fields_Hz : {0.3, 200.0})
            {
                SCOPED_TRACE(nameOf(units, isTimed, latency_s));
                Plan plan = farAway(units, isTimed, latency_s);
                plan.fields_Hz = fields_Hz;
                plan.silenceAfter_s = 1;
                plan.duration_s = 2;
                const Outcome outcome = VirtualRehearsal::play(plan);
                EXPECT_GE(outcome.silentAfter_s, 0);
                // What is queued before it, the way, and the millisecond that is looked at.
                EXPECT_LE(outcome.silentAfter_s, latency_s + 5e-3);
                EXPECT_EQ(outcome.device.faults, 0u) << outcome.device.message;
                EXPECT_EQ(outcome.device.reconnects, 0u);
            }
}

// Nothing comes through any more: their fail-safe counts from what they have heard last.
TEST_P(Autd3FarAway, far_units_that_hear_nothing_more_fall_silent_in_time)
{
    const double latency_s = GetParam();
    for (const int units : {1, 2, 16})
        for (const double fields_Hz : {0.3, 200.0})
        {
            SCOPED_TRACE(nameOf(units, true, latency_s));
            Plan plan = farAway(units, true, latency_s);
            plan.fields_Hz = fields_Hz;
            plan.event.kind = emulation::ChainFaults::Kind::HANG;
            plan.eventAfter_s = 1;
            plan.duration_s = 2;
            const Outcome outcome = VirtualRehearsal::play(plan);
            EXPECT_GE(outcome.silentAfter_s, 0);
            EXPECT_LE(outcome.silentAfter_s, plan.options.failsafe_s + latency_s + 2e-3);
            EXPECT_GT(outcome.lostAfter_s, 0);
        }
}

INSTANTIATE_TEST_SUITE_P(Latencies, Autd3FarAway, testing::ValuesIn(kLatencies_s));
