#include "plugin/overlays/drawing/FieldSlice.h"

#include "haptics/base/Units.h"
#include "haptics/propagation/PressureField.h"
#include "plugin/overlays/drawing/DiscGeometry.h"

#include <osgMidair/ColorMap>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

namespace osgMidair
{

namespace
{

constexpr int kColorSteps = 1024; ///< steps of pressure from 0 to the map's end

/// Modified Bessel function of order 0 by its power series, for the Kaiser window.
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

/// Sinc times a Kaiser window of half width \a half (samples). With beta = 5 side lobes are at
/// about a thousandth.
double kernel(double x, double half)
{
    constexpr double kBeta = 5.0;
    if (std::abs(x) >= half) return 0.0;
    const double window =
        bessel0(kBeta * std::sqrt(1.0 - (x / half) * (x / half))) / bessel0(kBeta);
    return window *
           (std::abs(x) < 1e-9 ? 1.0 : std::sin(midair::base::kPi * x) / (midair::base::kPi * x));
}

/// Position of a texel in its row, -1 .. 1.
float place(int texel)
{
    constexpr float kMiddle = 0.5F * (kSlicePixels - 1);
    return (static_cast<float>(texel) - kMiddle) / kMiddle;
}

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

/// Interpolates samples 0.37 wavelengths apart to a finer grid. A field of one wavelength has no
/// detail below half of it, so a windowed sinc (Kaiser, 12 taps) restores the values in between to
/// half a percent of the peak.
class BandLimitedZoom
{
public:
    /// the outermost kTaps / 2 samples on every side only support the interpolation
    static constexpr int kTaps = 12;

