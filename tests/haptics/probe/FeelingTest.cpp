#include "haptics/probe/Feeling.h"

#include <limits>

#include <gtest/gtest.h>

namespace midair::haptics
{

TEST(Feeling, HasFourWordsThatDependOnHowItIsPlayed)
{
    EXPECT_STREQ(feelingOf(0.5e-3, PlayedAs::HELD), "too weak to feel");
    EXPECT_STREQ(feelingOf(0.5e-3, PlayedAs::VIBRATING), "faint");
    EXPECT_STREQ(feelingOf(4e-3, PlayedAs::HELD), "faint");
    EXPECT_STREQ(feelingOf(4e-3, PlayedAs::VIBRATING), "clear");
    EXPECT_STREQ(feelingOf(18e-3, PlayedAs::HELD), "faint");
    EXPECT_STREQ(feelingOf(18e-3, PlayedAs::CIRCLING), "strong");
    EXPECT_STREQ(feelingOf(std::numeric_limits<double>::quiet_NaN(), PlayedAs::CIRCLING), kTooWeak);
}

} // namespace midair::haptics
