#pragma once

#include "haptics/AlignedBuffer.h"
#include "haptics/Medium.h"
#include "haptics/PropagationKernels.h"
#include "haptics/TransducerArray.h"

#include <Eigen/Core>

#include <complex>
#include <vector>

namespace midair::haptics
{

/// G in double precision straight from the formula, entry by entry: what the fast path is tested against.
///     G_li = P0 gain_i D(theta_li) / R_li exp(-(beta + j k) R_li + j phaseOffset_i)
/// (Inoue, Makino, Shinoda 2015, equations 2 to 5; time factor e^{+j omega t}). n x m, Pa peak at full drive.
/// R_li is at least kNearestDistance_m, and cos(theta_li) = (r_l - r_i).n_i / R_li, so that G is finite everywhere.
Eigen::MatrixXcd referencePropagationMatrix(const Eigen::Matrix3Xd& points,
                                            const TransducerArray& array,
                                            const Medium& medium);

/// G in float, as the solvers use it: the same formula to 1e-5 of P0/R_li, in blocks of transducers so that a block is
/// read once for both directions of a round. No method allocates once n and m have been seen.
class PropagationMatrix
{
public:
    static constexpr int kBlockWidth = 128; ///< transducers; 2 * 4 * 128 bytes a row and block

    /// Takes over array and medium; true if either differs from before, and then every row is stale.
    bool bind(const TransducerArray& array, const Medium& medium);
    /// Room for \a points rows; true if the rows that were there are stale now.
    bool resize(int points);

    int points() const { return _points; }
    int transducers() const { return _transducers; }
    int paddedTransducers() const { return _padded; } ///< length of every vector over transducers
    int blocks() const { return (_padded + kBlockWidth - 1) / kBlockWidth; }
    int offset(int block) const { return block * kBlockWidth; }
    int width(int block) const
    {
        return _padded - offset(block) < kBlockWidth ? _padded - offset(block) : kBlockWidth;
    }

    /// Row \a l belongs to a control point at \a r (m); its entries are stale until buildRow has seen every block.
    void setPoint(int l, const Eigen::Vector3d& r);
    /// Row \a l of block \a block; returns its share of sum_i |G_li|.
    float buildRow(int block, int l);
    /// All rows at once, one thread.
    void build(const Eigen::Matrix3Xd& points);

    /// z = G* w over a block; z and q point at the whole vectors, of paddedTransducers() floats.
    void backward(int block, const float* wRe, const float* wIm, float* zRe, float* zIm) const;
    /// p += G q over a block.
    void forward(int block, const float* qRe, const float* qIm, float* pRe, float* pIm) const;

    std::complex<float> at(int l, int i) const;
    const float* blockData(int block) const
    {
        return _G.data() + std::size_t(2) * offset(block) * _capacity;
    }
    double wavelength_m() const { return _wavelength_m; }

private:
    // Distances of transducers from a centre, and from a point; wavelengths.
    struct Shell
    {
        Eigen::Vector3d centre;
        double nearest, farthest;
    };
    struct Range
    {
        double nearest, farthest;
    };

    void bindGeometry();
    Shell boundOf(int first, int count) const;
    Range rangeOf(const Shell& bound, const Eigen::Vector3d& r) const;
    bool suitsKernel(const Range& range, double middle) const;
    kernels::BlockGeometry geometry(int block) const;
    float buildRowInDouble(int block, const Eigen::Vector3d& r, float* re, float* im) const;

    struct Row
    {
        Eigen::Vector3d r; // metres
        kernels::PointSetup setup;
    };

    TransducerArray _array;
    Medium _medium;
    double _wavelength_m = 0.0, _beta = 0.0;
    int _points = 0, _transducers = 0, _padded = 0, _capacity = 0;
    Shell _bound{};                 // of the array
    std::vector<Shell> _bounds;     // of each block
    AlignedBuffer<float> _geometry; // ten or eleven vectors of _padded
    bool _hasOffset = false;
    kernels::DirectivityCubic _cubic{};
    kernels::DirectivityTable _table{};
    std::vector<Row> _rows;
    std::vector<unsigned char>
        _inFloat; // row by row, a flag a block: within the float kernel's range
    AlignedBuffer<float> _G;
};

} // namespace midair::haptics
