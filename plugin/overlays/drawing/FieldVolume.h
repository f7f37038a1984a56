#pragma once

#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/LatestWorker.h"
#include "haptics/propagation/FieldLattice.h"

#include <osg/Vec3>
#include <osg/Vec4ub>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace osgMidair
{

/// Request for the volume around the control points of a field.
struct VolumeRequest
{
    std::uint64_t frame = 0;
    std::shared_ptr<const midair::haptics::TransducerArray> array;
    midair::haptics::Medium medium;
    std::shared_ptr<const midair::bridge::HologramResult> result;
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

/// Samples the field a third of a wavelength apart in all places within the margin of a control
/// point.
class VolumeComputer
{
public:
    FieldVolume compute(const VolumeRequest& request);

    /// A volume that needs more samples is sampled more coarsely.
    static constexpr int kMostSamples = 60000;

private:
    void sample(const VolumeRequest& request);

    std::shared_ptr<const midair::haptics::TransducerArray> _array; ///< of _field
    midair::haptics::Medium _medium;
    std::unique_ptr<midair::haptics::LatticeField> _field;
    midair::haptics::FieldLattice _lattice;
    Eigen::VectorXcf _pressure;
    float _range_Pa = 0.0F;
};

/// Computes volumes on its own thread, at most ten per second, to leave time for the slice.
class VolumeWorker : public midair::base::LatestWorker<VolumeRequest, FieldVolume>
{
public:
    VolumeWorker();

private:
    explicit VolumeWorker(const std::shared_ptr<VolumeComputer>& computer);
};

} // namespace osgMidair
