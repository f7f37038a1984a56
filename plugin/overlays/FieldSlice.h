#pragma once

#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/LatestWorker.h"
#include "haptics/propagation/FieldLattice.h"

#include <osgMidair/Export>

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <vector>

namespace osgMidair
{

/// From samples 0.37 wavelengths apart to any finer grid: a field of one wavelength has no detail
/// below half of it, so a windowed sinc (Kaiser, 12 taps) restores what lies between to half a
/// percent of the peak.
class OSGMIDAIR_EXPORT BandLimitedZoom
{
public:
    static constexpr int kTaps =
        12; ///< the outermost kTaps / 2 samples on every side only support the others

    /// \a out points spread evenly from sample kTaps/2 - 1 + 0.5 to the mirror of it at the far
    /// end; \a in samples, > kTaps.
    BandLimitedZoom(int in, int out);

    /// \a samples in x in, row by row; \a magnitude out x out.
    void magnitude(const Eigen::MatrixXcf& samples, Eigen::MatrixXf& magnitude);

    int inputs() const { return _in; }
    int outputs() const { return static_cast<int>(_first.size()); }

private:
    /// out x n from in x n.
    void zoomColumns(const Eigen::MatrixXf& from, Eigen::MatrixXf& to) const;

    int _in = 0;
    std::vector<int> _first;  ///< out: the first sample that counts
    Eigen::MatrixXf _weights; ///< kTaps x out, columns sum to 1
    Eigen::MatrixXf _part, _once, _turned, _twice;
};

/// A disc that is to be looked at.
struct SliceRequest
{
    std::uint64_t frame = 0;
    std::shared_ptr<const midair::haptics::TransducerArray> array;
    midair::haptics::Medium medium;
    std::shared_ptr<const midair::bridge::HologramResult> result;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    Eigen::Vector3d u = Eigen::Vector3d::UnitX(); ///< unit length
    Eigen::Vector3d v = Eigen::Vector3d::UnitZ();
    double radius_m = 0.1;
    float range_Pa = 0.0F; ///< at the map's upper end; 0: follows the peak in round steps
};

/// What came of it.
struct Slice
{
    std::uint64_t frame = 0; ///< the request's
    SliceRequest request;
    Eigen::MatrixXf magnitude_Pa; ///< kSlicePixels x kSlicePixels: column x along u, row y along v,
                                  ///< from -radius to radius
    std::vector<unsigned char> texels; ///< RGBA, row by row, y upwards
    Eigen::Vector3d peak = Eigen::Vector3d::Zero();
    float peak_Pa = 0.0F;
    float range_Pa = 0.0F;
    double compute_ms = 0.0;
};

constexpr int kSlicePixels = 256;

/// \a value rounded up to two digits: as much of the map as can be is used, and the scale has a
/// legible end.
OSGMIDAIR_EXPORT float roundedUp(float value);

/// How opaque the disc is, 0 .. 1, where |p| is \a share of the range: silence is a little
/// see-through, pressure covers.
inline float sliceOpacity(float share)
{
    return 0.72F + 0.28F * (share < 0.4F ? 2.5F * share : 1.0F);
}
constexpr float kSliceRim = 0.03F; ///< of the radius, in which the disc fades

/// Computes |p| on the square round a request's disc and colours it; only samples that the disc
/// needs are computed. Keeps what the next one can use again.
class OSGMIDAIR_EXPORT SliceComputer
{
public:
    SliceComputer();

    Slice compute(const SliceRequest& request);

private:
    void sample(const SliceRequest& request);
    void findPeak(Slice& slice) const;
    void color(Slice& slice) const;

    std::shared_ptr<const midair::haptics::TransducerArray> _array; ///< of _field
    midair::haptics::Medium _medium;
    std::unique_ptr<midair::haptics::LatticeField> _field;
    std::unique_ptr<BandLimitedZoom> _zoom;
    Eigen::VectorXcf _pressure;
    Eigen::MatrixXcf _samples;
    std::vector<unsigned char> _rim;    ///< opacity of each texel
    std::vector<unsigned char> _colors; ///< RGBA for each step of pressure
    float _range_Pa = 0.0F;
};

/// Computes slices in its own thread.
class SliceWorker : public midair::base::LatestWorker<SliceRequest, Slice>
{
public:
    SliceWorker();

private:
    explicit SliceWorker(const std::shared_ptr<SliceComputer>& computer);
};

} // namespace osgMidair
