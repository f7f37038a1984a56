#include "engine-bridge/extending/DriverDevice.h"

#include <gtest/gtest.h>

using midair::bridge::DueSilence;

TEST(DueSilence, IsRepeatedSoonAndThenLater)
{
    DueSilence silence;
    EXPECT_FALSE(silence.isDue(10.0));
    silence.want();
    double now_s = 10.0;
    for (int k = 1; k <= 12; ++k)
    {
        ASSERT_TRUE(silence.isDue(now_s)) << k;
        silence.begin();
        EXPECT_FALSE(silence.isWanted());
        silence.fail(now_s, false);
        silence.want(); // one that is wanted meanwhile waits as well
        const double pause_s = k < 10 ? 0.1 : 1.0;
        EXPECT_NEAR(silence.rest_s(now_s), pause_s, 1e-9) << k;
        EXPECT_FALSE(silence.isDue(now_s + 0.9 * pause_s)) << k;
        now_s += 1.01 * pause_s;
    }
    silence.begin();
    silence.succeed(now_s, false);
    EXPECT_FALSE(silence.isDue(now_s + 100.0));
    silence.want();
    EXPECT_TRUE(silence.isDue(now_s)) << "nothing fails any more";
}

TEST(DueSilence, OfALostDriverIsDueOnceASecond)
{
    DueSilence silence;
    silence.wantNow();
    ASSERT_TRUE(silence.isDue(10.0));
    silence.begin();
    silence.succeed(10.0, true);
    silence.want();
    EXPECT_FALSE(silence.isDue(10.9));
    EXPECT_TRUE(silence.isDue(11.0));
    silence.wantNow();
    EXPECT_TRUE(silence.isDue(10.1)) << "it is back";
}
