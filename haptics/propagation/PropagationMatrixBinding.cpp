// The part of PropagationMatrix that converts an array and its medium to groups of transducers,
// directivity and bounds.
#include "haptics/base/Units.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/TransducerGroups.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace midair::haptics
{

namespace
{

constexpr double kPlanar = 1e-7;           // largest distance from the plane, wavelengths
constexpr double kMostDecayInGroup = 0.02; // up to here a parabola for exp has an error of 1e-6
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

// Returns true if all that G depends on is the same; name, boards and drive do not matter.
bool sameField(const TransducerArray& a, const TransducerArray& b)
{
    return a.size() == b.size() && a.frequency_Hz == b.frequency_Hz &&
           a.sourceAmplitude_Pa_m == b.sourceAmplitude_Pa_m && a.directivity == b.directivity &&
           sameEntries(a.positions, b.positions) && sameEntries(a.normals, b.normals) &&
           sameEntries(a.phaseOffset_rad, b.phaseOffset_rad) && sameEntries(a.gain, b.gain);
}

// See PropagationMatrix::unit_Pa().
double unitOf(const TransducerArray& array)
{
    const double strength = array.sourceAmplitude_Pa_m *
                            (array.gain.size() > 0 ? array.gain.cwiseAbs().maxCoeff() : 1.0);
    const bool isUsual = strength >= 0x1p-10 && strength <= 0x1p10;
    return isUsual || !(strength > 0.0) ? 1.0 : std::ldexp(1.0, std::ilogb(strength));
}

// Returns a bound on D: its largest value on a fine grid of cosines, with a margin.
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

} // namespace

bool PropagationMatrix::isBoundTo(const TransducerArray& array, const Medium& medium) const
{
    return _wavelength_m > 0.0 && medium == _medium && sameField(array, _array);
}

bool PropagationMatrix::bind(const TransducerArray& array, const Medium& medium)
{
    if (isBoundTo(array, medium)) return false;
    // The order of all transducers depends on their positions alone.
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
    const int points = _points;
    _points = _entries.capacity = 0;
    resize(points);
    return true;
}

// Leaves out transducers of gain 0, whose columns would be 0: what reads G then reads less.
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
    // What is left may have gaps in other places than the array has; one group that spans one would
    // have its block computed in double.
    const double largest_m = kWithin * std::min(kernels::kLargestRadius * _wavelength_m,
                                                kMostDecayInGroup / std::max(_beta, kLeastBeta));
    if (static_cast<int>(live.size()) < _array.size() &&
        !isCompact(_array.positions, _lanes.order, kernels::kGroup, largest_m))
    {
        PackedOrder other = packed(_array.positions, _lanes.order, kernels::kGroup, largest_m);
        // Never more than with all transducers, whose groups are compact if the array is usual.
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
