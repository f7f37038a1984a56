#include "haptics/propagation/Reflections.h"

#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

using Complex = std::complex<double>;

// Up to here the series, whose terms grow to 30, loses less than 1e-14.
constexpr double kOfSeries = 1.6;
// In square metres and metres, far below any distance that matters: keep v finite in the plane.
constexpr double kLeastArea_m2 = 1e-24;
constexpr double kLeastLength_m = 1e-9;

// F(v) - 1/2 by the series of the integral: sum_n (-j pi/2)^n v^(2n+1) / (n! (2n+1)).
Complex bySeries(double v)
{
    Complex sum = 0.0, term = v;
    for (int n = 0; std::abs(term) > 1e-17 * std::abs(v) && n < 100; ++n)
    {
        sum += term / (2.0 * n + 1.0);
        term *= Complex(0.0, -0.5 * base::kPi * v * v / (n + 1.0));
    }
    return Complex(0.5, 0.5) * sum;
}

// 1 - F(v) for v >= kOfSeries, by the continued fraction of erfc (Abramowitz, Stegun 7.1.14), with
// Lentz' method.
Complex rest(double v)
{
    const double square = base::kPi * v * v;
    Complex b(1.0, -square), c = 1e300, d = 1.0 / b, h = d;
    for (int n = 1; n < 400; n += 2)
    {
        const double a = -n * (n + 1.0);
        b += 4.0;
        d = 1.0 / (a * d + b);
        c = b + a / c;
        const Complex change = c * d;
        h *= change;
        if (std::abs(change - 1.0) < 1e-15) break;
    }
    h *= Complex(v, -v);
    return 0.5 * std::conj(std::polar(1.0, 0.5 * square) * h);
}

// F(v+) - F(v-), with v+ >= v-. As a difference of what is left beyond, on the side of both, so
// that it is exact far outside.
Complex between(double low, double high)
{
    return low > 0.0 ? shareBeyondEdge(-low) - shareBeyondEdge(-high)
                     : shareBeyondEdge(high) - shareBeyondEdge(low);
}

} // namespace

std::complex<double> shareBeyondEdge(double v)
{
    if (std::abs(v) < kOfSeries) return 0.5 + bySeries(v);
    const Complex left = std::abs(v) < 1e8 ? rest(std::abs(v)) : Complex(0.0, 0.0);
    return v > 0.0 ? 1.0 - left : left;
}

std::complex<double> shareTurned(const Reflector& reflector,
                                 const Eigen::Vector3d& from,
                                 const Eigen::Vector3d& to,
                                 double wavelength_m)
{
    if (!reflector.size_m.allFinite()) return 1.0;
    const double a = std::abs(reflector.heightOf(from)), b = std::abs(reflector.heightOf(to));
    const Eigen::Vector3d sides[] = {reflector.along, reflector.across()};
    double s[2], x[2];
    for (int e = 0; e < 2; ++e)
    {
        s[e] = sides[e].dot(from - reflector.position);
        x[e] = sides[e].dot(to - reflector.position);
    }
    // The path has the length r and meets the plane at X = (s b + x a) / (a + b), in the parts
    // r a / (a + b) and r b / (a + b), whose inverses add up to (a + b)^2 / (a b r).
    const double up = std::max(a + b, kLeastLength_m);
    const double area = std::max(a * b, kLeastArea_m2);
    const double r =
        std::sqrt(up * up + (x[0] - s[0]) * (x[0] - s[0]) + (x[1] - s[1]) * (x[1] - s[1]));
    Complex share = 1.0;
    for (int e = 0; e < 2; ++e)
    {
        const double other = x[1 - e] - s[1 - e];
        const double scale =
            std::sqrt(2.0 * (up * up + other * other) / (wavelength_m * area * r * r * r));
        const double middle = s[e] * b + x[e] * a, half = 0.5 * reflector.size_m[e] * up;
        share *= between((-half - middle) * scale, (half - middle) * scale);
    }
    return share;
}

} // namespace midair::haptics
