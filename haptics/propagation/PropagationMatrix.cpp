#include "haptics/propagation/PropagationMatrix.h"

#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

// In wavelengths. Nearer to a transducer, R^2 - R0^2 in single precision has an error above 1e-5.
constexpr double kNearest = 0.25;

} // namespace

bool PropagationMatrix::resize(int points)
{
    const bool stale = points > _entries.capacity;
    if (stale)
    {
        _entries.capacity = points;
        _rows.places.resize(3, points);
        _rows.inFloat.resize(static_cast<std::size_t>(points) * _geometry.blocks.size());
        const auto entries =
            static_cast<std::size_t>(_entries.capacity) * static_cast<std::size_t>(_lanes.padded);
        if (_storage == Storage::FLOAT)
            _entries.floats.reserve(2 * entries);
        else
        {
            _entries.fixed.reserve(entries);
            _entries.scale.reserve(static_cast<std::size_t>(_entries.capacity) *
                                   _geometry.blocks.size());
        }
    }
    _points = points;
    return stale;
}

kernels::BlockGeometry PropagationMatrix::geometry(int block) const
{
    const auto stride = static_cast<std::size_t>(_lanes.padded);
    const float* g = _geometry.vectors.data() + offset(block);
    return {g,
            g + stride,
            g + 2 * stride,
            g + 3 * stride,
            g + 4 * stride,
            g + 5 * stride,
            g + 6 * stride,
            g + 7 * stride,
            _geometry.hasOffset ? g + 8 * stride : nullptr,
            _geometry.groups.data() + offset(block) / kernels::kGroup,
            width(block)};
}

// Returns bounds on the distance (in wavelengths) from a point to the transducers within \a bound.
PropagationMatrix::Range PropagationMatrix::rangeOf(const Shell& bound,
                                                    const Eigen::Vector3d& r) const
{
    const double distance = (r - bound.centre).norm();
    return {std::max(bound.nearest - distance, distance - bound.farthest),
            distance + bound.farthest};
}

bool PropagationMatrix::suitsKernel(const Range& range) const
{
    return range.nearest >= kNearest && range.nearest * _wavelength_m >= kNearestDistance_m &&
           _beta * _wavelength_m * (range.farthest + kernels::kLargestRadius) < kernels::kMostDecay;
}

void PropagationMatrix::setPoint(int l, const Eigen::Vector3d& r)
{
    // For a point well inside the array, as in a prism, the bound of the whole array is enough.
    // Otherwise each block's bound is checked, and if that is too wide each of its transducers.
    const Eigen::Vector3d x = r / _wavelength_m;
    _rows.places.col(l) = x;
    const bool all = suitsKernel(rangeOf(_geometry.whole, x));
    unsigned char* inFloat =
        _rows.inFloat.data() + static_cast<std::size_t>(l) * _geometry.blocks.size();
    for (std::size_t b = 0; b < _geometry.blocks.size(); ++b)
    {
        inFloat[b] =
            _geometry.isCompact[b] && (all || suitsKernel(rangeOf(_geometry.blocks[b], x)));
        if (inFloat[b] || !_geometry.isCompact[b]) continue;
        const int block = static_cast<int>(b);
        const auto places = _geometry.places.middleCols(
            offset(block), std::min(width(block), _lanes.count - offset(block)));
        const auto squares = (places.colwise() - x).colwise().squaredNorm();
        inFloat[b] = suitsKernel({std::sqrt(squares.minCoeff()), std::sqrt(squares.maxCoeff())});
    }
}

void PropagationMatrix::buildRows(int block, const int* rows, int count, double* sums)
{
    kernels::PointBatch batch;
    batch.count = 0;
    for (int k = 0; k < count; ++k)
    {
        const int l = rows[k];
        if (!_rows.inFloat[static_cast<std::size_t>(l) * _geometry.blocks.size() +
                           static_cast<std::size_t>(block)])
        {
            sums[l] += static_cast<double>(buildRowInDouble(block, l));
            continue;
        }
        batch.x[batch.count] = _rows.places(0, l);
        batch.y[batch.count] = _rows.places(1, l);
        batch.z[batch.count] = _rows.places(2, l);
        batch.row[batch.count++] = l;
        if (batch.count < kernels::PointBatch::kSize) continue;
        buildBatch(block, batch, sums);
        batch.count = 0;
    }
    if (batch.count == 0) return;
    for (int k = batch.count; k < kernels::PointBatch::kSize; ++k)
    {
        batch.x[k] = batch.x[0];
        batch.y[k] = batch.y[0];
        batch.z[k] = batch.z[0];
    }
    buildBatch(block, batch, sums);
}

void PropagationMatrix::buildBatch(int block, const kernels::PointBatch& batch, double* sums)
{
    const auto first = static_cast<std::size_t>(offset(block)) * _entries.capacity;
    if (_storage == Storage::FLOAT)
        buildBatch(block, batch, kernels::FloatRows{_entries.floats.data() + 2 * first}, sums);
    else
        buildBatch(block,
                   batch,
                   kernels::FixedRows{_entries.fixed.data() + first,
                                      _entries.scale.data() +
                                          static_cast<std::size_t>(block) * _entries.capacity},
                   sums);
}

