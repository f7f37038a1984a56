#include "haptics/array/Directivity.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

struct NamedModel
{
    Directivity model;
    const char* name;
};

constexpr std::array<NamedModel, 3> kModels = {
    {{Directivity::T4010A1_HARMONICS, "t4010a1-harmonics"},
     {Directivity::T4010A1_TABLE, "t4010a1-table"},
     {Directivity::POINT, "point"}}};

// D(theta) = max(0, sum_n c_n sqrt((2n+1)/4pi) P_n(cos theta)) / (that sum at theta = 0), c_n the
// zonal coefficients of Inoue, Makino, Shinoda 2015 read as those of orthonormal Y_n0. (Read as
// coefficients of bare P_n, a third of the amplitude would leave through the board behind the
// transducer.) 1/sqrt(4 pi) cancels. The sum is negative between about 112 and 166 degrees; a
// transducer has no such side lobe, hence the clamp.
double harmonics(double x)
{
    const double b0 = 1.11;
    const double b1 = 1.06 * std::sqrt(3.0);
    const double b2 = 0.24 * std::sqrt(5.0);
    const double b3 = -0.12 * std::sqrt(7.0);
    const double sum =
        b0 + b1 * x + b2 * 0.5 * (3.0 * x * x - 1.0) + b3 * 0.5 * x * (5.0 * x * x - 3.0);
    return std::max(0.0, sum / (b0 + b1 + b2 + b3));
}

// Data sheet of the T4010A1 (Nippon Ceramic): dB at 0, 10, .. 90 degrees, interpolated linearly in
// dB over the angle.
double table(double x)
{
    constexpr std::array<double, 10> kLevel_dB = {0, 0, 0, -1, -3, -6, -9, -12, -14, -15};
    if (x < 0.0) return 0.0;
    const double step = std::acos(std::min(x, 1.0)) * 18.0 / base::kPi;
    const int k = std::clamp(static_cast<int>(step), 0, 8);
    const double t = step - k;
    const double level_dB = kLevel_dB[k] + t * (kLevel_dB[k + 1] - kLevel_dB[k]);
    return std::pow(10.0, level_dB / 20.0);
}

} // namespace

double directivity(Directivity model, double cosTheta)
{
    switch (model)
    {
    case Directivity::T4010A1_HARMONICS:
        return harmonics(cosTheta);
    case Directivity::T4010A1_TABLE:
        return table(cosTheta);
    case Directivity::POINT:
        break;
    }
    return 1.0;
}

const char* directivityName(Directivity model)
{
    for (const NamedModel& known : kModels)
        if (known.model == model) return known.name;
    return "unknown";
}

Directivity directivityFromName(const std::string& name)
{
    std::vector<const char*> names;
    for (const NamedModel& known : kModels)
    {
        if (name == known.name) return known.model;
        names.push_back(known.name);
    }
    throw base::InputError(
        fmt::format("unknown directivity '{}'; known are {}", name, fmt::join(names, ", ")));
}

} // namespace midair::haptics
