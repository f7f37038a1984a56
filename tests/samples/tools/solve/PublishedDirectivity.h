#pragma once

#include <algorithm>
#include <cmath>
#include <string>

/// The paper's zonal harmonics of order 0 to 3 for orthonormal Y_n0, scaled to 1 on the axis, never
/// negative.
inline double publishedDirectivity(double x)
{
    const auto sum = [](double t)
    {
        const double c[4] = {1.11, 1.06, 0.24, -0.12};
        const double p[4] = {1.0, t, 0.5 * (3 * t * t - 1), 0.5 * (5 * t * t * t - 3 * t)};
        double total = 0.0;
        for (int n = 0; n < 4; ++n)
            total += c[n] * std::sqrt((2 * n + 1) / (4 * M_PI)) * p[n];
        return total;
    };
    return std::max(0.0, sum(x) / sum(1.0));
}

/// The measured table of the T4010A1's data sheet: dB every 10 degrees, linear between them;
/// nothing behind.
inline double measuredDirectivity(double x)
{
    if (x < 0.0) return 0.0;
    const double levels_dB[] = {0, 0, 0, -1, -3, -6, -9, -12, -14, -15, -15};
    const double angle = std::acos(std::min(1.0, x)) * 18 / M_PI;
    const auto k = static_cast<int>(angle);
    return std::pow(10.0, (levels_dB[k] + (angle - k) * (levels_dB[k + 1] - levels_dB[k])) / 20.0);
}

/// The directivity that summary.json names.
inline double directivity(const std::string& model, double x)
{
    if (model == "point") return 1.0;
    return model == "t4010a1-table" ? measuredDirectivity(x) : publishedDirectivity(x);
}
