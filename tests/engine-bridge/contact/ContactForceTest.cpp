#include "engine-bridge/contact/ContactForce.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PressureField.h"
#include "tests/engine-bridge/contact/ContactNumbers.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

TEST(ContactForce, PressureIsThatOfTheForceOnTheFocus)
{
    const haptics::Medium air;
    const ContactForce force({}, air);
    EXPECT_DOUBLE_EQ(force.force_N(1e-3), 0.01);
    EXPECT_DOUBLE_EQ(force.force_N(5e-3), 0.02); // clipped
    const double p = force.pressure_Pa(1e-3, 1, 1.0);
    EXPECT_NEAR(haptics::radiationForce(p, 22e-6, air, 2.0), 0.01, 1e-9);
    EXPECT_NEAR(force.pressure_Pa(1e-3, 4, 1.0), 0.5 * p, 1e-9 * p);
    EXPECT_NEAR(force.pressure_Pa(0.25e-3, 1, 1.0), 0.5 * p, 1e-9 * p); // p ~ sqrt(F)
}

TEST(ContactForce, GrowsOverTheRampWithoutAStep)
{
    const ContactForce force;
    const double whole = force.pressure_Pa(1e-3, 1, 1.0);
    EXPECT_EQ(force.pressure_Pa(1e-3, 1, 0.0), 0.0);
    EXPECT_NEAR(force.pressure_Pa(1e-3, 1, 0.01), 0.5 * whole, 1e-9 * whole);
    EXPECT_EQ(force.pressure_Pa(1e-3, 1, 0.02), whole);
    for (int i = 0; i < 20; ++i)
        EXPECT_LT(force.pressure_Pa(1e-3, 1, 1e-3 * (i + 1)) - force.pressure_Pa(1e-3, 1, 1e-3 * i),
                  0.08 * whole);
}

TEST(ContactForce, IsSilentForNumbersThatAreNone)
{
    const ContactForce force;
    for (const double depth : {kNan, double(INFINITY), -1e-3, 0.0})
        EXPECT_EQ(force.pressure_Pa(depth, 1, 1.0), 0.0);
    EXPECT_EQ(force.pressure_Pa(1e-3, 0, 1.0), 0.0);
    EXPECT_EQ(force.pressure_Pa(1e-3, 1, kNan), 0.0);
    ContactForceOptions options;
    options.stiffness_N_m = kNan;
    EXPECT_THROW(ContactForce{options}, base::InputError);
    options = {};
    options.focusArea_m2 = 0.0;
    std::string error;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "ContactForceOptions: focusArea_m2 is 0; it must be within 1e-06 .. 0.001");
}

} // namespace

} // namespace midair::bridge
