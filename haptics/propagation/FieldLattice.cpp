#include "haptics/propagation/FieldLattice.h"

#include "haptics/base/Units.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/kernels/LatticeKernels.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

constexpr int kVectors = 8; ///< vectors in _geometry

kernels::LatticeSources sourcesOf(const base::AlignedBuffer<float>& geometry,
                                  int padded,
                                  const std::vector<float>& directivity)
{
    const auto vector = [&](int k) { return geometry.data() + std::size_t(k) * padded; };
    return {vector(0),
            vector(1),
            vector(2),
            vector(3),
            vector(4),
            vector(5),
            vector(6),
            vector(7),
            directivity.data(),
            padded};
}

/// Returns the largest number of samples of a tile along each axis: 8 x 8 for flat lattices, 4 x 5
/// x 5 for others, because rows are summed four samples at a time.
Eigen::Array3i largestTile(const Eigen::Array3i& count)
{
    const Eigen::Array3i largest =
        (count > 1).count() > 2 ? Eigen::Array3i(4, 5, 5) : Eigen::Array3i(8, 8, 8);
    static_assert(8 * 8 <= kernels::kLatticeSamples && 4 * 5 * 5 <= kernels::kLatticeSamples);
    return count.min(largest);
}

/// Returns half the longest diagonal of a tile whose half edges are the columns of \a half.
double radius_m(const Eigen::Matrix3d& half)
{
    double most = 0.0;
    for (const double b : {-1.0, 1.0})
        for (const double c : {-1.0, 1.0})
            most = std::max(most, (half.col(0) + b * half.col(1) + c * half.col(2)).norm());
    return most;
}

} // namespace

LatticeField::LatticeField(const TransducerArray& array, const Medium& medium) :
    _array(array),
    _medium(medium),
    _wavelength_m(medium.wavelength(array.frequency_Hz)),
    _directivity(kernels::kDirectivitySteps + 2)
{
    for (int i = 0; i < static_cast<int>(_directivity.size()); ++i)
        _directivity[i] = static_cast<float>(directivity(
            array.directivity, std::min(1.0, -1.0 + 2.0 * i / kernels::kDirectivitySteps)));
    _sums.reserve(std::size_t(2) * kernels::kLatticeSamples);
}

void LatticeField::drive(const Eigen::VectorXcf& activations)
{
    std::vector<Eigen::Index> driven;
    for (Eigen::Index i = 0; i < activations.size(); ++i)
        if (activations[i] != std::complex<float>()) driven.push_back(i);
    const auto lanes = static_cast<std::size_t>(kernels::kLatticeLanes);
    const std::size_t padded = (driven.size() + lanes - 1) / lanes * lanes;
    _padded = static_cast<int>(padded);
    _geometry.reserve(kVectors * padded);
    float* out = _geometry.data();
    for (std::size_t k = 0; k < padded; ++k)
    {
        // Padding repeats the last transducer with strength 0, so that it never changes the nearest
        // distance.
        const Eigen::Index i = driven[std::min(k, driven.size() - 1)];
        std::complex<double> emitted = activations[i];
        emitted *= _array.sourceAmplitude_Pa_m / _wavelength_m;
        if (_array.gain.size() > 0) emitted *= _array.gain[i];
        if (_array.phaseOffset_rad.size() > 0)
            emitted *= std::polar(1.0, _array.phaseOffset_rad[i]);
        if (k >= driven.size()) emitted = 0.0;
        for (int axis = 0; axis < 3; ++axis)
        {
            out[axis * padded + k] = static_cast<float>(_array.positions(axis, i) / _wavelength_m);
            out[(3 + axis) * padded + k] = static_cast<float>(_array.normals(axis, i));
        }
        out[6 * padded + k] = static_cast<float>(emitted.real());
        out[7 * padded + k] = static_cast<float>(emitted.imag());
    }
}

void LatticeField::evaluate(const FieldLattice& lattice,
                            const Eigen::VectorXcf& activations,
                            Eigen::VectorXcf& pressure,
                            const Wanted& wanted)
{
    checkActivations(_array, activations);
    pressure.setZero(lattice.size());
    _tiled = _exact = 0;
    if ((activations.array() == std::complex<float>()).all()) return;
    drive(activations);
    _lattice = &lattice;
    _activations = &activations;
    _pressure = &pressure;
    const Eigen::Array3i side = largestTile(lattice.count);
    // Tiles have nearly equal sizes, so that none has only a few samples.
    const Eigen::Array3i tiles = (lattice.count + side - 1) / side;
    Eigen::Array3i tile;
    for (tile[2] = 0; tile[2] < tiles[2]; ++tile[2])
        for (tile[1] = 0; tile[1] < tiles[1]; ++tile[1])
            for (tile[0] = 0; tile[0] < tiles[0]; ++tile[0])
            {
                const Eigen::Array3i first = lattice.count * tile / tiles;
                cover({first, lattice.count * (tile + 1) / tiles - first}, wanted);
            }
}

