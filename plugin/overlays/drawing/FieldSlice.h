#pragma once

#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/LatestWorker.h"
#include "haptics/propagation/FieldLattice.h"

#include <osg/Vec3>
#include <osg/Vec4ub>

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace osgMidair
{

/// A field to sample.
struct FieldRequest
{
    std::uint64_t frame = 0;
    std::shared_ptr<const midair::haptics::TransducerArray> array;
    midair::haptics::Medium medium;
    std::shared_ptr<const midair::bridge::HologramResult> result; ///< of that array
};

/// Evaluates the fields of one array after the other. Keeps the array's data and the pressures'
/// memory for the next request.
class FieldSampler
{
public:
    /// Computes the pressure at the places of \a lattice inside the spheres \a wanted, as
    /// LatticeField::evaluate() does.
    const Eigen::VectorXcf& sample(const FieldRequest& request,
                                   const midair::haptics::FieldLattice& lattice,
                                   const midair::haptics::LatticeField::Wanted& wanted)
    {
        if (!_field || _array != request.array || !(_medium == request.medium))
        {
            _array = request.array;
            _medium = request.medium;
            _field = std::make_unique<midair::haptics::LatticeField>(*_array, _medium);
        }
        _field->evaluate(lattice, request.result->played(), _pressure, wanted);
        return _pressure;
    }

private:
    std::shared_ptr<const midair::haptics::TransducerArray> _array; ///< of _field
    midair::haptics::Medium _medium;
    std::unique_ptr<midair::haptics::LatticeField> _field;
    Eigen::VectorXcf _pressure;
};

/// Request for the slice of a field on a disc.
struct SliceRequest : FieldRequest
{
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    Eigen::Vector3d u = Eigen::Vector3d::UnitX(); ///< unit length
    Eigen::Vector3d v = Eigen::Vector3d::UnitZ();
    double radius_m = 0.1;
    float range_Pa = 0.0F; ///< pressure at the map's upper end; 0: follows the peak, rounded up
};

/// A computed slice.
struct Slice
{
    std::uint64_t frame = 0; ///< frame of the request
    SliceRequest request;
    /// kSlicePixels x kSlicePixels: column x along u, row y along v, from -radius to radius
    Eigen::MatrixXf magnitude_Pa;
    std::vector<unsigned char> texels; ///< RGBA, row by row, y upwards
    Eigen::Vector3d peak = Eigen::Vector3d::Zero();
    float peak_Pa = 0.0F;
    float range_Pa = 0.0F; ///< 0: nothing was played yet; all is the colour of silence
    double compute_ms = 0.0;
};

constexpr int kSlicePixels = 256;

/// Returns \a value rounded up to two digits, which uses most of the map and gives the scale a
/// readable end; 1 if \a value is not positive.
float roundedUp(float value);

/// Returns the opacity of the disc, 0 .. 1, if |p| is \a share of the range: silence is slightly
/// transparent, pressure opaque.
inline float sliceOpacity(float share)
{
    return 0.72F + 0.28F * (share < 0.4F ? 2.5F * share : 1.0F);
}
constexpr float kSliceRim = 0.03F; ///< fraction of the radius over which the disc fades

class BandLimitedZoom;

/// Computes |p| on the square around a request's disc and colours it. Computes only samples inside
/// the disc. Keeps buffers and tables for the next request.
class SliceComputer
{
public:
    SliceComputer();
    ~SliceComputer();

    Slice compute(const SliceRequest& request);

private:
    void sample(const SliceRequest& request);
    void findPeak(Slice& slice) const;
    void color(Slice& slice) const;

    FieldSampler _field;
    std::unique_ptr<BandLimitedZoom> _zoom;
    Eigen::MatrixXcf _samples;
    std::vector<unsigned char> _rim;    ///< opacity of each texel due to the rim
    std::vector<unsigned char> _colors; ///< RGBA of each step of pressure
    float _range_Pa = 0.0F;
};

/// Computes slices on a separate thread, always for the newest request.
using SliceWorker = midair::base::LatestWorker<SliceRequest, Slice>;
std::unique_ptr<SliceWorker> startSlices();

/// Request for the volume around the control points of a field.
struct VolumeRequest : FieldRequest
{
    double margin_m = 8e-3;
    float threshold = 0.25F; ///< fraction of the strongest control point's radiation pressure
};

/// A computed volume: a puff (soft disc) for each sample above the threshold.
struct FieldVolume
{
    std::uint64_t frame = 0; ///< frame of the request
    double pitch_m = 0.0;    ///< between samples
    std::vector<osg::Vec3> places;
    std::vector<float> pressure_Pa; ///< radiation pressure of each puff
    std::vector<osg::Vec4ub> colors;
    /// Indices of the puffs, sorted by x, y and z.
    std::array<std::vector<unsigned int>, 3> orders;
    float peak_Pa = 0.0F; ///< radiation pressure
    float range_Pa = 0.0F;
    double compute_ms = 0.0;
};

/// Samples the field a third of a wavelength apart at all places within the margin of a control
/// point.
class VolumeComputer
{
public:
    FieldVolume compute(const VolumeRequest& request);

    /// A volume that needs more samples is sampled more coarsely.
    static constexpr int kMostSamples = 60000;

private:
    const Eigen::VectorXcf& sample(const VolumeRequest& request);

    FieldSampler _field;
    midair::haptics::FieldLattice _lattice;
    float _range_Pa = 0.0F;
};

/// Computes volumes on a separate thread, at most ten per second, to leave time for the slice.
using VolumeWorker = midair::base::LatestWorker<VolumeRequest, FieldVolume>;
std::unique_ptr<VolumeWorker> startVolumes();

} // namespace osgMidair
