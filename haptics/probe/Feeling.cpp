#include "haptics/probe/Feeling.h"

#include <array>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

/// Least forces (mN) of what is faint, clear and strong.
constexpr std::array<double, 3> kHeld_mN = {4.0, 15.0, 40.0};
constexpr std::array<double, 3> kVibrating_mN = {0.4, 2.0, 10.0};
constexpr std::array<double, 3> kCircling_mN = {1.0, 5.0, 15.0};

} // namespace

Strength strengthOf(double force_N, PlayedAs how, double threshold_N)
{
    const std::array<double, 3>& steps = how == PlayedAs::HELD        ? kHeld_mN
                                         : how == PlayedAs::VIBRATING ? kVibrating_mN
                                                                      : kCircling_mN;
    const double published_mN =
        1e3 * force_N * (threshold_N > 0.0 ? 1e-3 * steps[0] / threshold_N : 1.0);
    if (!(published_mN >= steps[0])) return Strength::TOO_WEAK; // NaN, too
    if (published_mN < steps[1]) return Strength::FAINT;
    return published_mN < steps[2] ? Strength::CLEAR : Strength::STRONG;
}

const char* strengthName(Strength strength)
{
    constexpr std::array<const char*, 4> kNames = {"too weak to feel", "faint", "clear", "strong"};
    return kNames.at(static_cast<std::size_t>(strength));
}

std::string forceText(double force_N)
{
    const double force_mN = 1e3 * force_N;
    if (!(force_mN >= 0.05)) return "under 0.1 mN"; // NaN, too
    return fmt::format("{:.{}f} mN", force_mN, force_mN < 9.95 ? 1 : 0);
}

} // namespace midair::haptics
