#include "haptics/propagation/PropagationMatrix.h"

#include "haptics/base/Units.h"
#include "haptics/propagation/TransducerGroups.h"
#include "haptics/propagation/kernels/MirroredRowKernels.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>

namespace midair::haptics
{

namespace
{

// In wavelengths. Closer to a transducer, R^2 - R0^2 in single precision has an error above 1e-5.
constexpr double kNearest = 0.25;

constexpr double kPlanar = 1e-7;           // largest distance from the plane, wavelengths
constexpr double kMostDecayInGroup = 0.02; // up to here a parabola approximates exp to 1e-6
constexpr double kLeastBeta = 1e-9;        // Np/m
constexpr double kWithin = 0.999;          // of a bound, since radii are rounded to floats

template<typename Matrix>
bool sameEntries(const Matrix& a, const Matrix& b)
{
    return a.size() == b.size() &&
           (a.data() == b.data() ||
            std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) ==
                0);
}

// Returns true if everything that G depends on is equal; name, boards and drive do not matter.
bool sameField(const TransducerArray& a, const TransducerArray& b)
{
    if (&a == &b) return true;
    return a.size() == b.size() && a.frequency_Hz == b.frequency_Hz &&
           a.sourceAmplitude_Pa_m == b.sourceAmplitude_Pa_m && a.directivity == b.directivity &&
           sameEntries(a.positions, b.positions) && sameEntries(a.normals, b.normals) &&
           sameEntries(a.phaseOffset_rad, b.phaseOffset_rad) && sameEntries(a.gain, b.gain) &&
           a.reflectors == b.reflectors;
}

// See PropagationMatrix::unit_Pa().
double unitOf(const TransducerArray& array)
{
    const double strength = array.sourceAmplitude_Pa_m *
                            (array.gain.size() > 0 ? array.gain.cwiseAbs().maxCoeff() : 1.0);
    const bool isUsual = strength >= 0x1p-10 && strength <= 0x1p10;
    return isUsual || !(strength > 0.0) ? 1.0 : std::ldexp(1.0, std::ilogb(strength));
}

// Returns a bound on D: its maximum on a fine grid of cosines, with a margin.
float largestOf(Directivity model)
{
    double largest = 0.0;
    for (int k = 0; k <= 1000; ++k)
        largest = std::max(largest, directivity(model, 1e-3 * k));
    return static_cast<float>(1.001 * largest);
}

// Where the harmonics are positive they are a cubic in cos(theta), so four values in the front half
// determine it.
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
    return {largestOf(model), c[0], c[1], c[2], c[3]};
}

kernels::DirectivityTable tableOf(Directivity model)
{
    constexpr int kSteps = kernels::DirectivityTable::kSteps;
    const auto level = [model](int step)
    {
        return std::log2(
            directivity(model, std::max(0.0, std::cos(0.25 * base::kTwoPi * step / kSteps))));
    };
    kernels::DirectivityTable table{};
    table.largest = largestOf(model);
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

// Rows of points on the transducers' side of a reflector.
struct MirroredRows : kernels::FixedRows
{
    const kernels::PointBatch* images;
    kernels::Mirror mirror;
};

// Calls the kernel for the rows' kind.
template<typename Plain, typename Mirrored, typename Model, typename Target>
void callKernel(const Plain& plain,
                const Mirrored& mirrored,
                const kernels::BlockGeometry& block,
                const kernels::PointBatch& batch,
                float decay,
                const Model& D,
                const Target& rows,
                float* sums)
{
    if constexpr (std::is_same_v<Target, MirroredRows>)
        mirrored(block, batch, *rows.images, rows.mirror, decay, D, rows, sums);
    else
        plain(block, batch, decay, D, rows, sums);
}

void append(const Eigen::Vector3d& x, int row, kernels::PointBatch& batch)
{
    batch.x[batch.count] = x[0];
    batch.y[batch.count] = x[1];
    batch.z[batch.count] = x[2];
    batch.row[batch.count++] = row;
}

// Kernels read all places of a batch.
void fillUp(kernels::PointBatch& batch)
{
    for (int k = batch.count; k < kernels::PointBatch::kSize; ++k)
    {
        batch.x[k] = batch.x[0];
        batch.y[k] = batch.y[0];
        batch.z[k] = batch.z[0];
    }
}

} // namespace

