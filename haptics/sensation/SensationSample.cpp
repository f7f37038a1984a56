#include "haptics/sensation/SensationSample.h"

#include <cmath>

namespace midair::haptics
{

Eigen::Vector2d DrawnBrush::at(double angle_rad) const
{
    const double x = x_mm * std::sin(a * angle_rad + phase_rad);
    const double y = y_mm * std::sin(b * angle_rad);
    const double c = std::cos(rotation_rad);
    const double s = std::sin(rotation_rad);
    return {x * c - y * s, x * s + y * c};
}

} // namespace midair::haptics