    /// \a in: number of samples, > kTaps. \a out: number of points, spread evenly from sample
    /// kTaps/2 - 1 + 0.5 to its mirror at the far end.
    BandLimitedZoom(int in, int out) : _in(in), _first(out), _weights(kTaps, out)
    {
        const double start = 0.5 * kTaps - 0.5;
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

    /// Computes the magnitude (out x out) of \a samples (in x in).
    void magnitude(const Eigen::MatrixXcf& samples, Eigen::MatrixXf& magnitude)
    {
        magnitude.resize(outputs(), outputs());
        for (const bool imaginary : {false, true})
        {
            if (imaginary)
                _part = samples.imag();
            else
                _part = samples.real();
            zoomColumns(_part, _once);
            _turned = _once.transpose();
            zoomColumns(_turned, _twice);
            if (imaginary)
                magnitude = (magnitude.array() + _twice.array().square()).sqrt();
            else
                magnitude = _twice.array().square();
        }
        magnitude.transposeInPlace();
    }

    int inputs() const { return _in; }
    int outputs() const { return static_cast<int>(_first.size()); }

private:
    /// Interpolates the columns of \a from (n x in) to those of \a to (n x out).
    void zoomColumns(const Eigen::MatrixXf& from, Eigen::MatrixXf& to) const
    {
        // The matrix is column-major, so whole columns are summed.
        to.resize(from.rows(), outputs());
        for (int o = 0; o < outputs(); ++o)
            to.col(o).noalias() = from.middleCols<kTaps>(_first[o]) * _weights.col(o);
    }

    int _in = 0;
    std::vector<int> _first;  ///< for each output: the first sample that it uses
    Eigen::MatrixXf _weights; ///< kTaps x out; columns sum to 1
    Eigen::MatrixXf _part, _once, _turned, _twice;
};

float roundedUp(float value)
{
    if (!(value > 0.0F)) return 1.0F;
    const float step = std::pow(10.0F, std::floor(std::log10(value)) - 1.0F);
    return step * std::ceil(value / step);
}

SliceComputer::SliceComputer() :
    _rim(static_cast<std::size_t>(kSlicePixels) * kSlicePixels),
    _colors(4 * (kColorSteps + 1))
{
    for (int row = 0; row < kSlicePixels; ++row)
        for (int column = 0; column < kSlicePixels; ++column)
            _rim[static_cast<std::size_t>(row) * kSlicePixels + column] =
                static_cast<unsigned char>(std::lround(
                    255.0F * std::clamp((1.0F - std::hypot(place(column), place(row))) / kSliceRim,
                                        0.0F,
                                        1.0F)));
    for (int i = 0; i <= kColorSteps; ++i)
    {
        const float share = static_cast<float>(i) / kColorSteps;
        const osg::Vec4ub color = bytes(ColorMap::pressure().color(share), sliceOpacity(share));
        std::copy_n(color.ptr(), 4, &_colors[4 * static_cast<std::size_t>(i)]);
    }
}

SliceComputer::~SliceComputer() = default;

void SliceComputer::sample(const SliceRequest& request)
{
    // Samples are 0.37 wavelengths apart and extend beyond the rim as far as the zoom needs.
    const double step = 0.37 * request.medium.wavelength(request.array->frequency_Hz);
    const int inner = std::max(2, static_cast<int>(std::ceil(2.0 * request.radius_m / step)));
    const double pitch = 2.0 * request.radius_m / inner;
    const int count = inner + BandLimitedZoom::kTaps;
    const double half = 0.5 * (count - 1);
    const double reach = request.radius_m + 0.5 * BandLimitedZoom::kTaps * pitch;
    midair::haptics::FieldLattice lattice;
    lattice.count = {count, count, 1}; // the first axis runs down the columns of _samples
    lattice.step.col(0) = pitch * request.v;
    lattice.step.col(1) = pitch * request.u;
    lattice.origin = request.centre - half * (lattice.step.col(0) + lattice.step.col(1));
    const auto wanted = [&](const Eigen::Vector3d& middle, double radius_m)
    { return (middle - request.centre).norm() < reach + radius_m; };
    const Eigen::VectorXcf& pressure = _field.sample(request, lattice, wanted);
    _samples = Eigen::Map<const Eigen::MatrixXcf>(pressure.data(), count, count);
    if (!_zoom || _zoom->inputs() != count)
        _zoom = std::make_unique<BandLimitedZoom>(count, kSlicePixels);
}

void SliceComputer::findPeak(Slice& slice) const
{
    // Corners outside the disc are not computed accurately, so they are skipped.
    for (int column = 0; column < kSlicePixels; ++column)
    {
        const float x = place(column);
        const int inside = static_cast<int>(
            std::floor(0.5F * (kSlicePixels - 1) * std::sqrt(std::max(0.0F, 1.0F - x * x))));
        const int first = kSlicePixels / 2 - std::min(kSlicePixels / 2, inside);
        Eigen::Index row = 0;
        const float most =
            slice.magnitude_Pa.col(column).segment(first, kSlicePixels - 2 * first).maxCoeff(&row);
        if (first == kSlicePixels / 2 || most <= slice.peak_Pa) continue;
        slice.peak_Pa = most;
        slice.peak =
            slice.request.centre +
            slice.request.radius_m *
                (x * slice.request.u + place(first + static_cast<int>(row)) * slice.request.v);
    }
}

void SliceComputer::color(Slice& slice) const
{
    slice.texels.resize(4 * _rim.size());
    unsigned char* texel = slice.texels.data();
    const unsigned char* rim = _rim.data();
    // Before the first field there is no range, and everything is silent.
    const float scale = slice.range_Pa > 0.0F ? kColorSteps / slice.range_Pa : 0.0F;
    for (int row = 0; row < kSlicePixels; ++row)
        for (int column = 0; column < kSlicePixels; ++column, texel += 4, ++rim)
        {
            const float step = slice.magnitude_Pa(row, column) * scale + 0.5F;
            const unsigned char* from =
                &_colors[4 * static_cast<std::size_t>(step < kColorSteps ? step : kColorSteps)];
            std::copy_n(from, 3, texel);
            texel[3] = static_cast<unsigned char>(from[3] * *rim / 255);
        }
}

Slice SliceComputer::compute(const SliceRequest& request)
{
    const auto begin = std::chrono::steady_clock::now();
    Slice slice;
    slice.frame = request.frame;
    slice.request = request;
    sample(request);
    _zoom->magnitude(_samples, slice.magnitude_Pa);
    findPeak(slice);
    if (request.range_Pa > 0.0F)
        _range_Pa = request.range_Pa;
    else if (slice.peak_Pa > _range_Pa ||
             (slice.peak_Pa > 0.0F && slice.peak_Pa < 0.85F * _range_Pa))
        _range_Pa = roundedUp(slice.peak_Pa); // silence keeps the previous scale
    slice.range_Pa = _range_Pa;
    color(slice);
    slice.compute_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return slice;
}

std::unique_ptr<SliceWorker> startSlices()
{
    return std::make_unique<SliceWorker>(
        [computer = std::make_shared<SliceComputer>()](const SliceRequest& request)
        { return std::make_unique<Slice>(computer->compute(request)); });
}

const Eigen::VectorXcf& VolumeComputer::sample(const VolumeRequest& request)
{
    const Eigen::Matrix3Xd& points = request.result->points.positions;
    const Eigen::Vector3d low = points.rowwise().minCoeff().array() - request.margin_m;
    const Eigen::Vector3d high = points.rowwise().maxCoeff().array() + request.margin_m;
    // The lattice is on multiples of the pitch, so that samples stay in place while the object
    // moves.
    double pitch = request.medium.wavelength(request.array->frequency_Hz) / 3.0;
    for (;; pitch *= 1.25)
    {
        const Eigen::Array3d first = (low.array() / pitch).floor();
        _lattice.count = ((high.array() / pitch).ceil() - first).cast<int>() + 1;
        _lattice.origin = pitch * first.matrix();
        if (_lattice.count.cast<double>().prod() <= kMostSamples) break;
    }
    _lattice.step = pitch * Eigen::Matrix3d::Identity();
    const auto wanted = [&](const Eigen::Vector3d& middle, double radius_m)
    {
        return (points.colwise() - middle).colwise().squaredNorm().minCoeff() <
               (request.margin_m + radius_m) * (request.margin_m + radius_m);
    };
    return _field.sample(request, _lattice, wanted);
}

FieldVolume VolumeComputer::compute(const VolumeRequest& request)
{
    const auto begin = std::chrono::steady_clock::now();
    FieldVolume volume;
    volume.frame = request.frame;
    if (request.result->points.size() > 0)
    {
        const Eigen::VectorXcf& pressure = sample(request);
        volume.pitch_m = _lattice.step(0, 0);
        const float strongest = std::sqrt(pressure.cwiseAbs2().maxCoeff());
        volume.peak_Pa =
            static_cast<float>(midair::haptics::radiationPressure(strongest, request.medium));
        if (volume.peak_Pa > _range_Pa ||
            (volume.peak_Pa > 0.0F && volume.peak_Pa < 0.8F * _range_Pa))
            _range_Pa = roundedUp(volume.peak_Pa); // silence keeps the scale, as in the slice
        // The threshold refers to the control points, not to a stray maximum that is stronger than
        // all of them.
        const Eigen::VectorXf& achieved_Pa = request.result->achieved_Pa;
        const float wanted_Pa = achieved_Pa.size() > 0
                                    ? static_cast<float>(midair::haptics::radiationPressure(
                                          achieved_Pa.maxCoeff(), request.medium))
                                    : volume.peak_Pa;
        const float least_Pa = request.threshold * std::min(wanted_Pa, volume.peak_Pa);
        // Radiation pressure is proportional to the square of the sound pressure.
        const float scale = strongest > 0.0F ? volume.peak_Pa / (strongest * strongest) : 0.0F;
        Eigen::Index k = 0;
        for (int c = 0; c < _lattice.count[2]; ++c)
            for (int b = 0; b < _lattice.count[1]; ++b)
                for (int a = 0; a < _lattice.count[0]; ++a, ++k)
                {
                    const float felt = scale * std::norm(pressure[k]);
                    if (felt <= 0.0F || felt < least_Pa) continue;
                    volume.places.push_back(osgVec(_lattice.at(a, b, c)));
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

std::unique_ptr<VolumeWorker> startVolumes()
{
    return std::make_unique<VolumeWorker>(
        [computer = std::make_shared<VolumeComputer>()](const VolumeRequest& request)
        { return std::make_unique<FieldVolume>(computer->compute(request)); },
        kVolumePause_s);
}

} // namespace osgMidair