double LatticeField::nearest_m(const Eigen::Vector3d& middle) const
{
    const Eigen::Vector3f m = (middle / _wavelength_m).cast<float>();
    return _wavelength_m * std::sqrt(kernels::nearestSquared(
                               sourcesOf(_geometry, _padded, _directivity), m.data()));
}

void LatticeField::cover(const Tile& tile, const Wanted& wanted)
{
    // From the tile's first sample to its middle, in steps of the lattice.
    const Eigen::Vector3d half = 0.5 * (tile.count - 1).cast<double>().matrix();
    const Eigen::Vector3d middle =
        _lattice->origin + _lattice->step * (tile.first.cast<double>().matrix() + half);
    const double h = radius_m(_lattice->step * half.asDiagonal());
    if (wanted && !wanted(middle, h)) return;
    if (!_array.reflectors.empty())
        return entryByEntry(tile); // waves have several ways to a sample
    const double R = nearest_m(middle);
    const double k = base::kTwoPi / _wavelength_m;
    if (R > kNearestDistance_m + 2.0 * h && 0.193 * k * h * h * h <= kPhaseError * R * R)
    {
        march(tile, middle);
        return;
    }
    Eigen::Index longest = 0;
    const int most = tile.count.maxCoeff(&longest);
    if (most <= 2)
    {
        entryByEntry(tile);
        return;
    }
    Tile low = tile;
    Tile high = tile;
    low.count[longest] = most / 2;
    high.first[longest] += most / 2;
    high.count[longest] -= most / 2;
    cover(low, wanted);
    cover(high, wanted);
}

void LatticeField::march(const Tile& tile, const Eigen::Vector3d& middle)
{
    kernels::LatticeTile t{};
    for (int axis = 0; axis < 3; ++axis)
    {
        t.middle[axis] = static_cast<float>(middle[axis] / _wavelength_m);
        for (int k = 0; k < 3; ++k)
            t.step[k][axis] = static_cast<float>(_lattice->step(axis, k) / _wavelength_m);
        t.count[axis] = tile.count[axis];
    }
    t.beta = static_cast<float>(_medium.attenuation(_array.frequency_Hz) * _wavelength_m);
    _sums.setZero();
    kernels::marchLattice(sourcesOf(_geometry, _padded, _directivity), t, _sums.data());
    const float* sum = _sums.data();
    for (int c = 0; c < tile.count[2]; ++c)
        for (int b = 0; b < tile.count[1]; ++b)
        {
            const Eigen::Index row =
                tile.first[0] +
                _lattice->count[0] *
                    (tile.first[1] + b + Eigen::Index(_lattice->count[1]) * (tile.first[2] + c));
            for (int a = 0; a < tile.count[0]; ++a, sum += 2)
                (*_pressure)[row + a] = {sum[0], sum[1]};
        }
    _tiled += tile.count.prod();
}

void LatticeField::entryByEntry(const Tile& tile)
{
    Eigen::Matrix3Xd points(3, tile.count.prod());
    std::vector<Eigen::Index> places;
    for (int c = 0; c < tile.count[2]; ++c)
        for (int b = 0; b < tile.count[1]; ++b)
            for (int a = 0; a < tile.count[0]; ++a)
            {
                const Eigen::Array3i at = tile.first + Eigen::Array3i(a, b, c);
                points.col(static_cast<Eigen::Index>(places.size())) =
                    _lattice->at(at[0], at[1], at[2]);
                places.push_back(at[0] + _lattice->count[0] *
                                             (at[1] + Eigen::Index(_lattice->count[1]) * at[2]));
            }
    const Eigen::VectorXcf exact = pressureAt(points, _array, _medium, *_activations);
    for (std::size_t i = 0; i < places.size(); ++i)
        (*_pressure)[places[i]] = exact[static_cast<Eigen::Index>(i)];
    _exact += tile.count.prod();
}

} // namespace midair::haptics
