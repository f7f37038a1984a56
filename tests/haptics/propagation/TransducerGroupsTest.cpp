#include "haptics/propagation/TransducerGroups.h"

#include "haptics/array/TransducerArray.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

// The largest distance between two transducers of one group of \a order.
double largestGroup_m(const Eigen::Matrix3Xd& positions, const std::vector<int>& order, int size)
{
    double largest = 0.0;
    for (std::size_t a = 0; a < order.size(); ++a)
        for (std::size_t b = a + 1; b < order.size() && b / static_cast<std::size_t>(size) ==
                                                            a / static_cast<std::size_t>(size);
             ++b)
            largest = std::max(largest, (positions.col(order[a]) - positions.col(order[b])).norm());
    return largest;
}

} // namespace

TEST(TransducerGroups, EveryTransducerHasOnePlace)
{
    for (const int count : {0, 1, 31, 32, 33, 249, 1000})
    {
        std::mt19937 random(static_cast<unsigned>(count));
        std::uniform_real_distribution<double> uniform(-0.1, 0.1);
        Eigen::Matrix3Xd positions(3, count);
        for (Eigen::Index i = 0; i < positions.size(); ++i)
            positions.data()[i] = uniform(random);
        std::vector<int> order = compactOrder(positions, 32);
        std::sort(order.begin(), order.end());
        ASSERT_EQ(order.size(), static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i)
            EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
    }
}

TEST(TransducerGroups, GroupsOfTheKnownArraysAreCompact)
{
    // 32 transducers a centimetre apart: 4 x 8 have a diagonal of 76 mm; where a group spans what
    // the halving left over, half as much again.
    for (const TransducerArray& array :
         {TransducerArray::octagonalPrism(), TransducerArray::singleBoard()})
    {
        std::vector<int> asWired(static_cast<std::size_t>(array.size()));
        for (int i = 0; i < array.size(); ++i)
            asWired[static_cast<std::size_t>(i)] = i;
        EXPECT_LT(largestGroup_m(array.positions, compactOrder(array.positions, 32), 32), 0.11);
        EXPECT_GT(largestGroup_m(array.positions, asWired, 32), 0.16);
    }
}

TEST(TransducerGroups, CoincidentTransducersAreOrderedByNumber)
{
    const std::vector<int> order = compactOrder(Eigen::Matrix3Xd::Zero(3, 100), 32);
    EXPECT_EQ(order, compactOrder(Eigen::Matrix3Xd::Zero(3, 100), 32));
    EXPECT_EQ(order.size(), 100u);
}
