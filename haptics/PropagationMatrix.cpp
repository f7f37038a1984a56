#include "haptics/PropagationMatrix.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

constexpr double kTwoPi = 6.283185307179586;

// Where the float kernel holds its 1e-5 (distances in wavelengths): nearer, the phase's correction is no longer small;
// farther, |d_hi|^2 is no longer exact; and the cubic for exp(-beta R) is good to 2e-7 up to here.
constexpr double kNearest = 0.25;
constexpr double kFarthest = 120.0;
constexpr double kLargestExponent = 0.05;

struct Split
{
    float hi, lo;
};

Split split(double x)
{
    const double hi = std::round(x * 32.0) / 32.0;
    return {static_cast<float>(hi), static_cast<float>(x - hi)};
}

bool sameVector(const Eigen::VectorXd& a, const Eigen::VectorXd& b)
{
    return a.size() == b.size() && (a.array() == b.array()).all();
}

// What G depends on; name, board and drive do not matter.
bool sameField(const TransducerArray& a, const TransducerArray& b)
{
    return a.size() == b.size() && a.frequency_Hz == b.frequency_Hz &&
           a.sourceAmplitude_Pa_m == b.sourceAmplitude_Pa_m && a.directivity == b.directivity &&
           (a.positions.array() == b.positions.array()).all() &&
           (a.normals.array() == b.normals.array()).all() &&
           sameVector(a.phaseOffset_rad, b.phaseOffset_rad) && sameVector(a.gain, b.gain);
}

// The harmonics are a cubic in cos(theta) wherever they are positive; four values in front give it.
kernels::DirectivityCubic cubicOf(Directivity model)
{
    const Eigen::Vector4d x(0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0);
    Eigen::Matrix4d V;
    Eigen::Vector4d D;
    for (int i = 0; i < 4; ++i)
    {
        V.row(i) << 1.0, x[i], x[i] * x[i], x[i] * x[i] * x[i];
        D[i] = directivity(model, x[i]);
    }
    const Eigen::Vector4f c = (V.inverse() * D).cast<float>();
    return {c[0], c[1], c[2], c[3]};
}

kernels::DirectivityTable tableOf(Directivity model)
{
    constexpr int kSteps = kernels::DirectivityTable::kSteps;
    const auto level = [model](int step) {
        return std::log2(
            directivity(model, std::max(0.0, std::cos(0.25 * kTwoPi * step / kSteps))));
    };
    kernels::DirectivityTable table{};
    table.start = static_cast<float>(level(0));
    double last = 0.0;
    for (int k = 0; k < kSteps; ++k)
    {
        const double slope = level(k + 1) - level(k);
        table.bend[k] = static_cast<float>(slope - last);
        last = slope;
    }
    return table;
}

} // namespace

bool PropagationMatrix::bind(const TransducerArray& array, const Medium& medium)
{
    if (_wavelength_m > 0.0 && medium == _medium && sameField(array, _array)) return false;
    _array = array;
    _medium = medium;
    _wavelength_m = medium.wavelength(array.frequency_Hz);
    _beta = medium.attenuation(array.frequency_Hz);
    _transducers = array.size();
    _padded = (_transducers + kernels::kLanes - 1) / kernels::kLanes * kernels::kLanes;
    _hasOffset = array.phaseOffset_rad.size() > 0;
    if (array.directivity == Directivity::T4010A1_HARMONICS) _cubic = cubicOf(array.directivity);
    if (array.directivity == Directivity::T4010A1_TABLE) _table = tableOf(array.directivity);
    bindGeometry();
    const int points = _points;
    _points = _capacity = 0;
    resize(points);
    return true;
}