bool PropagationMatrix::resize(int points)
{
    const bool stale = points > _entries.capacity;
    if (stale)
    {
        _entries.capacity = points;
        _rows.places.resize(3, points);
        _rows.inFloat.resize(static_cast<std::size_t>(points) * _geometry.blocks.size() *
                             static_cast<std::size_t>(1 + _sheets.size()));
        const auto entries =
            static_cast<std::size_t>(_entries.capacity) * static_cast<std::size_t>(_lanes.padded);
        if (_storage == Storage::FLOAT)
            _entries.floats.reserveUnset(2 * entries);
        else
        {
            _entries.fixed.reserveUnset(entries);
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
    const Eigen::Vector3d x = r / _wavelength_m;
    _rows.places.col(l) = x;
    const std::size_t blocks = _geometry.blocks.size();
    unsigned char* inFloat =
        _rows.inFloat.data() + static_cast<std::size_t>(l * (1 + _sheets.size())) * blocks;
    findRange(x, inFloat);
    for (int k = 0; k < _sheets.size(); ++k)
        findRange(_sheets.mirrored(k, x), inFloat += blocks);
}

void PropagationMatrix::findRange(const Eigen::Vector3d& x, unsigned char* inFloat) const
{
    // For a point well inside the array, as in a prism, the bound of the whole array is enough.
    // Otherwise each block's bound is checked, and if that is too wide each of its transducers.
    const bool all = suitsKernel(rangeOf(_geometry.whole, x));
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

bool PropagationMatrix::isInFloat(int l, int image, int block) const
{
    return _rows.inFloat[static_cast<std::size_t>(l * (1 + _sheets.size()) + image) *
                             _geometry.blocks.size() +
                         static_cast<std::size_t>(block)] != 0;
}

void PropagationMatrix::buildRows(int block, const int* rows, int count, double* sums)
{
    const bool isAlone = !hasOutside() && !_outside.rows_Pa;
    if (isAlone && _sheets.size() == 1 && _storage == Storage::FIXED)
        return buildMirroredRows(block, rows, count, sums);
    if (!isAlone || _sheets.size() > 0) return buildSummedRows(block, rows, count, sums);
    kernels::PointBatch batch;
    batch.count = 0;
    const auto flush = [&]
    {
        if (batch.count == 0) return;
        fillUp(batch);
        buildBatch(block, batch, sums);
        batch.count = 0;
    };
    for (int k = 0; k < count; ++k)
    {
        const int l = rows[k];
        if (!isInFloat(l, 0, block))
        {
            sums[l] += static_cast<double>(buildRowInDouble(block, l));
            continue;
        }
        append(_rows.places.col(l), l, batch);
        if (batch.count == kernels::PointBatch::kSize) flush();
    }
    flush();
}

// A lone reflector has a kernel of its own, for points on the side of all transducers of the block.
void PropagationMatrix::buildMirroredRows(int block, const int* rows, int count, double* sums)
{
    const Reflector& sheet = _sheets.sheet(0);
    const bool isInFront = _sheets.isWhollyBeside(0, true, offset(block), width(block));
    const bool isBehind = _sheets.isWhollyBeside(0, false, offset(block), width(block));
    kernels::PointBatch batch, images;
    kernels::MirrorEnds ends;
    ends.sheet = _sheets.view(0, offset(block));
    batch.count = images.count = 0;
    MirroredRows mirrored;
    mirrored.entries =
        _entries.fixed.data() + static_cast<std::size_t>(offset(block)) * _entries.capacity;
    mirrored.scale = _entries.scale.data() + static_cast<std::size_t>(block) * _entries.capacity;
    mirrored.images = &images;
    mirrored.mirror = {
        static_cast<float>(sheet.reflection),
        static_cast<float>(std::remainder(sheet.reflectionPhase_rad / base::kTwoPi, 1.0)),
        sheet.size_m.allFinite() ? &ends : nullptr};
    const auto flush = [&]
    {
        if (batch.count == 0) return;
        fillUp(batch);
        fillUp(images);
        buildBatch(block, batch, mirrored, sums);
        batch.count = images.count = 0;
    };
    int others[kernels::PointBatch::kSize], otherCount = 0;
    for (int k = 0; k < count; ++k)
    {
        const int l = rows[k];
        const Eigen::Vector3d x = _rows.places.col(l);
        if ((sheet.heightOf(x) >= 0.0 ? isInFront : isBehind) && isInFloat(l, 0, block) &&
            isInFloat(l, 1, block))
        {
            ends.points[batch.count] = _sheets.seen(0, x);
            append(x, l, batch);
            append(_sheets.mirrored(0, x), l, images);
        }
        else
            others[otherCount++] = l;
        if (batch.count == kernels::PointBatch::kSize) flush();
        if (otherCount == kernels::PointBatch::kSize || k + 1 == count)
        {
            buildSummedRows(block, others, otherCount, sums);
            otherCount = 0;
        }
    }
    flush();
}

// Computes the free waves at points, or at the images of them in reflector  image - 1, one row of
// [re width][im width] after the other. At most kernels::PointBatch::kSize.
void PropagationMatrix::freeWaves(
    int block, int image, const int* rows, int count, float* waves) const
{
    kernels::PointBatch batch;
    batch.count = 0;
    for (int k = 0; k < count; ++k)
    {
        Eigen::Vector3d x = _rows.places.col(rows[k]);
        if (image > 0) x = _sheets.mirrored(image - 1, x);
        if (isInFloat(rows[k], image, block))
        {
            append(x, k, batch);
            continue;
        }
        float* row = waves + std::size_t(2) * k * width(block);
        rowInDouble(block, x * _wavelength_m, row, row + width(block));
    }
    if (batch.count == 0) return;
    fillUp(batch);
    double sums[kernels::PointBatch::kSize] = {};
    buildBatch(block, batch, kernels::FloatRows{waves}, sums);
}

void PropagationMatrix::buildSummedRows(int block, const int* rows, int count, double* sums)
{
    constexpr int kAtOnce = 8; // points whose waves stay in a level-2 cache
    constexpr std::size_t kRow = std::size_t(2) * kBlockWidth;
    alignas(64) float direct[kAtOnce * kRow], image[kAtOnce * kRow], reflected[kAtOnce * kRow];
    const int columns = width(block);
    const std::size_t row = std::size_t(2) * columns;
    for (int first = 0; first < count; first += kAtOnce)
    {
        const int* now = rows + first;
        const int points = std::min(kAtOnce, count - first);
        freeWaves(block, 0, now, points, direct);
        std::fill_n(reflected, points * row, 0.0f);
        for (int k = 0; k < _sheets.size(); ++k)
        {
            bool isReflecting = false;
            for (int l = 0; l < points; ++l)
                isReflecting =
                    isReflecting ||
                    _sheets.isReflecting(k, _rows.places.col(now[l]), offset(block), columns);
            // Of a sheet in between only the shadow is left, and no image is read.
            if (isReflecting) freeWaves(block, 1 + k, now, points, image);
            for (int l = 0; l < points; ++l)
            {
                const float* wave = (isReflecting ? image : direct) + l * row;
                float *own = direct + l * row, *other = reflected + l * row;
                _sheets.reflect(
                    k,
                    _rows.places.col(now[l]),
                    offset(block),
                    columns,
                    {nullptr, wave, wave + columns, own, own + columns, other, other + columns});
            }
        }
        for (int l = 0; l < points; ++l)
        {
            float *own = direct + l * row, *other = reflected + l * row;
            if (hasOutside()) addOutside(block, now[l], other, other + columns);
            if (_outside.rows_Pa) addOutsideRow(block, now[l], other, other + columns);
            sums[now[l]] += static_cast<double>(
                kernels::joinWaves(columns, other, other + columns, own, own + columns));
            keepRow(block, now[l], own, own + columns);
        }
    }
}

bool PropagationMatrix::setOutside(const Eigen::VectorXcd& outside_Pa,
                                   const Eigen::VectorXcf& drive)
{
    const bool isStale = outside_Pa.size() > 0 || hasOutside();
    _outside.pressures_Pa = outside_Pa;
    if (outside_Pa.size() == 0) return isStale;
    for (base::AlignedBuffer<float>* part : {&_outside.re, &_outside.im})
    {
        part->reserve(static_cast<std::size_t>(_lanes.padded));
        std::fill_n(part->data(), _lanes.padded, 0.0f);
    }
    const auto at = [&](int lane)
    { return std::complex<double>(drive[_lanes.order[static_cast<std::size_t>(lane)]]); };
    double power = 0.0;
    for (int lane = 0; lane < _lanes.count; ++lane)
        if (!isSilent(lane)) power += std::norm(at(lane));
    for (int lane = 0; lane < _lanes.count && power > 0.0; ++lane)
    {
        if (isSilent(lane)) continue;
        _outside.re[static_cast<std::size_t>(lane)] = static_cast<float>(at(lane).real() / power);
        _outside.im[static_cast<std::size_t>(lane)] = static_cast<float>(-at(lane).imag() / power);
    }
    return isStale;
}

bool PropagationMatrix::setOutsideRows(const std::shared_ptr<const Eigen::MatrixXcf>& rows_Pa,
                                       const std::vector<int>& chosen)
{
    const bool isStale = rows_Pa || _outside.rows_Pa;
    _outside.rows_Pa = rows_Pa;
    if (rows_Pa) _outside.chosen = chosen;
    return isStale;
}

void PropagationMatrix::outsidePhases(float* re, float* im) const
{
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(_lanes.padded); ++lane)
    {
        const float size = std::hypot(_outside.re[lane], _outside.im[lane]);
        re[lane] = size > 0.0f ? _outside.re[lane] / size : 1.0f;
        im[lane] = size > 0.0f ? -_outside.im[lane] / size : 0.0f;
    }
}

std::complex<double>
PropagationMatrix::outsideAt_Pa(int l, const float* qRe, const float* qIm) const
{
    std::complex<double> share = 0.0, sum = 0.0;
    for (int lane = 0; lane < _lanes.count && _outside.rows_Pa; ++lane)
        sum += std::complex<double>(outsideEntry_Pa(l, lane)) *
               std::complex<double>(qRe[lane], qIm[lane]);
    if (!hasOutside()) return sum;
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(_lanes.padded); ++lane)
        share += std::complex<double>(_outside.re[lane], _outside.im[lane]) *
                 std::complex<double>(qRe[lane], qIm[lane]);
    return sum + share * _outside.pressures_Pa[l];
}

std::complex<float> PropagationMatrix::outsideEntry_Pa(int l, int lane) const
{
    if (isSilent(lane)) return 0.0f;
    return (*_outside.rows_Pa)(_outside.chosen[static_cast<std::size_t>(l)],
                               _lanes.order[static_cast<std::size_t>(lane)]);
}

void PropagationMatrix::addOutsideRow(int block, int l, float* re, float* im) const
{
    const auto perUnit = static_cast<float>(1.0 / _unit_Pa);
    const int first = offset(block), end = std::min(_lanes.count, first + width(block));
    for (int lane = first; lane < end; ++lane)
    {
        const std::complex<float> entry = perUnit * outsideEntry_Pa(l, lane);
        re[lane - first] += entry.real();
        im[lane - first] += entry.imag();
    }
}

void PropagationMatrix::addOutside(int block, int l, float* re, float* im) const
{
    const std::complex<double> o = _outside.pressures_Pa[l] / _unit_Pa;
    const auto a = static_cast<float>(o.real()), b = static_cast<float>(o.imag());
    const float *c = _outside.re.data() + offset(block), *d = _outside.im.data() + offset(block);
    for (int i = 0; i < width(block); ++i)
    {
        re[i] += a * c[i] - b * d[i];
        im[i] += a * d[i] + b * c[i];
    }
}

void PropagationMatrix::buildBatch(int block, const kernels::PointBatch& batch, double* sums)
{
    const auto first = static_cast<std::size_t>(offset(block)) * _entries.capacity;
    if (_storage == Storage::FLOAT)
        return buildBatch(
            block, batch, kernels::FloatRows{_entries.floats.data() + 2 * first}, sums);
    const kernels::FixedRows rows{_entries.fixed.data() + first,
                                  _entries.scale.data() +
                                      static_cast<std::size_t>(block) * _entries.capacity};
    if (_isQuick)
        buildBatch(block, batch, kernels::QuickRows{rows}, sums);
    else
        buildBatch(block, batch, rows, sums);
}

template<typename Target>
void PropagationMatrix::buildBatch(int block,
                                   const kernels::PointBatch& batch,
                                   const Target& rows,
                                   double* sums) const
{
    const auto decay = static_cast<float>(_beta * _wavelength_m);
    float ofBatch[kernels::PointBatch::kSize];
    switch (_array.directivity)
    {
    case Directivity::T4010A1_HARMONICS:
        callKernel(kernels::buildCubic,
                   kernels::buildMirroredCubic,
                   geometry(block),
                   batch,
                   decay,
                   _geometry.cubic,
                   rows,
                   ofBatch);
        break;
    case Directivity::T4010A1_TABLE:
        callKernel(kernels::buildTable,
                   kernels::buildMirroredTable,
                   geometry(block),
                   batch,
                   decay,
                   _geometry.table,
                   rows,
                   ofBatch);
        break;
    case Directivity::POINT:
        callKernel(kernels::buildPoint,
                   kernels::buildMirroredPoint,
                   geometry(block),
                   batch,
                   decay,
                   kernels::DirectivityPoint{},
                   rows,
                   ofBatch);
        break;
    }
    for (int k = 0; k < batch.count; ++k)
        sums[batch.row[k]] += static_cast<double>(ofBatch[k]);
}

// Stores a row of one block.
void PropagationMatrix::keepRow(int block, int l, const float* re, const float* im)
{
    const auto columns = static_cast<std::size_t>(width(block));
    const auto row = static_cast<std::size_t>(l);
    const auto first = static_cast<std::size_t>(offset(block)) * _entries.capacity + row * columns;
    if (_storage == Storage::FLOAT)
    {
        float* to = _entries.floats.data() + 2 * first;
        std::copy_n(re, columns, to);
        std::copy_n(im, columns, to + columns);
        return;
    }
    _entries.scale[static_cast<std::size_t>(block) * _entries.capacity + row] =
        kernels::packRow(width(block), re, im, _entries.fixed.data() + first);
}

float PropagationMatrix::buildRowInDouble(int block, int l)
{
    alignas(64) float re[kBlockWidth], im[kBlockWidth];
    const float sum = rowInDouble(block, _rows.places.col(l) * _wavelength_m, re, im);
    keepRow(block, l, re, im);
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

bool PropagationMatrix::isBoundTo(const TransducerArray& array, const Medium& medium) const
{
    return _wavelength_m > 0.0 && medium == _medium && sameField(array, _array);
}

bool PropagationMatrix::bind(const TransducerArray& array, const Medium& medium)
{
    if (isBoundTo(array, medium)) return false;
    // The order of all transducers depends only on their positions.
    const bool isOrdered =
        !_lanes.order.empty() && static_cast<int>(_lanes.order.size()) == array.size() &&
        _lanes.isFiller.empty() && sameEntries(array.positions, _array.positions) &&
        (array.gain.size() == 0 || (array.gain.array() != 0.0).all());
    _array = array;
    _medium = medium;
    _wavelength_m = medium.wavelength(array.frequency_Hz);
    _beta = medium.attenuation(array.frequency_Hz);
    _unit_Pa = unitOf(array);
    if (isOrdered)
        _lanes.hasSilent = false;
    else
        bindOrder();
    _lanes.padded = (_lanes.count + kernels::kLanes - 1) / kernels::kLanes * kernels::kLanes;
    _geometry.hasOffset = array.phaseOffset_rad.size() > 0;
    if (array.directivity == Directivity::T4010A1_HARMONICS)
        _geometry.cubic = cubicOf(array.directivity);
    if (array.directivity == Directivity::T4010A1_TABLE)
        _geometry.table = tableOf(array.directivity);
    bindGeometry();
    _sheets.bind(array.reflectors, _geometry.places, _lanes.padded, _wavelength_m);
    const int points = _points;
    _points = _entries.capacity = 0;
    resize(points);
    return true;
}

// Leaves out transducers of gain 0, whose columns would be 0, so that readers of G read less.
void PropagationMatrix::bindOrder()
{
    std::vector<int> live;
    live.reserve(static_cast<std::size_t>(_array.size()));
    for (int i = 0; i < _array.size(); ++i)
        if (_array.gain.size() == 0 || _array.gain[i] != 0.0) live.push_back(i);
    if (live.empty())
        for (int i = 0; i < _array.size(); ++i)
            live.push_back(i);
    _lanes.order = compactOrder(_array.positions(Eigen::all, live), kernels::kGroup);
    for (int& i : _lanes.order)
        i = live[static_cast<std::size_t>(i)];
    _lanes.isFiller.clear();
    // The remaining transducers may have other gaps than the array; a single group that spans one
    // would have its block computed in double.
    const double largest_m = kWithin * std::min(kernels::kLargestRadius * _wavelength_m,
                                                kMostDecayInGroup / std::max(_beta, kLeastBeta));
    if (static_cast<int>(live.size()) < _array.size() &&
        !isCompact(_array.positions, _lanes.order, kernels::kGroup, largest_m))
    {
        PackedOrder other = packed(_array.positions, _lanes.order, kernels::kGroup, largest_m);
        // Never more than with all transducers, whose groups are compact for usual arrays.
        if (other.order.size() <= static_cast<std::size_t>(_array.size()))
        {
            _lanes.order = std::move(other.order);
            _lanes.isFiller = std::move(other.isFiller);
        }
        else if (std::vector<int> all = compactOrder(_array.positions, kernels::kGroup);
                 isCompact(_array.positions, all, kernels::kGroup, largest_m))
            _lanes.order = std::move(all);
    }
    _lanes.count = static_cast<int>(_lanes.order.size());
    _lanes.hasSilent = false;
    for (int lane = 0; lane < _lanes.count; ++lane)
        _lanes.hasSilent = _lanes.hasSilent || isSilent(lane);
}

void PropagationMatrix::bindGeometry()
{
    _geometry.places.resize(3, _lanes.count);
    for (int lane = 0; lane < _lanes.count; ++lane)
        _geometry.places.col(lane) =
            _array.positions.col(_lanes.order[static_cast<std::size_t>(lane)]) / _wavelength_m;

    _geometry.vectors.reserve(9 * static_cast<std::size_t>(_lanes.padded));
    _geometry.groups.clear();
    for (int first = 0; first < _lanes.padded; first += kernels::kGroup)
        _geometry.groups.push_back(
            bindGroup(first, std::min(kernels::kGroup, _lanes.count - first)));

    _geometry.blocks.resize(static_cast<std::size_t>(blocks()));
    _geometry.isCompact.resize(_geometry.blocks.size());
    for (int b = 0; b < blocks(); ++b)
    {
        const int count = std::min(width(b), _lanes.count - offset(b));
        _geometry.blocks[static_cast<std::size_t>(b)] = boundOf(offset(b), count);
        double radius = 0.0;
        for (int i = offset(b); i < offset(b) + count; i += kernels::kGroup)
            radius = std::max<double>(
                radius, _geometry.groups[static_cast<std::size_t>(i / kernels::kGroup)].radius);
        _geometry.isCompact[static_cast<std::size_t>(b)] =
            radius <= kernels::kLargestRadius &&
            radius * _beta * _wavelength_m <= kMostDecayInGroup;
    }
    _geometry.whole = boundOf(0, _lanes.count);
}

kernels::GroupGeometry PropagationMatrix::bindGroup(int first, int count)
{
    const auto places = _geometry.places.middleCols(first, count);
    const Eigen::Vector3d centre =
        0.5 * (places.rowwise().minCoeff() + places.rowwise().maxCoeff());
    const Eigen::Vector3d normal =
        _array.normals.col(_lanes.order[static_cast<std::size_t>(first)]);
    kernels::GroupGeometry group{};
    group.x = centre[0];
    group.y = centre[1];
    group.z = centre[2];
    group.nx = static_cast<float>(normal[0]);
    group.ny = static_cast<float>(normal[1]);
    group.nz = static_cast<float>(normal[2]);
    group.radius = static_cast<float>(
        std::sqrt((places.colwise() - centre).colwise().squaredNorm().maxCoeff()));
    group.planar = true;
    const int last = std::min(first + kernels::kGroup, _lanes.padded);
    for (int lane = first; lane < last; ++lane)
    {
        // Padding repeats the last transducer with strength 0.
        const int source = _lanes.order[static_cast<std::size_t>(std::min(lane, _lanes.count - 1))];
        bindLane(lane, source, centre);
        if (lane >= _lanes.count) continue;
        group.strongest =
            std::max(group.strongest,
                     std::fabs(_geometry.vectors[7 * static_cast<std::size_t>(_lanes.padded) +
                                                 static_cast<std::size_t>(lane)]));
        const double height = normal.dot(_geometry.places.col(lane) - centre);
        group.planar = group.planar && std::fabs(height) < kPlanar &&
                       (_array.normals.col(source) - normal).norm() < kPlanar;
    }
    return group;
}

void PropagationMatrix::bindLane(int lane, int source, const Eigen::Vector3d& centre)
{
    const auto stride = static_cast<std::size_t>(_lanes.padded);
    float* g = _geometry.vectors.data() + lane;
    const Eigen::Vector3d d = _array.positions.col(source) / _wavelength_m - centre;
    const Eigen::Vector3f rounded = d.cast<float>();
    for (int axis = 0; axis < 3; ++axis)
    {
        g[stride * axis] = rounded[axis];
        g[stride * (4 + axis)] = static_cast<float>(_array.normals(axis, source));
    }
    g[stride * 3] = static_cast<float>(d.squaredNorm());
    const double gain = _array.gain.size() > 0 ? _array.gain[source] : 1.0;
    g[stride * 7] =
        lane < _lanes.count && !isFiller(lane)
            ? static_cast<float>(_array.sourceAmplitude_Pa_m / _unit_Pa * gain / _wavelength_m)
            : 0.0f;
    const double turns = _geometry.hasOffset ? _array.phaseOffset_rad[source] / base::kTwoPi : 0.0;
    g[stride * 8] = static_cast<float>(turns - std::round(turns));
}

PropagationMatrix::Shell PropagationMatrix::boundOf(int first, int count) const
{
    const auto r = _geometry.places.middleCols(first, count);
    const Eigen::Vector3d centre = 0.5 * (r.rowwise().minCoeff() + r.rowwise().maxCoeff());
    const auto squares = (r.colwise() - centre).colwise().squaredNorm();
    return {centre, std::sqrt(squares.minCoeff()), std::sqrt(squares.maxCoeff())};
}

} // namespace midair::haptics
