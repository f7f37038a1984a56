#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace midair::base
{

/// Returns the percentile of \a values at \a fraction (0 .. 1), linearly interpolated: the k-th of
/// n sorted values is at (k - 1)/(n - 1). 0 if there are none.
inline double percentile(std::vector<double> values, double fraction)
{
    if (values.empty()) return 0.0;
    const double place = fraction * static_cast<double>(values.size() - 1);
    const auto k = std::min(static_cast<std::size_t>(place), values.size() - 1);
    const auto low = values.begin() + static_cast<std::ptrdiff_t>(k);
    std::nth_element(values.begin(), low, values.end());
    if (low + 1 == values.end()) return *low;
    const double above = *std::min_element(low + 1, values.end());
    return *low + (place - static_cast<double>(k)) * (above - *low);
}

} // namespace midair::base
