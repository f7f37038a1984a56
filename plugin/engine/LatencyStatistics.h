#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace osgMidair
{

/// Percentiles over the last kWindow values.
class LatencyStatistics
{
public:
    static constexpr std::size_t kWindow = 1024;

    void add(double value)
    {
        _values[_count % kWindow] = value;
        ++_count;
    }

    /// Returns the percentile at \a fraction (0 .. 1) of the values in the window; 0 if there are
    /// none.
    double percentile(double fraction) const
    {
        const std::size_t size = std::min(_count, kWindow);
        if (size == 0) return 0.0;
        std::vector<double> sorted(_values.begin(),
                                   _values.begin() + static_cast<std::ptrdiff_t>(size));
        const auto rank =
            std::min(size - 1, static_cast<std::size_t>(fraction * static_cast<double>(size)));
        std::nth_element(
            sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(rank), sorted.end());
        return sorted[rank];
    }

private:
    std::array<double, kWindow> _values{};
    std::size_t _count = 0;
};

} // namespace osgMidair
