#include "haptics/sensation/SensationSample.h"

#include "haptics/base/Units.h"

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

double DrawnBrush::length_mm() const
{
    constexpr int kSteps = 256;
    double length = 0.0;
    Eigen::Vector2d last = at(0.0);
    for (int step = 1; step <= kSteps; ++step)
    {
        const Eigen::Vector2d next = at(base::kTwoPi * step / kSteps);
        length += (next - last).norm();
        last = next;
    }
    return length;
}

} // namespace midair::haptics
