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

} // namespace midair::haptics
