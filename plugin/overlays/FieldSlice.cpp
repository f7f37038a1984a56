#include "plugin/overlays/FieldSlice.h"

#include "engine-bridge/HologramResult.h"
#include "haptics/PressureField.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace osgMidair
{

namespace
{

/// Modified Bessel function of order 0 by its power series: what a Kaiser window is made of.
double bessel0(double x)
{
    double term = 1.0;
    double sum = 1.0;
    for (int k = 1; k < 40; ++k)
    {
        term *= (x / (2.0 * k)) * (x / (2.0 * k));
        sum += term;
    }
    return sum;
}

/// sinc under a Kaiser window of half width \a half (samples). beta = 5: side lobes at about a thousandth.
double kernel(double x, double half)
{
    constexpr double kBeta = 5.0;
    if (std::abs(x) >= half) return 0.0;
    const double window =
        bessel0(kBeta * std::sqrt(1.0 - (x / half) * (x / half))) / bessel0(kBeta);
    return window * (std::abs(x) < 1e-9 ? 1.0 : std::sin(M_PI * x) / (M_PI * x));
}

} // namespace

BandLimitedZoom::BandLimitedZoom(int in, int out) : _in(in), _first(out), _weights(kTaps, out)
{
    const double start = kTaps / 2 - 0.5;
    const double end = in - 1 - start;
    for (int o = 0; o < out; ++o)
    {
        const double at = start + (end - start) * o / (out - 1);
        _first[o] = std::clamp(static_cast<int>(std::floor(at)) - kTaps / 2 + 1, 0, in - kTaps);
        for (int t = 0; t < kTaps; ++t)
            _weights(t, o) = static_cast<float>(kernel(at - (_first[o] + t), kTaps / 2.0));
        _weights.col(o) /= _weights.col(o).sum();
    }
}

void BandLimitedZoom::magnitude(const Eigen::MatrixXcf& samples, Eigen::MatrixXf& magnitude) const
{
    const auto out = static_cast<Eigen::Index>(_first.size());
    Eigen::MatrixXcf columns(_in, out); // zoomed along x
    for (Eigen::Index o = 0; o < out; ++o)
        columns.col(o).noalias() = samples.middleCols(_first[o], kTaps) * _weights.col(o);
    magnitude.resize(out, out);
    Eigen::VectorXcf column(out);
    for (Eigen::Index x = 0; x < out; ++x)
    {
        for (Eigen::Index o = 0; o < out; ++o)
            column[o] =
                (columns.col(x).segment<kTaps>(_first[o]).array() * _weights.col(o).array()).sum();
        magnitude.col(x) = column.cwiseAbs();
    }
}

Slice computeSlice(const SliceRequest& request, int threads)
{
    const auto begin = std::chrono::steady_clock::now();
    Slice slice;
    slice.request = request;
    // Samples 0.37 wavelengths apart, with what the zoom needs beyond the rim.
    const double step = 0.37 * request.medium.wavelength(request.array->frequency_Hz);
    const int inner = std::max(2, static_cast<int>(std::ceil(2.0 * request.radius_m / step)));
    const double pitch = 2.0 * request.radius_m / inner;
    const int count = inner + BandLimitedZoom::kTaps;
    const double half = 0.5 * (count - 1);
    const double reach = request.radius_m + (BandLimitedZoom::kTaps / 2) * pitch;
    std::vector<Eigen::Index> at;
    Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(count) * count);
    for (int column = 0; column < count; ++column)
        for (int row = 0; row < count; ++row)
        {
            const double x = (column - half) * pitch;
            const double y = (row - half) * pitch;
            if (x * x + y * y > reach * reach) continue;
            points.col(static_cast<Eigen::Index>(at.size())) =
                request.centre + x * request.u + y * request.v;
            at.push_back(static_cast<Eigen::Index>(column) * count + row);
        }
    points.conservativeResize(3, static_cast<Eigen::Index>(at.size()));
    const Eigen::VectorXcf pressure = midair::haptics::pressureAt(
        points, *request.array, request.medium, request.result->played, threads);
    Eigen::MatrixXcf samples = Eigen::MatrixXcf::Zero(count, count);
    for (std::size_t i = 0; i < at.size(); ++i)
        samples.data()[at[i]] = pressure[static_cast<Eigen::Index>(i)];
    BandLimitedZoom(count, kSlicePixels).magnitude(samples, slice.magnitude_Pa);

    // The corners outside the disc are not computed well, so they can't hold the peak.
    for (int column = 0; column < kSlicePixels; ++column)
        for (int row = 0; row < kSlicePixels; ++row)
        {
            const double x = 2.0 * column / (kSlicePixels - 1) - 1.0;
            const double y = 2.0 * row / (kSlicePixels - 1) - 1.0;
            const float value = slice.magnitude_Pa(row, column);
            if (x * x + y * y <= 1.0 && value > slice.peak_Pa)
            {
                slice.peak_Pa = value;
                slice.peak = request.centre + request.radius_m * (x * request.u + y * request.v);
            }
        }
    slice.compute_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return slice;
}

FieldSliceOverlay::Worker::Worker() : _thread([this] { run(); }) {}

FieldSliceOverlay::Worker::~Worker()
{
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _stop = true;
    }
    _changed.notify_all();
    _thread.join();
}

void FieldSliceOverlay::Worker::submit(SliceRequest request)
{
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _request = std::make_unique<SliceRequest>(std::move(request));
    }
    _changed.notify_all();
}

std::unique_ptr<Slice> FieldSliceOverlay::Worker::take()
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return std::move(_slice);
}

std::unique_ptr<Slice> FieldSliceOverlay::Worker::waitFor(std::uint64_t frame, double timeout_s)
{
    std::unique_lock<std::mutex> lock(_mutex);
    _changed.wait_for(lock,
                      std::chrono::duration<double>(timeout_s),
                      [&] { return _slice && _slice->request.frame >= frame; });
    return std::move(_slice);
}

void FieldSliceOverlay::Worker::run()
{
    std::unique_lock<std::mutex> lock(_mutex);
    for (;;)
    {
        _changed.wait(lock, [&] { return _stop || _request; });
        if (_stop) return;
        const std::unique_ptr<SliceRequest> request = std::move(_request);
        lock.unlock();
        auto slice = std::make_unique<Slice>(computeSlice(*request, 1));
        lock.lock();
        _slice = std::move(slice);
        _changed.notify_all();
    }
}

} // namespace osgMidair
