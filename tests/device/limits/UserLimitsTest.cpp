#include "device/limits/UserLimits.h"

#include "tests/TrustedVariables.h"
#include "tests/device/limits/UserCapTexts.h"

#include <gtest/gtest.h>

using namespace midair;
using device::capsOfUser;

namespace
{

/// Variables of the environment count as those that the user set before the program began.
class UserLimits : public testing::Test
{
protected:
    UserLimits() { base::trustVariablesOfProgram(); }
};

} // namespace

TEST_F(UserLimits, AreNoneWithoutVariables)
{
    EXPECT_TRUE(capsOfUser() == device::UserCaps());
}

TEST_F(UserLimits, AreThoseOfTheEnvironment)
{
    const SetVariable amplitude("OSG_MIDAIR_MAX_AMPLITUDE", "0.05");
    const SetVariable pressure("OSG_MIDAIR_MAX_PRESSURE", "2 kPa");
    const SetVariable ears("OSG_MIDAIR_EAR_LIMIT", "100 dB");
    const SetVariable places("OSG_MIDAIR_EAR_POINTS", "0 0 0.6");
    const device::UserCaps caps = capsOfUser();
    EXPECT_EQ(caps.maxAmplitude, 0.05);
    EXPECT_EQ(caps.maxPressure_Pa, 2000.0);
    EXPECT_EQ(caps.earLimit_dB, 100.0);
    EXPECT_EQ(caps.earPoints, "0 0 0.6");
    EXPECT_TRUE(caps.isEarLimitChosen);
    EXPECT_TRUE(caps.wrong.empty());
}

TEST_F(UserLimits, ZeroOfAmplitudeIsSilenceAndOfTheOthersNone)
{
    const SetVariable amplitude("OSG_MIDAIR_MAX_AMPLITUDE", "0");
    const SetVariable pressure("OSG_MIDAIR_MAX_PRESSURE", "0");
    EXPECT_EQ(capsOfUser().maxAmplitude, 0.0);
    EXPECT_EQ(capsOfUser().maxPressure_Pa, 0.0);
    EXPECT_FALSE(capsOfUser().isEarLimitChosen);
    const SetVariable ears("OSG_MIDAIR_EAR_LIMIT", "none");
    EXPECT_EQ(capsOfUser().earLimit_dB, 0.0);
    EXPECT_TRUE(capsOfUser().isEarLimitChosen);
}

TEST_F(UserLimits, DisabledIsSilence)
{
    EXPECT_FALSE(capsOfUser().isSilencing);
    for (const char* text : {"false", "No", "off", "0"})
    {
        const SetVariable enabled("OSG_MIDAIR_ENABLED", text);
        EXPECT_TRUE(capsOfUser().isSilencing) << text;
        EXPECT_TRUE(capsOfUser().wrong.empty()) << text;
    }
}

TEST_F(UserLimits, WhatIsNotUnderstoodIsToldWithItsValue)
{
    for (const UserCapText& one : userCapTexts())
    {
        const SetVariable variable(one.variable, one.text);
        const std::vector<std::string> wrong = capsOfUser().wrong;
        EXPECT_EQ(wrong.empty(), one.isUnderstood) << one.variable << "=" << one.text;
        if (wrong.empty()) continue;
        EXPECT_EQ(wrong.front().rfind(
                      std::string(one.variable) + " is \"" + one.text + "\", should be ", 0),
                  0U)
            << wrong.front();
        EXPECT_NE(wrong.front().find("; nothing is played"), std::string::npos) << wrong.front();
    }
}

TEST_F(UserLimits, TheStricterOfTwoCountsAndPlacesOfBothAreListenedAt)
{
    device::UserCaps a;
    a.maxAmplitude = 0.5;
    a.earLimit_dB = 110.0;
    a.earPoints = "0 0 1";
    device::UserCaps b;
    b.maxPressure_Pa = 800.0;
    b.earLimit_dB = 100.0;
    b.earPoints = "0 1 0;";
    for (const device::UserCaps& both : {stricter(a, b), stricter(b, a)})
    {
        EXPECT_EQ(both.maxAmplitude, 0.5);
        EXPECT_EQ(both.maxPressure_Pa, 800.0);
        EXPECT_EQ(both.earLimit_dB, 100.0);
    }
    EXPECT_EQ(stricter(a, b).earPoints, "0 0 1; 0 1 0;");
    EXPECT_EQ(stricter(b, a).earPoints, "0 1 0; 0 0 1");
    EXPECT_EQ(device::joinedPlaces("0 0 1", "0 0 1"), "0 0 1");
    EXPECT_EQ(device::joinedPlaces("", "0 0 1"), "0 0 1");
}
