#include "haptics/probe/Feeling.h"

#include <array>

namespace midair::haptics
{

namespace
{

/// Least forces (mN) of what is faint, clear and strong.
constexpr std::array<double, 3> kHeld_mN = {1.0, 20.0, 60.0};
constexpr std::array<double, 3> kVibrating_mN = {0.1, 1.0, 10.0};
constexpr std::array<double, 3> kCircling_mN = {1.0, 5.0, 15.0};

} // namespace

const char* feelingOf(double force_N, PlayedAs how)
{
    const std::array<double, 3>& steps = how == PlayedAs::HELD        ? kHeld_mN
                                         : how == PlayedAs::VIBRATING ? kVibrating_mN
                                                                      : kCircling_mN;
    const double force_mN = 1e3 * force_N;
    if (!(force_mN >= steps[0])) return kTooWeak; // NaN, too
    if (force_mN < steps[1]) return "faint";
    return force_mN < steps[2] ? "clear" : "strong";
}

} // namespace midair::haptics
