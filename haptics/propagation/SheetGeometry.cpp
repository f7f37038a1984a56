#include "haptics/propagation/SheetGeometry.h"

#include "haptics/propagation/Reflections.h"
#include "haptics/propagation/kernels/KernelTools.h"

#include <algorithm>

namespace midair::haptics
{

namespace
{

constexpr float kLeastHeight = 1e-20F; // far below any distance that matters

} // namespace

void SheetGeometry::bind(const std::vector<Reflector>& reflectors,
                         const Eigen::Matrix3Xd& places,
                         int padded,
                         double wavelength_m)
{
    _sheets.clear();
    _padded = padded;
    for (Reflector one : reflectors)
    {
        if (one.reflection == 0.0) continue;
        one.position /= wavelength_m;
        one.size_m /= wavelength_m;
        _sheets.push_back(one);
    }
    if (_sheets.empty()) return;
    _lanes.reserve(3 * _sheets.size() * static_cast<std::size_t>(padded));
    float* out = _lanes.data();
    for (const Reflector& one : _sheets)
    {
        for (const Eigen::Vector3d& axis : {one.normal, one.along, one.across()})
            for (int lane = 0; lane < padded; ++lane) // padding repeats the last lane
                *out++ = static_cast<float>(axis.dot(
                    places.col(std::min<Eigen::Index>(lane, places.cols() - 1)) - one.position));
        const double onIt =
            one.isBoard ? (kOnBoard_m + 1e-3 * one.accuracy_mm) / wavelength_m : 0.0;
        float* heights = out - 3 * padded;
        std::for_each(heights,
                      heights + padded,
                      [=](float& height)
                      {
                          if (one.isBoard && std::fabs(height) <= onIt)
                              height = 0.0F;
                          else if (height == 0.0F)
                              height = kLeastHeight; // in its plane, it counts as in front
                      });
    }
}

bool SheetGeometry::isReflecting(int k, const Eigen::Vector3d& x, int first, int width) const
{
    const bool isFront = _sheets[static_cast<std::size_t>(k)].heightOf(x) >= 0.0;
    const float* heights = lanes(k, 0) + first;
    return std::any_of(heights,
                       heights + width,
                       [isFront](float height) { return isFront ? height > 0.0F : height < 0.0F; });
}

bool SheetGeometry::isWhollyBeside(int k, bool inFront, int first, int width) const
{
    const float* heights = lanes(k, 0) + first;
    return std::all_of(heights,
                       heights + width,
                       [inFront](float height) { return inFront ? height > 0.0F : height < 0.0F; });
}

kernels::SheetView SheetGeometry::view(int k, int first) const
{
    return {{lanes(k, 0) + first, lanes(k, 1) + first, lanes(k, 2) + first},
            static_cast<float>(0.5 * sheet(k).size_m[0]),
            static_cast<float>(0.5 * sheet(k).size_m[1])};
}

kernels::SheetPoint SheetGeometry::seen(int k, const Eigen::Vector3d& x) const
{
    const Reflector& one = sheet(k);
    const Eigen::Vector3d d = x - one.position;
    return {static_cast<float>(one.normal.dot(d)),
            static_cast<float>(one.along.dot(d)),
            static_cast<float>(one.across().dot(d))};
}

void SheetGeometry::reflect(
    int k, const Eigen::Vector3d& x, int first, int width, kernels::Waves row) const
{
    const Reflector& one = sheet(k);
    const std::complex<double> turned = factorOf(one);
    const kernels::SheetFactor factor{static_cast<float>(turned.real()),
                                      static_cast<float>(turned.imag()),
                                      static_cast<float>(one.reflection)};
    row.heights = lanes(k, 0) + first;
    const kernels::SheetPoint point = seen(k, x);
    if (!one.size_m.allFinite()) return kernels::reflect(width, point.height, factor, row);
    alignas(64) float shareRe[kernels::kMaxWidth], shareIm[kernels::kMaxWidth];
    kernels::sharesTurned(width, view(k, first), point, shareRe, shareIm);
    kernels::reflect(width, point.height, factor, shareRe, shareIm, row);
}

} // namespace midair::haptics
