#include "engine-bridge/playing/EarBound.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

Eigen::Matrix3Xd earsAt(double x_m)
{
    Eigen::Matrix3Xd ears(3, 2);
    ears << x_m - 0.08, x_m + 0.08, 0.0, 0.0, 0.6, 0.6;
    return ears;
}

} // namespace

TEST(EarWatch, HearsWhatIsPlayedAroundTheArrayAtGivenPlacesAndAtEars)
{
    EarWatch watch;
    const haptics::TransducerArray array = haptics::TransducerArray::singleBoard();
    const Eigen::Matrix3Xd given = Eigen::Vector3d(0.0, 0.0, 0.25);
    watch.setPlace(array, haptics::Medium(), given);
    EXPECT_EQ(watch.bound(), nullptr) << "there is no limit";
    EXPECT_EQ(watch.reading(1.0).places, 0);
    const Eigen::VectorXcf full = Eigen::VectorXcf::Ones(array.size());
    watch.play({full}, 1.0);
    const haptics::ExposureFigures figures = watch.reading(3.0);
    EXPECT_EQ(figures.places, EarWatch::kAround + 1);
    // All in phase on the axis, nearer than the others.
    EXPECT_EQ(Eigen::Vector3d(figures.x_m, figures.y_m, figures.z_m), given.col(0));
    EXPECT_NEAR(figures.level_dB, figures.max_dB, 1e-6);
    EXPECT_NEAR(figures.level_dB, figures.eq_dB, 1e-6);
    EXPECT_GT(figures.level_dB, 130.0);
    watch.setEars(earsAt(0.0));
    EXPECT_TRUE(watch.isUnmoved(earsAt(0.009)));
    EXPECT_FALSE(watch.isUnmoved(earsAt(0.011)));
    EXPECT_FALSE(watch.isUnmoved(Eigen::Matrix3Xd(3, 0)));
    watch.play({}, 4.0);
    EXPECT_EQ(watch.reading(5.0).places, EarWatch::kAround + 3);
    EXPECT_EQ(watch.reading(5.0).level_dB, 0.0);
}

TEST(EarWatch, TheLimitFollowsTheEars)
{
    EarWatch watch;
    const haptics::TransducerArray array = haptics::TransducerArray::singleBoard();
    watch.setPlace(array, haptics::Medium(), Eigen::Matrix3Xd(3, 0));
    watch.setLimit(120.0);
    const Eigen::VectorXcf full = Eigen::VectorXcf::Ones(array.size());
    ASSERT_NE(watch.bound(), nullptr);
    const double around = watch.bound()->excess(full, 0.0f, {});
    Eigen::Matrix3Xd near(3, 1);
    near << 0.0, 0.0, 0.2;
    watch.setEars(near);
    const double atEar = watch.bound()->excess(full, 0.0f, {});
    EXPECT_GT(atEar, 1.5 * around);
    near(2, 0) = 0.8;
    watch.setEars(near);
    EXPECT_LT(watch.bound()->excess(full, 0.0f, {}), atEar);
    near(2, 0) = std::numeric_limits<double>::quiet_NaN();
    watch.setEars(near);
    EXPECT_NEAR(watch.bound()->excess(full, 0.0f, {}), around, 1e-6 * around);
    watch.setLimit(0.0);
    EXPECT_EQ(watch.bound(), nullptr);
    EXPECT_EQ(watch.reading(0.0).limit_dB, 0.0);
}

TEST(EarWatch, EachEarAndThenEachPlaceOfTheUsersIsHeard)
{
    EarWatch watch;
    const haptics::TransducerArray array = haptics::TransducerArray::singleBoard();
    watch.setPlace(array, haptics::Medium(), Eigen::Vector3d(0.0, 0.0, 0.25));
    watch.setEars(earsAt(0.3));
    watch.play({Eigen::VectorXcf::Ones(array.size())}, 1.0);
    std::vector<haptics::PlaceExposure> each = watch.each(2.0);
    ASSERT_EQ(each.size(), 3u);
    EXPECT_NEAR(each[0].x_m, 0.22, 1e-12);
    EXPECT_NEAR(each[1].x_m, 0.38, 1e-12);
    EXPECT_NEAR(each[2].z_m, 0.25, 1e-12);
    EXPECT_GT(each[2].level_dB, each[0].level_dB + 3.0) << "on the axis, and nearer";
    EXPECT_NEAR(watch.reading(2.0).level_dB, each[2].level_dB, 1e-6);
    const double before_dB = each[0].level_dB;
    watch.setEars(earsAt(0.08));
    watch.play({Eigen::VectorXcf::Ones(array.size())}, 2.0);
    each = watch.each(3.0);
    EXPECT_NEAR(each[0].x_m, 0.0, 1e-12);
    EXPECT_GT(each[0].level_dB, before_dB + 3.0);
}
