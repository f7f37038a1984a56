#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/AlignedBuffer.h"

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace midair::haptics
{

/// Samples at origin + a step.col(0) + b step.col(1) + c step.col(2), metres, array frame; a runs
/// fastest.
struct FieldLattice
{
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    Eigen::Matrix3d step = Eigen::Matrix3d::Identity();
    Eigen::Array3i count = Eigen::Array3i::Ones(); ///< along each axis, >= 1

    Eigen::Index size() const { return Eigen::Index(count[0]) * count[1] * count[2]; }
    Eigen::Vector3d at(int a, int b, int c) const
    {
        return origin + a * step.col(0) + b * step.col(1) + c * step.col(2);
    }
};

/// Computes the pressure on a lattice, about ten times as fast as entry by entry: for pictures of a
/// field that moves.
class LatticeField
{
public:
    /// rad, in the corner of a tile, for the transducer nearest to it.
    static constexpr double kPhaseError = 0.03;

    /// Asked of each tile by its middle and its radius (m); false leaves its samples at 0.
    using Wanted = std::function<bool(const Eigen::Vector3d& middle, double radius_m)>;

    LatticeField(const TransducerArray& array, const Medium& medium);

    /// \a pressure: complex peak Pa, one a sample, within kPhaseError of what all waves in phase
    /// would give there; far from the transducers within 2e-4 for unrelated phases. Throws
    /// InputError where activations and transducers disagree.
    void evaluate(const FieldLattice& lattice,
                  const Eigen::VectorXcf& activations,
                  Eigen::VectorXcf& pressure,
                  const Wanted& wanted = {});

    /// How many samples of the last evaluation were computed by tiles, and how many entry by entry.
    Eigen::Index tiled() const { return _tiled; }
    Eigen::Index exact() const { return _exact; }

private:
    struct Tile
    {
        Eigen::Array3i first, count;
    };

    void drive(const Eigen::VectorXcf& activations);
    void cover(const Tile& tile, const Wanted& wanted);
    double nearest_m(const Eigen::Vector3d& middle) const;
    void march(const Tile& tile, const Eigen::Vector3d& middle);
    void entryByEntry(const Tile& tile);

    TransducerArray _array;
    Medium _medium;
    double _wavelength_m = 0.0;
    std::vector<float> _directivity; ///< over cos(theta), see LatticeKernels.h
    /// For the driven transducers: x, y, z, nx, ny, nz, re, im.
    base::AlignedBuffer<float> _geometry;
    int _padded = 0;
    base::AlignedBuffer<float> _sums;
    const FieldLattice* _lattice = nullptr;
    const Eigen::VectorXcf* _activations = nullptr;
    Eigen::VectorXcf* _pressure = nullptr;
    Eigen::Index _tiled = 0, _exact = 0;
};

} // namespace midair::haptics
