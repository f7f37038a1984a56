#include "haptics/array/TransducerArray.h"

#include <Eigen/Geometry>

#include <cmath>

#include <gtest/gtest.h>

using midair::haptics::TransducerArray;

namespace
{

// Place of transducer k of a unit, counted from its transducer 0: along x (18), then y, without
// (1, 1), (2, 1) and (16, 1), counted from 0. As the makers say, metres.
Eigen::Vector2d placeOf(int k)
{
    int left = k;
    for (int y = 0; y < 14; ++y)
        for (int x = 0; x < 18; ++x)
        {
            if (y == 1 && (x == 1 || x == 2 || x == 16)) continue;
            if (left-- == 0) return {x * 10.16e-3, y * 10.16e-3};
        }
    return {-1, -1};
}

} // namespace

TEST(Autd3Array, transducers_stand_in_a_units_order)
{
    const TransducerArray unit = TransducerArray::load("autd3");
    ASSERT_EQ(unit.size(), 249);
    EXPECT_EQ(unit.drive.amplitudeLevels.size(), 256u);
    for (int k = 0; k < unit.size(); ++k)
    {
        const Eigen::Vector3d from0 = unit.positions.col(k) - unit.positions.col(0);
        EXPECT_NEAR((from0.head<2>() - placeOf(k)).norm(), 0, 1e-9) << k;
        EXPECT_EQ(from0.z(), 0);
        EXPECT_NEAR((unit.normals.col(k) - Eigen::Vector3d::UnitZ()).norm(), 0, 1e-9);
    }
}

// Each side from its middle: to the right hand seen from the axis is along x of the unit.
TEST(Autd3Array, the_octagon_has_sixteen_of_them_around_the_y_axis)
{
    const TransducerArray octagon = TransducerArray::load("octagon-autd3");
    ASSERT_EQ(octagon.size(), 16 * 249);
    const double apothem_m = 0.192 / 2 / std::tan(std::acos(-1.0) / 8);
    for (int unit = 0; unit < 16; ++unit)
    {
        const double angle = (unit / 2) * std::acos(-1.0) / 4;
        const Eigen::Vector3d outward(std::sin(angle), 0, std::cos(angle));
        const Eigen::Vector3d along = Eigen::Vector3d::UnitY().cross(-outward);
        const double middle_m = (unit % 2 == 0 ? -0.5 : 0.5) * 0.1514;
        for (int k = 0; k < 249; ++k)
        {
            const int i = 249 * unit + k;
            const Eigen::Vector2d place =
                placeOf(k) - Eigen::Vector2d(8.5 * 10.16e-3, 6.5 * 10.16e-3);
            const Eigen::Vector3d wanted = apothem_m * outward + place.x() * along +
                                           (middle_m + place.y()) * Eigen::Vector3d::UnitY();
            ASSERT_NEAR((octagon.positions.col(i) - wanted).norm(), 0, 1e-8) << i;
            ASSERT_NEAR((octagon.normals.col(i) + outward).norm(), 0, 1e-8) << i;
            ASSERT_EQ(octagon.board[static_cast<std::size_t>(i)], unit);
        }
    }
}

// So that scenes and drives made for the one play on the other.
TEST(Autd3Array, the_octagon_is_the_built_in_one)
{
    const TransducerArray file = TransducerArray::load("octagon-autd3");
    const TransducerArray builtIn = TransducerArray::load("octagon");
    ASSERT_EQ(file.size(), builtIn.size());
    EXPECT_NEAR((file.positions - builtIn.positions).norm(), 0, 1e-6);
    EXPECT_NEAR((file.normals - builtIn.normals).norm(), 0, 1e-6);
    EXPECT_EQ(file.board, builtIn.board);
    EXPECT_EQ(file.sourceAmplitude_Pa_m, builtIn.sourceAmplitude_Pa_m);
    EXPECT_EQ(file.directivity, builtIn.directivity);
}
