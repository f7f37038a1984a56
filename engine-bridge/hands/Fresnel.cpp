#include "engine-bridge/hands/Fresnel.h"

#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>

namespace midair::bridge
{

namespace
{

constexpr double kFade = 0.6;

}

std::complex<double> knifeEdge(double v)
{
    // Auxiliary functions of v >= 0: C(v) = 1/2 + f sin - g cos, S(v) = 1/2 - f cos - g sin of pi
    // v^2/2 (A&S 7.3.9, 7.3.10), so that integral from v of e^{-j pi t^2/2} = (1/2 - C) - j (1/2 -
    // S) = (g - j f) e^{-j pi v^2/2}.
    const double x = std::abs(v);
    const double f = (1.0 + 0.926 * x) / (2.0 + 1.792 * x + 3.104 * x * x);
    const double g = 1.0 / (2.0 + 4.142 * x + 3.492 * x * x + 6.670 * x * x * x);
    const std::complex<double> beyond = std::complex<double>(0.5, 0.5) *
                                        std::complex<double>(g, -f) *
                                        std::polar(1.0, -0.5 * base::kPi * x * x);
    return v >= 0.0 ? beyond : 1.0 - beyond;
}

double pastRectangle(double x1, double x2, double y1, double y2)
{
    if (x1 >= kLit || y1 >= kLit || y2 <= -kLit) return 1.0;
    const std::complex<double> blocked =
        (knifeEdge(x1) - knifeEdge(x2)) * (knifeEdge(y1) - knifeEdge(y2));
    const double passed = std::min(1.0, std::abs(1.0 - blocked));
    // Blends to 1 from kFade to kLit; the ripples of the far edges would leave a small step at
    // kLit.
    const double lit = std::clamp((x1 - kFade) / (kLit - kFade), 0.0, 1.0);
    return passed + lit * (1.0 - passed);
}

} // namespace midair::bridge
