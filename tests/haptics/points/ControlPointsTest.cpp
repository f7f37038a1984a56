#include "haptics/points/ControlPoints.h"

#include <gtest/gtest.h>

namespace midair::haptics
{

namespace
{

ControlPoints line(int n, int object, std::uint64_t first)
{
    ControlPoints points;
    points.positions.setRandom(3, n);
    points.normals.setRandom(3, n);
    points.targets.setRandom(n);
    for (int l = 0; l < n; ++l)
    {
        points.object.push_back(object);
        points.identity.push_back(first + static_cast<std::uint64_t>(l));
    }
    return points;
}

} // namespace

TEST(ControlPoints, PickedOnesAreWhole)
{
    ControlPoints points = line(5, 7, 100);
    points.absolute = true;
    const ControlPoints picked = pick(points, {4, 0, 2});
    ASSERT_EQ(picked.size(), 3);
    EXPECT_TRUE(picked.absolute);
    EXPECT_EQ(picked.positions.col(0), points.positions.col(4));
    EXPECT_EQ(picked.normals.col(1), points.normals.col(0));
    EXPECT_EQ(picked.targets[2], points.targets[2]);
    EXPECT_EQ(picked.object, (std::vector<int>{7, 7, 7}));
    EXPECT_EQ(picked.identity, (std::vector<std::uint64_t>{104, 100, 102}));
    points.identity.clear();
    points.normals.resize(3, 0);
    EXPECT_TRUE(pick(points, {1}).identity.empty());
    EXPECT_EQ(pick(points, {1}).normals.cols(), 0);
}

TEST(ControlPoints, IdentitiesAreAppendedIfBothHaveThem)
{
    ControlPoints both = line(2, 0, 100);
    append(both, line(2, 1, 200));
    EXPECT_EQ(both.identity, (std::vector<std::uint64_t>{100, 101, 200, 201}));
    EXPECT_EQ(both.object, (std::vector<int>{0, 0, 1, 1}));
    ControlPoints other = line(1, 2, 300);
    other.identity.clear();
    append(both, other);
    EXPECT_TRUE(both.identity.empty());
    EXPECT_EQ(both.object, (std::vector<int>{0, 0, 1, 1, 2}));
}

} // namespace midair::haptics
