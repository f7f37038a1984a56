// A decimal comma of the program's locale changes no number, neither read nor written.
#include "device/ArrayDevice.h"
#include "device/limits/GuardedDevice.h"
#include "tests/CommaLocale.h"
#include "tests/device/TestFiles.h"

#include <gtest/gtest.h>

using namespace midair::device;

TEST(DeviceLocale, changes_no_number_of_a_uri)
{
    const CommaLocale comma;
    if (!comma.isSet()) GTEST_SKIP();
    EXPECT_EQ(openError("sim:?max-amplitude=0.2&ramp=2.5ms&drop=1e-3"), "no error");
    const DriveSignal loud = {{0, 0, 0, 0}, {255, 255, 255, 255}};
    const auto device = openDevice("null:?max-amplitude=0.25", {4, {}});
    EXPECT_NEAR(std::abs(device->wouldPlay(loud)[0]), 0.25, 0.005);
    device->send(loud);
    EXPECT_NE(device->status().find("limited to 25 %"), std::string::npos) << device->status();
}

TEST(DeviceLocale, changes_no_number_of_a_message)
{
    const CommaLocale comma;
    if (!comma.isSet()) GTEST_SKIP();
    EXPECT_EQ(openError("play:a?speed=0&to=null:"),
              "device \"play:a?speed=0&to=null:\": speed=0 should be a number from 0.001 to 1000");
    SafetyLimits limits;
    limits.ramp_s = 10.5;
    try
    {
        openLimitedDevice("null:", {4, {}}, limits);
        FAIL();
    }
    catch (const DeviceError& error)
    {
        EXPECT_STREQ(error.what(), "device limits: ramp is 10.5 s; it must be within 0 .. 10");
    }
}

TEST(DeviceLocale, a_decimal_comma_is_named)
{
    EXPECT_EQ(
        openError("sim:?max-amplitude=0,2"),
        "device \"sim:?max-amplitude=0,2\": max-amplitude=0,2 should be a number from 0 to 1, "
        "with a point and not a comma");
    EXPECT_EQ(openError("sim:?latency=0,5s"),
              "device \"sim:?latency=0,5s\": latency=0,5s should be a time such as 2s, 100ms or "
              "20us, with a point and not a comma");
}
