#include "engine-bridge/hands/round/RoundHand.h"

#include <algorithm>
#include <utility>

#include <gtest/gtest.h>

using namespace midair;

TEST(RoundHand, HasTheSizeOfAnAdults)
{
    const bridge::RoundHand hand = bridge::roundHand();
    Eigen::Vector3d least = hand.indexTip, most = least, fingers = least;
    for (const haptics::RoundCone& cone : hand.cones)
    {
        EXPECT_GE(std::min(cone.aRadius_m, cone.bRadius_m), 6e-3);
        EXPECT_LE(std::max(cone.aRadius_m, cone.bRadius_m), 15e-3);
        for (const auto& [place, radius_m] :
             {std::pair(cone.a, cone.aRadius_m), std::pair(cone.b, cone.bRadius_m)})
        {
            least = least.cwiseMin((place.array() - radius_m).matrix());
            most = most.cwiseMax((place.array() + radius_m).matrix());
            if (place.x() > -0.04) fingers = fingers.cwiseMin((place.array() - radius_m).matrix());
        }
    }
    EXPECT_NEAR(most.z() - least.z(), 0.19, 0.01) << "length";
    EXPECT_NEAR(most.y() - least.y(), 0.03, 0.003) << "thickness";
    EXPECT_NEAR(most.x() - fingers.x(), 0.085, 0.01) << "width without the thumb";
    EXPECT_NEAR(hand.indexRadius_m, 7.5e-3, 1e-3);
    EXPECT_LT(hand.indexTip.z(), -0.1) << "fingers point to -z";
}
