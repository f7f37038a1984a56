#include "device/autd3/Autd3Options.h"

#include "device/DeviceUri.h"

#include <string>

#include <gtest/gtest.h>

using namespace midair::device;
using namespace midair::device::autd3;

namespace
{

Autd3Options take(const std::string& text, int units = 4)
{
    DeviceUri uri(text);
    Autd3Options options = takeAutd3Options(uri, {units * kTransducersPerUnit, {}});
    uri.rejectUnknown();
    return options;
}

std::string whyNot(const std::string& text, int transducers = 4 * kTransducersPerUnit)
{
    try
    {
        DeviceUri uri(text);
        takeAutd3Options(uri, {transducers, {}});
        uri.rejectUnknown();
    }
    catch (const DeviceError& error)
    {
        return error.what();
    }
    ADD_FAILURE() << text << " was taken";
    return {};
}

void expectRefused(const std::string& parameter, const std::string& why)
{
    const std::string said = whyNot("autd3:?" + parameter);
    EXPECT_NE(said.find(parameter), std::string::npos) << said;
    EXPECT_NE(said.find(why), std::string::npos) << said;
}

} // namespace

TEST(Autd3Options, have_defaults)
{
    const Autd3Options options = take("autd3:");
    EXPECT_EQ(options.units, 4); // as the array has
    EXPECT_EQ(options.order, (std::vector<int>{0, 1, 2, 3}));
    EXPECT_TRUE(options.timed);
    EXPECT_EQ(options.cpu().switchMargin_ns, 1'000'000u);
    EXPECT_EQ(options.cpu().failsafe_ms, 100u);
    EXPECT_EQ(options.whenLost, WhenLost::ALL_FALL_SILENT);
}

TEST(Autd3Options, are_taken)
{
    const Autd3Options options =
        take("autd3:?units=4&interface=eth7&order=3,2,1,0&sync=now&lead=5ms&failsafe=200ms&"
             "heartbeat=20ms&silencer=1,2&lost=one");
    EXPECT_EQ(options.interface, "eth7");
    EXPECT_EQ(options.order, (std::vector<int>{3, 2, 1, 0}));
    EXPECT_FALSE(options.timed);
    EXPECT_DOUBLE_EQ(options.lead_s, 5e-3);
    EXPECT_EQ(options.cpu().failsafe_ms, 200u);
    EXPECT_DOUBLE_EQ(options.heartbeat_s, 20e-3);
    EXPECT_EQ(options.silencer, (Silencer{1, 2}));
    EXPECT_EQ(options.whenLost, WhenLost::ONE_IS_MISSED);
    EXPECT_EQ(take("autd3:?group=[::1]:5000").group, "[::1]:5000");
}

TEST(Autd3Options, a_heartbeat_that_is_not_named_fits_the_failsafe)
{
    EXPECT_NEAR(take("autd3:?failsafe=100ms").restBeat_s(), 100e-3 / 3, 1e-9);
    EXPECT_DOUBLE_EQ(take("autd3:?failsafe=5s").restBeat_s(), 0.1);
    EXPECT_DOUBLE_EQ(take("autd3:?failsafe=5s&heartbeat=1s").restBeat_s(), 1);
    EXPECT_DOUBLE_EQ(take("autd3:?heartbeat=10ms").restBeat_s(), 10e-3);
    EXPECT_NEAR(take("autd3:?failsafe=20ms").heartbeat_s, 20e-3 / 3, 1e-9);
}

TEST(Autd3Options, the_margin_of_a_short_lead_is_shorter)
{
    EXPECT_EQ(take("autd3:?lead=1500us").cpu().switchMargin_ns, 500'000u);
}

TEST(Autd3Options, dead_transducers_are_masked_at_the_unit_that_has_them)
{
    DeviceUri uri("autd3:?order=1,0");
    const Autd3Options options = takeAutd3Options(uri, {2 * 249, {}, {3, 249, 300}});
    EXPECT_EQ(options.silent, (std::vector<std::vector<int>>{{0, 51}, {3}}));
}

TEST(Autd3Options, wrong_ones_are_told_by_name)
{
    expectRefused("units=0", "1 to 64");
    expectRefused("units=65", "1 to 64");
    expectRefused("units=2.5", "whole");
    expectRefused("units=3", "747 transducers, but the array has 996");
    expectRefused("order=0,1,2", "3 boards; there are 4 units");
    expectRefused("order=0,1,2,2", "\"2\"");
    expectRefused("order=0,1,2,4", "0 .. 3");
    expectRefused("order=0,1,,3", "\"\"");
    expectRefused("sync=later", "time or now");
    expectRefused("lead=0.1ms", "0.5ms .. 100ms");
    expectRefused("lead=3", "a time such as");
    expectRefused("failsafe=10ms", "20ms .. 10000ms");
    expectRefused("heartbeat=50ms", "1ms .. 33.3333ms");
    expectRefused("silencer=40", "two numbers");
    expectRefused("silencer=0,10", "1 .. 65535");
    expectRefused("lost=two", "all or one");
    expectRefused("unit=4", "units");
    EXPECT_NE(whyNot("autd3:?interface=eth0&group=[::1]:1").find("exclude"), std::string::npos);
    EXPECT_NE(whyNot("autd3:cable").find("cable"), std::string::npos);
    EXPECT_NE(whyNot("autd3:", 256).find("249"), std::string::npos);
    EXPECT_NE(whyNot("autd3:", 65 * 249).find("64"), std::string::npos);
}
