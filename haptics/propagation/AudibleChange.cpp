#include "haptics/propagation/AudibleChange.h"

#include "haptics/base/Units.h"

#include <cmath>

namespace midair::haptics
{

namespace
{

constexpr double kLowest_Hz = 20.0;
constexpr double kHighest_Hz = 20e3;

double sinc2(double x)
{
    if (std::fabs(x) < 1e-6) return 1.0;
    const double s = std::sin(base::kPi * x) / (base::kPi * x);
    return s * s;
}

// Returns 2 times the integral of sinc^2 from 0 to x: Simpson's rule up to kFar; beyond that the
// rest is 1/(pi^2 x) on average.
double within(double x)
{
    constexpr double kFar = 50.0;
    constexpr int kPanels = 32; // per lobe
    if (x > kFar) return 1.0 - 1.0 / (base::kPi * base::kPi * x);
    const int n = 2 * static_cast<int>(std::ceil(kPanels * std::fmax(x, 1.0)));
    const double h = x / n;
    double sum = sinc2(0.0) + sinc2(x);
    for (int k = 1; k < n; ++k)
        sum += (k % 2 == 1 ? 4.0 : 2.0) * sinc2(k * h);
    return 2.0 * sum * h / 3.0;
}

} // namespace

double audibleShare(double rate_Hz)
{
    return within(kHighest_Hz / rate_Hz) - within(kLowest_Hz / rate_Hz);
}

} // namespace midair::haptics
