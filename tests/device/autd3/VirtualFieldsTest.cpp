// Fields on sixteen units in virtual time, where a minute of faults takes seconds and each run is
// the same.
#include "tests/device/autd3/VirtualRehearsal.h"

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
