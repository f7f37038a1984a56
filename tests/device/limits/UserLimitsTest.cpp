#include "device/limits/UserLimits.h"

#include "haptics/base/UserEnvironment.h"

#include <cstdlib>

#include <gtest/gtest.h>

using namespace midair;

namespace
{

/// Sets the caps of the environment for one test, as the user would before the program begins.
class UserLimits : public testing::Test
{
protected:
    UserLimits() { base::trustVariablesOfProgram(); }
    ~UserLimits() override
    {
        ::unsetenv("OSG_MIDAIR_MAX_AMPLITUDE");
        ::unsetenv("OSG_MIDAIR_MAX_PRESSURE");
    }
    static void set(const char* name, const char* value) { ::setenv(name, value, 1); }
};

} // namespace

TEST_F(UserLimits, AreNoneWithoutVariables)
{
    const device::SafetyLimits none = device::limitsOfUser();
    EXPECT_EQ(none.maxAmplitude, 1.0);
    EXPECT_EQ(none.maxPressure_Pa, 0.0);
}

TEST_F(UserLimits, AreThoseOfTheEnvironment)
{
    set("OSG_MIDAIR_MAX_AMPLITUDE", "0.05");
    set("OSG_MIDAIR_MAX_PRESSURE", "2 kPa");
    EXPECT_EQ(device::limitsOfUser().maxAmplitude, 0.05);
    EXPECT_EQ(device::limitsOfUser().maxPressure_Pa, 2000.0);
    set("OSG_MIDAIR_MAX_AMPLITUDE", "0");
    set("OSG_MIDAIR_MAX_PRESSURE", "0");
    EXPECT_EQ(device::limitsOfUser().maxAmplitude, 0.0);
    EXPECT_EQ(device::limitsOfUser().maxPressure_Pa, 0.0) << "none";
}

TEST_F(UserLimits, NothingIsPlayedWithOneThatIsNotUnderstood)
{
    for (const char* wrong : {"", "much", "-0.1", "1.5", "nan", "0,5"})
    {
        set("OSG_MIDAIR_MAX_AMPLITUDE", wrong);
        EXPECT_THROW(device::limitsOfUser(), device::DeviceError) << wrong;
    }
    ::unsetenv("OSG_MIDAIR_MAX_AMPLITUDE");
    for (const char* wrong : {"", "800 kg", "-1", "inf", "2e6"})
    {
        set("OSG_MIDAIR_MAX_PRESSURE", wrong);
        EXPECT_THROW(device::limitsOfUser(), device::DeviceError) << wrong;
    }
}