template<typename Target>
void PropagationMatrix::buildBatch(int block,
                                   const kernels::PointBatch& batch,
                                   const Target& rows,
                                   double* sums)
{
    const auto decay = static_cast<float>(_beta * _wavelength_m);
    float ofBatch[kernels::PointBatch::kSize];
    switch (_array.directivity)
    {
    case Directivity::T4010A1_HARMONICS:
        kernels::buildCubic(geometry(block), batch, decay, _geometry.cubic, rows, ofBatch);
        break;
    case Directivity::T4010A1_TABLE:
        kernels::buildTable(geometry(block), batch, decay, _geometry.table, rows, ofBatch);
        break;
    case Directivity::POINT:
        kernels::buildPoint(geometry(block), batch, decay, {}, rows, ofBatch);
        break;
    }
    for (int k = 0; k < batch.count; ++k)
        sums[batch.row[k]] += static_cast<double>(ofBatch[k]);
}

float PropagationMatrix::buildRowInDouble(int block, int l)
{
    const auto first = static_cast<std::size_t>(offset(block)) * _entries.capacity +
                       static_cast<std::size_t>(l) * static_cast<std::size_t>(width(block));
    const Eigen::Vector3d r = _rows.places.col(l) * _wavelength_m;
    if (_storage == Storage::FLOAT)
        return rowInDouble(block,
                           r,
                           _entries.floats.data() + 2 * first,
                           _entries.floats.data() + 2 * first + width(block));
    alignas(64) float re[kBlockWidth], im[kBlockWidth];
    const float sum = rowInDouble(block, r, re, im);
    _entries
        .scale[static_cast<std::size_t>(block) * _entries.capacity + static_cast<std::size_t>(l)] =
        kernels::packRow(width(block), re, im, _entries.fixed.data() + first);
    return sum;
}

float PropagationMatrix::rowInDouble(int block,
                                     const Eigen::Vector3d& r,
                                     float* re,
                                     float* im) const
{
    double sum = 0.0;
    for (int i = 0; i < width(block); ++i)
    {
        re[i] = im[i] = 0.0f;
        if (offset(block) + i >= _lanes.count || isFiller(offset(block) + i)) continue;
        const int source = _lanes.order[static_cast<std::size_t>(offset(block) + i)];
        const Eigen::Vector3d d = r - _array.positions.col(source);
        const double R = std::max(d.norm(), kNearestDistance_m);
        const double cosTheta = std::clamp(d.dot(_array.normals.col(source)) / R, -1.0, 1.0);
        const double gain = _array.gain.size() > 0 ? _array.gain[source] : 1.0;
        const double a = _array.sourceAmplitude_Pa_m / _unit_Pa * gain *
                         directivity(_array.directivity, cosTheta) / R * std::exp(-_beta * R);
        const double phase = (_geometry.hasOffset ? _array.phaseOffset_rad[source] : 0.0) -
                             base::kTwoPi * R / _wavelength_m;
        re[i] = static_cast<float>(a * std::cos(phase));
        im[i] = static_cast<float>(a * std::sin(phase));
        sum += std::fabs(a);
    }
    return static_cast<float>(sum);
}

void PropagationMatrix::build(const Eigen::Matrix3Xd& points)
{
    resize(static_cast<int>(points.cols()));
    std::vector<int> rows(static_cast<std::size_t>(_points));
    std::vector<double> sums(rows.size());
    for (int l = 0; l < _points; ++l)
    {
        rows[static_cast<std::size_t>(l)] = l;
        setPoint(l, points.col(l));
    }
    for (int b = 0; b < blocks(); ++b)
        buildRows(b, rows.data(), _points, sums.data());
}

void PropagationMatrix::backward(
    int block, const float* wRe, const float* wIm, float* zRe, float* zIm) const
{
    if (_storage == Storage::FIXED)
        return kernels::backward(fixedData(block),
                                 fixedScale(block),
                                 _points,
                                 width(block),
                                 wRe,
                                 wIm,
                                 zRe + offset(block),
                                 zIm + offset(block));
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
    if (_storage == Storage::FIXED) return forwardFrom(block, 0, qRe, qIm, pRe, pIm);
    kernels::forward(blockData(block),
                     _points,
                     width(block),
                     qRe + offset(block),
                     qIm + offset(block),
                     pRe,
                     pIm);
}

void PropagationMatrix::forwardFrom(
    int block, int first, const float* qRe, const float* qIm, float* pRe, float* pIm) const
{
    kernels::forward(fixedData(block) + first,
                     fixedScale(block),
                     _points,
                     width(block),
                     width(block) - first,
                     qRe + offset(block) + first,
                     qIm + offset(block) + first,
                     pRe,
                     pIm);
}

std::complex<float> PropagationMatrix::at(int l, int lane) const
{
    const int block = lane / kBlockWidth;
    const std::size_t place = static_cast<std::size_t>(l) * static_cast<std::size_t>(width(block)) +
                              static_cast<std::size_t>(lane - offset(block));
    if (_storage == Storage::FIXED)
    {
        const std::int32_t pair = fixedData(block)[place];
        const auto low = static_cast<std::int16_t>(pair);
        const std::int32_t high = (pair - low) / 65536; // divides without a remainder
        const float scale = fixedScale(block)[l] * 65536.0f;
        return {scale * static_cast<float>(low), scale * static_cast<float>(high)};
    }
    const float* re = blockData(block) + place +
                      static_cast<std::size_t>(l) * static_cast<std::size_t>(width(block));
    return {re[0], re[width(block)]};
}

} // namespace midair::haptics