void PropagationMatrix::bindGeometry()
{
    const std::size_t stride = static_cast<std::size_t>(_padded);
    _geometry.reserve(11 * stride);
    float* g = _geometry.data();
    for (int i = 0; i < _padded; ++i, ++g)
    {
        // Padding repeats the last transducer, with no strength.
        const int source = std::min(i, _transducers - 1);
        for (int axis = 0; axis < 3; ++axis)
        {
            const Split s = split(_array.positions(axis, source) / _wavelength_m);
            g[stride * axis] = s.hi;
            g[stride * (3 + axis)] = s.lo;
            g[stride * (6 + axis)] = static_cast<float>(_array.normals(axis, source));
        }
        const double gain = _array.gain.size() > 0 ? _array.gain[source] : 1.0;
        g[stride * 9] = i < _transducers
                            ? static_cast<float>(_array.sourceAmplitude_Pa_m * gain / _wavelength_m)
                            : 0.0f;
        const double turns = _hasOffset ? _array.phaseOffset_rad[source] / kTwoPi : 0.0;
        g[stride * 10] = static_cast<float>(turns - std::round(turns));
    }

    _bounds.resize(static_cast<std::size_t>(blocks()));
    for (int b = 0; b < blocks(); ++b)
    {
        const int count = std::min(width(b), _transducers - offset(b));
        _bounds[static_cast<std::size_t>(b)] = boundOf(offset(b), count);
    }
    _bound = boundOf(0, _transducers);
}

PropagationMatrix::Shell PropagationMatrix::boundOf(int first, int count) const
{
    const auto r = _array.positions.middleCols(first, count);
    const Eigen::Vector3d centre = 0.5 * (r.rowwise().minCoeff() + r.rowwise().maxCoeff());
    const auto squares = (r.colwise() - centre).colwise().squaredNorm();
    return {centre / _wavelength_m,
            std::sqrt(squares.minCoeff()) / _wavelength_m,
            std::sqrt(squares.maxCoeff()) / _wavelength_m};
}

bool PropagationMatrix::resize(int points)
{
    const bool stale = points > _capacity;
    if (stale)
    {
        _capacity = points;
        _rows.resize(static_cast<std::size_t>(points));
        _inFloat.resize(static_cast<std::size_t>(points) * _bounds.size());
        _G.reserve(std::size_t(2) * static_cast<std::size_t>(_capacity) *
                   static_cast<std::size_t>(_padded));
    }
    _points = points;
    return stale;
}

kernels::BlockGeometry PropagationMatrix::geometry(int block) const
{
    const std::size_t stride = static_cast<std::size_t>(_padded);
    const float* g = _geometry.data() + offset(block);
    return {g,
            g + stride,
            g + 2 * stride,
            g + 3 * stride,
            g + 4 * stride,
            g + 5 * stride,
            g + 6 * stride,
            g + 7 * stride,
            g + 8 * stride,
            g + 9 * stride,
            _hasOffset ? g + 10 * stride : nullptr,
            width(block)};
}

// Distances (in wavelengths) from a point to what lies \a distance away with \a bound around it.
PropagationMatrix::Range PropagationMatrix::rangeOf(const Shell& bound,
                                                    const Eigen::Vector3d& r) const
{
    const double distance = (r / _wavelength_m - bound.centre).norm();
    return {std::max(bound.nearest - distance, distance - bound.farthest),
            distance + bound.farthest};
}

bool PropagationMatrix::suitsKernel(const Range& range, double middle) const
{
    return range.nearest >= kNearest && range.nearest * _wavelength_m >= kNearestDistance_m &&
           range.farthest < kFarthest &&
           _beta * _wavelength_m * std::max(range.farthest - middle, middle - range.nearest) <
               kLargestExponent;
}

void PropagationMatrix::setPoint(int l, const Eigen::Vector3d& r)
{
    // Inside the array, where a prism's points are, one look at the whole array is enough; else block by block, and
    // where a block's bounds are too wide transducer by transducer.
    const Range whole = rangeOf(_bound, r);
    const double middle = 0.5 * (std::max(0.0, whole.nearest) + whole.farthest);
    const bool all = suitsKernel(whole, middle);
    unsigned char* inFloat = _inFloat.data() + static_cast<std::size_t>(l) * _bounds.size();
    for (int b = 0; b < blocks(); ++b)
    {
        if (all || suitsKernel(rangeOf(_bounds[static_cast<std::size_t>(b)], r), middle))
        {
            inFloat[b] = 1;
            continue;
        }
        const auto block =
            _array.positions.middleCols(offset(b), std::min(width(b), _transducers - offset(b)));
        const auto squares = (block.colwise() - r).colwise().squaredNorm();
        const Range range = {std::sqrt(squares.minCoeff()) / _wavelength_m,
                             std::sqrt(squares.maxCoeff()) / _wavelength_m};
        inFloat[b] = suitsKernel(range, middle);
    }

    const Eigen::Vector3d x = r / _wavelength_m;
    const double betaLambda = _beta * _wavelength_m;
    const Split sx = split(x[0]), sy = split(x[1]), sz = split(x[2]);
    const double factor = std::exp(-betaLambda * middle);
    Row& row = _rows[static_cast<std::size_t>(l)];
    row.r = r;
    row.setup = {sx.hi, sy.hi, sz.hi, sx.lo, sy.lo, sz.lo, static_cast<float>(middle), {}};
    double term = factor;
    for (int k = 0; k < 4; ++k)
    {
        row.setup.attenuation[k] = static_cast<float>(term);
        term *= betaLambda / (k + 1);
    }
}

