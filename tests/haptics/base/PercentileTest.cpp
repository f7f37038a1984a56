#include "haptics/base/Percentile.h"

#include <gtest/gtest.h>

using midair::base::percentile;

TEST(Percentile, IsInterpolatedBetweenSortedValues)
{
    const std::vector<double> values = {40.0, 10.0, 30.0, 20.0, 50.0};
    EXPECT_EQ(percentile(values, 0.0), 10.0);
    EXPECT_EQ(percentile(values, 0.5), 30.0);
    EXPECT_EQ(percentile(values, 1.0), 50.0);
    EXPECT_DOUBLE_EQ(percentile(values, 0.1), 14.0);
    EXPECT_DOUBLE_EQ(percentile(values, 0.99), 49.6);
    EXPECT_EQ(percentile({7.0}, 0.3), 7.0);
    EXPECT_EQ(percentile({}, 0.5), 0.0);
}
