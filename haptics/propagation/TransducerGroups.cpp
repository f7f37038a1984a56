#include "haptics/propagation/TransducerGroups.h"

#include <algorithm>

namespace midair::haptics
{

namespace
{

struct Place
{
    Eigen::Array3d r;
    int transducer;
};

// Recursively splits a range of transducers along its longest side, at a multiple of the group
// size, until one group is left.
void divide(int size, Place* first, Place* last)
{
    const auto count = last - first;
    if (count <= size) return;
    Eigen::Array3d low = first->r, high = low;
    for (const Place* place = first; place != last; ++place)
    {
        low = low.min(place->r);
        high = high.max(place->r);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const auto groups = (count + size - 1) / size;
    Place* middle = first + (groups + 1) / 2 * size;
    std::nth_element(first,
                     middle,
                     last,
                     [axis](const Place& a, const Place& b) {
                         return a.r[axis] != b.r[axis] ? a.r[axis] < b.r[axis]
                                                       : a.transducer < b.transducer;
                     });
    divide(size, first, middle);
    divide(size, middle, last);
}

bool isCompactGroup(const Eigen::Matrix3Xd& positions,
                    const int* first,
                    std::size_t count,
                    double largest_m)
{
    Eigen::Array3d low = positions.col(*first), high = low;
    for (std::size_t k = 1; k < count; ++k)
    {
        low = low.min(positions.col(first[k]).array());
        high = high.max(positions.col(first[k]).array());
    }
    const Eigen::Vector3d middle = 0.5 * (low + high);
    for (std::size_t k = 0; k < count; ++k)
        if ((positions.col(first[k]) - middle).norm() > largest_m) return false;
    return true;
}

} // namespace

std::vector<int> compactOrder(const Eigen::Matrix3Xd& positions, int size)
{
    std::vector<Place> places;
    places.reserve(static_cast<std::size_t>(positions.cols()));
    for (int i = 0; i < positions.cols(); ++i)
        places.push_back({positions.col(i), i});
    divide(size, places.data(), places.data() + places.size());
    std::vector<int> order;
    order.reserve(places.size());
    for (const Place& place : places)
        order.push_back(place.transducer);
    return order;
}

bool isCompact(const Eigen::Matrix3Xd& positions,
               const std::vector<int>& order,
               int size,
               double largest_m)
{
    const auto step = static_cast<std::size_t>(size);
    for (std::size_t first = 0; first < order.size(); first += step)
        if (!isCompactGroup(
                positions, order.data() + first, std::min(step, order.size() - first), largest_m))
            return false;
    return true;
}

PackedOrder
packed(const Eigen::Matrix3Xd& positions, const std::vector<int>& order, int size, double largest_m)
{
    PackedOrder all;
    std::size_t first = 0; // of the present group
    const auto endGroup = [&]
    {
        while (all.order.size() % static_cast<std::size_t>(size) != 0)
        {
            all.order.push_back(all.order[first]);
            all.isFiller.push_back(1);
        }
        first = all.order.size();
    };
    for (const int transducer : order)
    {
        all.order.push_back(transducer);
        const std::size_t count = all.order.size() - first;
        if (count > 1 && !isCompactGroup(positions, all.order.data() + first, count, largest_m))
        {
            all.order.pop_back();
            endGroup();
            all.order.push_back(transducer);
        }
        all.isFiller.push_back(0);
        if (all.order.size() - first == static_cast<std::size_t>(size)) first = all.order.size();
    }
    return all;
}

} // namespace midair::haptics
