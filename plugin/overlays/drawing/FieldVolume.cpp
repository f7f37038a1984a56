#include "plugin/overlays/drawing/FieldVolume.h"

#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/propagation/PressureField.h"
#include "plugin/overlays/drawing/DiscGeometry.h"
#include "plugin/overlays/drawing/FieldSlice.h"

#include <osgMidair/ColorMap>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

namespace osgMidair
{

namespace
{

constexpr double kVolumePause_s = 0.1;

/// Returns indices that sort \a places by their coordinate \a axis.
std::vector<unsigned int> ordered(const std::vector<osg::Vec3>& places, int axis)
{
    std::vector<unsigned int> order(places.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(),
                     order.end(),
                     [&](unsigned int a, unsigned int b)
                     { return places[a][axis] < places[b][axis]; });
    return order;
}

} // namespace

void VolumeComputer::sample(const VolumeRequest& request)
{
    if (!_field || _array != request.array || !(_medium == request.medium))
    {
        _array = request.array;
        _medium = request.medium;
        _field = std::make_unique<midair::haptics::LatticeField>(*_array, _medium);
    }
    const Eigen::Matrix3Xd& points = request.result->points.positions;
    const Eigen::Vector3d low = points.rowwise().minCoeff().array() - request.margin_m;
    const Eigen::Vector3d high = points.rowwise().maxCoeff().array() + request.margin_m;
    // The lattice is on multiples of the pitch, so that samples stay in place while the object
    // moves.
    double pitch = _medium.wavelength(_array->frequency_Hz) / 3.0;
    for (;; pitch *= 1.25)
    {
        const Eigen::Array3d first = (low.array() / pitch).floor();
        _lattice.count = ((high.array() / pitch).ceil() - first).cast<int>() + 1;
        _lattice.origin = pitch * first.matrix();
        if (_lattice.count.cast<double>().prod() <= kMostSamples) break;
    }
    _lattice.step = pitch * Eigen::Matrix3d::Identity();
    _field->evaluate(_lattice,
                     request.result->played(),
                     _pressure,
                     [&](const Eigen::Vector3d& middle, double radius_m)
                     {
                         return (points.colwise() - middle).colwise().squaredNorm().minCoeff() <
                                (request.margin_m + radius_m) * (request.margin_m + radius_m);
                     });
}

FieldVolume VolumeComputer::compute(const VolumeRequest& request)
{
    const auto begin = std::chrono::steady_clock::now();
    FieldVolume volume;
    volume.frame = request.frame;
    if (request.result->points.size() > 0)
    {
        sample(request);
        volume.pitch_m = _lattice.step(0, 0);
        const float strongest = std::sqrt(_pressure.cwiseAbs2().maxCoeff());
        volume.peak_Pa = static_cast<float>(midair::haptics::radiationPressure(strongest, _medium));
        if (volume.peak_Pa > _range_Pa ||
            (volume.peak_Pa > 0.0F && volume.peak_Pa < 0.8F * _range_Pa))
            _range_Pa = roundedUp(volume.peak_Pa); // silence keeps the scale, as in the slice
        // The threshold refers to the control points, not to a stray maximum that is stronger than
        // all of them.
        const Eigen::VectorXf& achieved_Pa = request.result->achieved_Pa;
        const float wanted_Pa = achieved_Pa.size() > 0
                                    ? static_cast<float>(midair::haptics::radiationPressure(
                                          achieved_Pa.maxCoeff(), _medium))
                                    : volume.peak_Pa;
        const float least_Pa = request.threshold * std::min(wanted_Pa, volume.peak_Pa);
        // Radiation pressure is proportional to the square of the sound pressure.
        const float scale = strongest > 0.0F ? volume.peak_Pa / (strongest * strongest) : 0.0F;
        Eigen::Index k = 0;
        for (int c = 0; c < _lattice.count[2]; ++c)
            for (int b = 0; b < _lattice.count[1]; ++b)
                for (int a = 0; a < _lattice.count[0]; ++a, ++k)
                {
                    const float felt = scale * std::norm(_pressure[k]);
                    if (felt <= 0.0F || felt < least_Pa) continue;
                    const Eigen::Vector3d at = _lattice.at(a, b, c);
                    volume.places.push_back(osg::Vec3(osg::Vec3d(at.x(), at.y(), at.z())));
                    volume.pressure_Pa.push_back(felt);
                    const float share = felt / _range_Pa;
                    volume.colors.push_back(bytes(ColorMap::radiation().color(share),
                                                  std::min(1.0F, 0.15F + 0.9F * share)));
                }
    }
    volume.range_Pa = _range_Pa;
    for (int axis = 0; axis < 3; ++axis)
        volume.orders[axis] = ordered(volume.places, axis);
    volume.compute_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return volume;
}

VolumeWorker::VolumeWorker() : VolumeWorker(std::make_shared<VolumeComputer>()) {}

VolumeWorker::VolumeWorker(const std::shared_ptr<VolumeComputer>& computer) :
    LatestWorker([computer](const VolumeRequest& request)
                 { return std::make_unique<FieldVolume>(computer->compute(request)); },
                 kVolumePause_s)
{
}

} // namespace osgMidair
