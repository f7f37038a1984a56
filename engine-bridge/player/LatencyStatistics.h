#pragma once

#include "haptics/base/Percentile.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace midair::bridge
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
        const auto end = static_cast<std::ptrdiff_t>(std::min(_count, kWindow));
        return base::percentile({_values.begin(), _values.begin() + end}, fraction);
    }

private:
    std::array<double, kWindow> _values{};
    std::size_t _count = 0;
};

} // namespace midair::bridge
