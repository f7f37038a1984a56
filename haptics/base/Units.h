#pragma once

/// Unit conversions.
namespace midair::base
{

constexpr double kPi = 3.14159265358979323846;
constexpr double kTwoPi = 2.0 * kPi;
constexpr double kZeroCelsius_K = 273.15;

constexpr double toDegrees(double angle_rad)
{
    return angle_rad * 180.0 / kPi;
}

constexpr double toRadians(double angle_deg)
{
    return angle_deg * kPi / 180.0;
}

constexpr double toKelvin(double temperature_C)
{
    return temperature_C + kZeroCelsius_K;
}

} // namespace midair::base
