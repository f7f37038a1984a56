#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/AlignedBuffer.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <Eigen/Core>

#include <complex>
#include <vector>

namespace midair::haptics
{

/// How the entries of a PropagationMatrix are kept.
enum class Storage
{
    FLOAT, ///< to 1e-5 of P0/R_li
    /// In 2 x 16 bits: within another 2e-5 of the largest entry of row and block, in half of the
    /// memory.
    FIXED
};

/// G as the solvers use it: the same formula, computed in float, in blocks of transducers so that a
/// block is read once for both directions of a round. No method allocates once n and m have been
/// seen.
class PropagationMatrix
{
public:
    /// Transducers in a block, whose entries take 4 or 8 bytes each. Wide, since the kernels sum
    /// over the transducers of a block; a block of 400 points still fits a level-2 cache of 1 MiB.
    static constexpr int kBlockWidth = 512;

    explicit PropagationMatrix(Storage storage = Storage::FLOAT) : _storage(storage) {}

    /// True if what G depends on is as in the last bind.
    bool isBoundTo(const TransducerArray& array, const Medium& medium) const;
    /// Takes over array and medium unless isBoundTo them; true if so, and then every row is stale.
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

    /// Row \a l belongs to a control point at \a r (m); its entries are stale until buildRows has
    /// seen every block.
    void setPoint(int l, const Eigen::Vector3d& r);
    /// Rows \a rows of block \a block; adds their share of sum_i |G_li| to sums[l].
    void buildRows(int block, const int* rows, int count, double* sums);
    /// All rows at once, one thread.
    void build(const Eigen::Matrix3Xd& points);

    /// The matrix has its own order of transducers (compactOrder): column and lane \a lane is
    /// transducer order()[lane].
    const std::vector<int>& order() const { return _order; }

    /// z = G* w over a block; z and q point at the whole vectors, of paddedTransducers() floats.
    void backward(int block, const float* wRe, const float* wIm, float* zRe, float* zIm) const;
    /// p += G q over a block.
    void forward(int block, const float* qRe, const float* qIm, float* pRe, float* pIm) const;

    std::complex<float> at(int l, int lane) const;
    /// FLOAT: n rows of [re width][im width].
    const float* blockData(int block) const
    {
        return _entries.data() + std::size_t(2) * offset(block) * _capacity;
    }
    /// FIXED: n rows of \a width lanes, and what each row is to be multiplied by.
    const std::int32_t* fixedData(int block) const
    {
        return _fixed.data() + std::size_t(1) * offset(block) * _capacity;
    }
    const float* fixedScale(int block) const
    {
        return _scale.data() + std::size_t(1) * block * _capacity;
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
    kernels::GroupGeometry bindGroup(int first, int count);
    void bindLane(int lane, int source, const Eigen::Vector3d& centre);
    Shell boundOf(int first, int count) const;
    Range rangeOf(const Shell& bound, const Eigen::Vector3d& r) const;
    bool suitsKernel(const Range& range) const;
    kernels::BlockGeometry geometry(int block) const;
    template<typename Rows>
    void buildBatch(int block, const kernels::PointBatch& batch, const Rows& rows, double* sums);
    void buildBatch(int block, const kernels::PointBatch& batch, double* sums);
    float buildRowInDouble(int block, int l);
    float rowInDouble(int block, const Eigen::Vector3d& r, float* re, float* im) const;

    Storage _storage;
    TransducerArray _array;
    Medium _medium;
    double _wavelength_m = 0.0, _beta = 0.0;
    int _points = 0, _transducers = 0, _padded = 0, _capacity = 0;
    std::vector<int> _order;
    Eigen::Matrix3Xd _places;            // of the lanes, wavelengths
    Shell _bound{};                      // of the array
    std::vector<Shell> _bounds;          // of each block
    std::vector<unsigned char> _compact; // block by block: groups small enough for the float kernel
    std::vector<kernels::GroupGeometry> _groups;
    base::AlignedBuffer<float> _geometry; // nine vectors of _padded
    bool _hasOffset = false;
    kernels::DirectivityCubic _cubic{};
    kernels::DirectivityTable _table{};
    Eigen::Matrix3Xd _rows; // points of the rows, wavelengths
    // Row by row, with a flag for each block: whether it is within the range of the float kernel.
    std::vector<unsigned char> _inFloat;
    base::AlignedBuffer<float> _entries;
    base::AlignedBuffer<std::int32_t> _fixed;
    base::AlignedBuffer<float> _scale; // of the rows in _fixed, block by block
};

} // namespace midair::haptics