float PropagationMatrix::buildRow(int block, int l)
{
    const Row& row = _rows[static_cast<std::size_t>(l)];
    float* re =
        _G.data() + std::size_t(2) * offset(block) * _capacity + std::size_t(2) * l * width(block);
    float* im = re + width(block);
    if (!_inFloat[static_cast<std::size_t>(l) * _bounds.size() + static_cast<std::size_t>(block)])
        return buildRowInDouble(block, row.r, re, im);
    switch (_array.directivity)
    {
    case Directivity::T4010A1_HARMONICS:
        return kernels::buildCubic(geometry(block), row.setup, _cubic, re, im);
    case Directivity::T4010A1_TABLE:
        return kernels::buildTable(geometry(block), row.setup, _table, re, im);
    case Directivity::POINT:
        break;
    }
    return kernels::buildPoint(geometry(block), row.setup, re, im);
}

float PropagationMatrix::buildRowInDouble(int block,
                                          const Eigen::Vector3d& r,
                                          float* re,
                                          float* im) const
{
    double sum = 0.0;
    for (int i = 0; i < width(block); ++i)
    {
        const int source = offset(block) + i;
        re[i] = im[i] = 0.0f;
        if (source >= _transducers) continue;
        const Eigen::Vector3d d = r - _array.positions.col(source);
        const double R = std::max(d.norm(), kNearestDistance_m);
        const double cosTheta = std::clamp(d.dot(_array.normals.col(source)) / R, -1.0, 1.0);
        const double gain = _array.gain.size() > 0 ? _array.gain[source] : 1.0;
        const double a = _array.sourceAmplitude_Pa_m * gain *
                         directivity(_array.directivity, cosTheta) / R * std::exp(-_beta * R);
        const double phase =
            (_hasOffset ? _array.phaseOffset_rad[source] : 0.0) - kTwoPi * R / _wavelength_m;
        re[i] = static_cast<float>(a * std::cos(phase));
        im[i] = static_cast<float>(a * std::sin(phase));
        sum += std::fabs(a);
    }
    return static_cast<float>(sum);
}

void PropagationMatrix::build(const Eigen::Matrix3Xd& points)
{
    resize(static_cast<int>(points.cols()));
    for (int l = 0; l < _points; ++l)
        setPoint(l, points.col(l));
    for (int b = 0; b < blocks(); ++b)
        for (int l = 0; l < _points; ++l)
            buildRow(b, l);
}

void PropagationMatrix::backward(
    int block, const float* wRe, const float* wIm, float* zRe, float* zIm) const
{
    kernels::backward(blockData(block),
                      _points,
                      width(block),
                      wRe,
                      wIm,
                      zRe + offset(block),
                      zIm + offset(block));
}

void PropagationMatrix::forward(
    int block, const float* qRe, const float* qIm, float* pRe, float* pIm) const
{
    kernels::forward(blockData(block),
                     _points,
                     width(block),
                     qRe + offset(block),
                     qIm + offset(block),
                     pRe,
                     pIm);
}

std::complex<float> PropagationMatrix::at(int l, int i) const
{
    const int block = i / kBlockWidth;
    const float* re = blockData(block) + std::size_t(2) * l * width(block) + (i - offset(block));
    return {re[0], re[width(block)]};
}

} // namespace midair::haptics
