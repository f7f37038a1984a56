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

/// The pressure on a lattice, about ten times as fast as entry by entry, to be looked at while it
/// moves.
///
/// A wave changes from one sample to the next by a factor that itself changes by a nearly constant
/// factor, so that within a tile of the lattice each sample costs three complex multiplications a
/// transducer instead of a root, a sine and a cosine:
///     G(x) = G(0) exp(E x + x H x / 2),  E = grad ln D - s (1/R + beta + j k),
///     H = -j k (1 - s s^T)/R - (1 - 2 s s^T)/R^2,  s = d/R,
/// d from the transducer to the tile's middle.
/// The next term of the phase is at most 0.193 k h^3/R^2 at h from the middle; tiles are halved
/// until it is below kPhaseError. What is too near a transducer for that is computed entry by
/// entry. To 3e-3 of what all transducers in phase would give.
class LatticeField
{
public:
    /// rad, of the nearest transducer in a tile's corner
    static constexpr double kPhaseError = 0.03;

    /// Asked of each tile by its middle and its radius (m); false leaves its samples at 0.
    using Wanted = std::function<bool(const Eigen::Vector3d& middle, double radius_m)>;

    LatticeField(const TransducerArray& array, const Medium& medium);

    /// \a pressure: complex peak Pa, one a sample. Throws InputError where activations and
    /// transducers disagree.
    void evaluate(const FieldLattice& lattice,
                  const Eigen::VectorXcf& activations,
                  Eigen::VectorXcf& pressure,
                  const Wanted& wanted = {});

    /// Of the last evaluation: samples that went by tiles, and those that went entry by entry.
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
    /// of the driven transducers: x, y, z, nx, ny, nz, re, im
    base::AlignedBuffer<float> _geometry;
    int _padded = 0;
    base::AlignedBuffer<float> _sums;
    const FieldLattice* _lattice = nullptr;
    const Eigen::VectorXcf* _activations = nullptr;
    Eigen::VectorXcf* _pressure = nullptr;
    Eigen::Index _tiled = 0, _exact = 0;
};

} // namespace midair::haptics
