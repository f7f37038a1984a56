#pragma once

#include "haptics/Medium.h"
#include "haptics/TransducerArray.h"

#include <osgMidair/FieldSliceOverlay>

#include <Eigen/Core>

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace osgMidair
{

/// From samples 0.37 wavelengths apart to any finer grid: a field of one wavelength has no detail below half of
/// it, so a windowed sinc (Kaiser, 12 taps) restores what lies between to half a percent of the peak.
class OSGMIDAIR_EXPORT BandLimitedZoom
{
public:
    static constexpr int kTaps =
        12; ///< the outermost kTaps / 2 samples on every side only support the others

    /// \a out points spread evenly from sample kTaps/2 - 1 + 0.5 to the mirror of it at the far end; \a in samples, > kTaps.
    BandLimitedZoom(int in, int out);

    /// \a samples in x in, row by row; \a magnitude out x out.
    void magnitude(const Eigen::MatrixXcf& samples, Eigen::MatrixXf& magnitude) const;

    int inputs() const { return _in; }

private:
    int _in = 0;
    std::vector<int> _first;  ///< out: the first sample that counts
    Eigen::MatrixXf _weights; ///< kTaps x out, columns sum to 1
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
};

/// What came of it.
struct Slice
{
    SliceRequest request;
    Eigen::MatrixXf
        magnitude_Pa; ///< kSlicePixels x kSlicePixels: column x along u, row y along v, from -radius to radius
    Eigen::Vector3d peak = Eigen::Vector3d::Zero();
    float peak_Pa = 0.0F;
    double compute_ms = 0.0;
};

constexpr int kSlicePixels = 256;

/// Computes |p| on the square round the disc of \a request; only samples that the disc needs are computed.
OSGMIDAIR_EXPORT Slice computeSlice(const SliceRequest& request, int threads);

/// Computes slices in its own thread: the newest request wins, the newest slice is kept.
class FieldSliceOverlay::Worker
{
public:
    Worker();
    ~Worker();
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    void submit(SliceRequest request);
    /// The newest slice not taken yet, or null.
    std::unique_ptr<Slice> take();
    /// Waits for a slice of \a frame or later.
    std::unique_ptr<Slice> waitFor(std::uint64_t frame, double timeout_s);

private:
    void run();

    std::mutex _mutex;
    std::condition_variable _changed;
    std::unique_ptr<SliceRequest> _request;
    std::unique_ptr<Slice> _slice;
    bool _stop = false;
    std::thread _thread;
};

} // namespace osgMidair
