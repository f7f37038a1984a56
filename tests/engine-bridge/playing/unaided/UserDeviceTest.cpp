// Patterns, plans and recordings under the user's ear limit.
#include "engine-bridge/playing/unaided/UserDevice.h"

#include "device/drive/DriveEncoder.h"
#include "haptics/propagation/Exposure.h"
#include "tests/TrustedVariables.h"
#include "tests/device/limits/UserCapTexts.h"

#include <gtest/gtest.h>

using namespace midair;

namespace
{

class UserDevice : public testing::Test
{
protected:
    UserDevice() { base::trustVariablesOfProgram(); }

    std::unique_ptr<device::ArrayDevice> open(const char* uri = "null:") const
    {
        return bridge::openForUser(uri, {_array.size(), _array.board}, &_array);
    }
    /// All in phase, the loudest on the axis.
    device::DriveSignal full() const
    {
        device::DriveSignal signal = device::silentSignal(_array.size());
        std::fill(signal.duty.begin(), signal.duty.end(), std::uint8_t(255));
        return signal;
    }
    double loudest_dB(const device::ArrayDevice& device, const Eigen::Matrix3Xd& places) const
    {
        const std::vector<std::complex<float>> q = device.played();
        const haptics::Exposure ears(_array, haptics::Medium(), places);
        return haptics::soundLevel_dB(
            ears.heard_Pa2({Eigen::Map<const Eigen::VectorXcf>(
                               q.data(), static_cast<Eigen::Index>(q.size()))})
                .maxCoeff());
    }
    static double most(const std::vector<std::complex<float>>& q)
    {
        double all = 0.0;
        for (const std::complex<float>& one : q)
            all = std::max(all, static_cast<double>(std::abs(one)));
        return all;
    }

    const haptics::TransducerArray _array = haptics::TransducerArray::load("autd3");
};

} // namespace

TEST_F(UserDevice, PlaysAsItIsSentWithoutALimit)
{
    const auto device = open();
    ASSERT_TRUE(device->send(full()));
    EXPECT_EQ(most(device->played()), 1.0);
    EXPECT_GT(loudest_dB(*device, haptics::placesAround(_array, 30)), 130.0);
}

TEST_F(UserDevice, AFieldIsLoweredToTheLimitAroundTheArrayAndWhereTheUserSays)
{
    const SetVariable limit("OSG_MIDAIR_EAR_LIMIT", "135");
    Eigen::Matrix3Xd around = haptics::placesAround(_array, 30);
    auto device = open();
    ASSERT_TRUE(device->send(full()));
    const double alone = most(device->played());
    EXPECT_GT(alone, 0.0);
    EXPECT_LE(loudest_dB(*device, around), 135.0);
    EXPECT_GT(loudest_dB(*device, around), 125.0) << "not lower than it has to be";
    EXPECT_EQ(device->wouldPlay(full()), device->played());
    EXPECT_NE(device->status().find("held down to the ear limit of 135 dB"), std::string::npos)
        << device->status();
    const SetVariable places("OSG_MIDAIR_EAR_POINTS", "0 0 2 cm");
    device = open();
    ASSERT_TRUE(device->send(full()));
    EXPECT_LT(most(device->played()), alone);
    const Eigen::Matrix3Xd near = Eigen::Vector3d(0.0, 0.0, 0.02);
    EXPECT_LE(loudest_dB(*device, near), 135.0);
}

TEST_F(UserDevice, WhatNoLevelKeepsToIsRefusedWithSilence)
{
    const auto sonic = haptics::TransducerArray::load("sonicsurface");
    const SetVariable limit("OSG_MIDAIR_EAR_LIMIT", "100");
    const auto device =
        bridge::openForUser("sim:?board=sonicsurface", {sonic.size(), sonic.board}, &sonic);
    device::DriveSignal signal = device::silentSignal(sonic.size());
    std::fill(signal.duty.begin(), signal.duty.end(), std::uint8_t(255));
    EXPECT_FALSE(device->send(signal)) << "emitters are on or off";
    EXPECT_EQ(most(device->played()), 0.0);
    EXPECT_EQ(device->report().refused, 1U);
    EXPECT_NE(device->report().message.find("ear limit of 100 dB"), std::string::npos)
        << device->report().message;
}

TEST_F(UserDevice, ALimitThatNobodyCanHoldIsRefused)
{
    const SetVariable limit("OSG_MIDAIR_EAR_LIMIT", "110");
    EXPECT_THROW(bridge::openForUser("null:", {249, {}}, nullptr), device::DeviceError);
    EXPECT_THROW(bridge::openForUser("null:", {16, {}}, &_array), device::DeviceError);
    EXPECT_THROW(open("play:/nosuch?to=null:"), device::DeviceError);
}

TEST_F(UserDevice, ACapThatIsNotUnderstoodOpensNothing)
{
    for (const UserCapText& one : userCapTexts())
    {
        const SetVariable variable(one.variable, one.text);
        if (one.isUnderstood)
            EXPECT_NO_THROW(open()) << one.variable << "=" << one.text;
        else
            EXPECT_THROW(open(), device::DeviceError) << one.variable << "=" << one.text;
    }
}

TEST_F(UserDevice, AnEnvironmentThatIsDisabledOpensNothing)
{
    const SetVariable enabled("OSG_MIDAIR_ENABLED", "false");
    try
    {
        open();
        ADD_FAILURE() << "opened";
    }
    catch (const device::DeviceError& error)
    {
        EXPECT_EQ(std::string(error.what()), "OSG_MIDAIR_ENABLED is false; nothing is played");
    }
}
