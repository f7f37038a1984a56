#include "haptics/TransducerGroups.h"

#include <algorithm>
#include <numeric>

namespace midair::haptics
{

namespace
{

// Halves a range along its longer side, at a multiple of the size, until one group is left.
void divide(const Eigen::Matrix3Xd& positions, int size, int* first, int* last)
{
    const auto count = last - first;
    if (count <= size) return;
    Eigen::Array3d low = positions.col(*first), high = low;
    for (const int* i = first; i != last; ++i)
    {
        low = low.min(positions.col(*i).array());
        high = high.max(positions.col(*i).array());
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const auto groups = (count + size - 1) / size;
    int* middle = first + (groups + 1) / 2 * size;
    std::nth_element(first,
                     middle,
                     last,
                     [&](int a, int b)
                     {
                         const double x = positions(axis, a), y = positions(axis, b);
                         return x != y ? x < y : a < b;
                     });
    divide(positions, size, first, middle);
    divide(positions, size, middle, last);
}

} // namespace

std::vector<int> compactOrder(const Eigen::Matrix3Xd& positions, int size)
{
    std::vector<int> order(static_cast<std::size_t>(positions.cols()));
    std::iota(order.begin(), order.end(), 0);
    divide(positions, size, order.data(), order.data() + order.size());
    return order;
}

} // namespace midair::haptics
