#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace midair::haptics
{

/// Growing set of points with neighbour searches, by a hash of cubic cells. Cells that share a
/// bucket only cost time, because distances are always tested.
class PointGrid
{
public:
    /// \a cell > 0: edge of the cells, ideally about the search radius. Coordinates must be finite
    /// and less than 2^62 cells.
    explicit PointGrid(double cell) : _inverse(1.0 / cell), _heads(1024, -1) {}

    int size() const { return static_cast<int>(_points.size()); }
    const Eigen::Vector3d& operator[](int i) const { return _points[static_cast<std::size_t>(i)]; }

    /// Makes room for \a count points.
    void reserve(std::size_t count)
    {
        _points.reserve(count);
        _next.reserve(count);
        while (_heads.size() < count)
            grow();
    }

    /// Removes all points and keeps the memory.
    void clear()
    {
        _points.clear();
        _next.clear();
        std::fill(_heads.begin(), _heads.end(), -1);
    }

    /// Adds a point and returns its index, counted from 0.
    int insert(const Eigen::Vector3d& point)
    {
        if (_points.size() >= _heads.size()) grow();
        const int index = size();
        _points.push_back(point);
        _next.push_back(-1);
        link(index);
        return index;
    }

    /// Calls visit(index, squared distance) for every point nearer than \a radius; visit returns
    /// true to stop.
    template<typename Visit>
    bool visitNear(const Eigen::Vector3d& point, double radius, Visit&& visit) const
    {
        const double radius2 = radius * radius;
        const Cell low = cellOf(point - Eigen::Vector3d::Constant(radius));
        const Cell high = cellOf(point + Eigen::Vector3d::Constant(radius));
        for (std::int64_t z = low.z; z <= high.z; ++z)
        {
            for (std::int64_t y = low.y; y <= high.y; ++y)
            {
                for (std::int64_t x = low.x; x <= high.x; ++x)
                {
                    for (int i = _heads[bucket({x, y, z})]; i >= 0;
                         i = _next[static_cast<std::size_t>(i)])
                    {
                        const double d2 =
                            (_points[static_cast<std::size_t>(i)] - point).squaredNorm();
                        if (d2 < radius2 && visit(i, d2)) return true;
                    }
                }
            }
        }
        return false;
    }

    /// Returns true if a point is nearer than \a radius.
    bool anyNear(const Eigen::Vector3d& point, double radius) const
    {
        return visitNear(point, radius, [](int, double) { return true; });
    }

    /// Returns the index of the nearest point within \a radius, or -1; among equal ones the first
    /// inserted.
    int nearest(const Eigen::Vector3d& point, double radius, double* distance2 = nullptr) const
    {
        int best = -1;
        double best2 = radius * radius;
        visitNear(point,
                  radius,
                  [&](int i, double d2)
                  {
                      if (best < 0 || d2 < best2 || (d2 == best2 && i < best))
                      {
                          best = i;
                          best2 = d2;
                      }
                      return false;
                  });
        if (distance2 != nullptr) *distance2 = best2;
        return best;
    }

private:
    struct Cell
    {
        std::int64_t x, y, z;
    };

    Cell cellOf(const Eigen::Vector3d& point) const
    {
        return {coordinate(point.x()), coordinate(point.y()), coordinate(point.z())};
    }

    std::int64_t coordinate(double value) const
    {
        // std::floor is a library call on plain x86-64.
        const double scaled = value * _inverse;
        const auto truncated = static_cast<std::int64_t>(scaled);
        return truncated - (scaled < static_cast<double>(truncated) ? 1 : 0);
    }

    std::size_t bucket(const Cell& cell) const
    {
        const auto x = static_cast<std::uint64_t>(cell.x) * 0x9E3779B97F4A7C15ULL;
        const auto y = static_cast<std::uint64_t>(cell.y) * 0xC2B2AE3D27D4EB4FULL;
        const auto z = static_cast<std::uint64_t>(cell.z) * 0x165667B19E3779F9ULL;
        return static_cast<std::size_t>(((x ^ y ^ z) >> 29U) & (_heads.size() - 1));
    }

    void link(int index)
    {
        int& head = _heads[bucket(cellOf(_points[static_cast<std::size_t>(index)]))];
        _next[static_cast<std::size_t>(index)] = head;
        head = index;
    }

    void grow()
    {
        _heads.assign(2 * _heads.size(), -1);
        for (int i = 0; i < size(); ++i)
            link(i);
    }

    double _inverse;
    std::vector<int> _heads; ///< first point of each bucket; the size is a power of two
    std::vector<int> _next;
    std::vector<Eigen::Vector3d> _points;
};

} // namespace midair::haptics
