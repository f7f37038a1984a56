#pragma once

#include <limits>

namespace midair::bridge
{

constexpr double kR = 8e-3;       ///< of a fingertip, m
constexpr double kField_s = 1e-3; ///< between fields
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

} // namespace midair::bridge
