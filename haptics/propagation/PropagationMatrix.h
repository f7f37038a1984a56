#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/AlignedBuffer.h"
#include "haptics/propagation/SheetGeometry.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <Eigen/Core>

#include <complex>
#include <memory>
#include <vector>

namespace midair::haptics
{

/// Storage format of the entries of a PropagationMatrix.
enum class Storage
{
    FLOAT, ///< error below 1e-5 of P0/R_li
    /// Two 16-bit numbers, half of the memory: additional error below 2e-5 of the largest entry of
    /// the row in the block.
    FIXED
};

/// The propagation matrix G of the solvers: the formula of ReferencePropagation.h in single
/// precision, stored in blocks of transducers so that both products of an iteration read each block
/// once. Entries with rectangular reflectors have an additional error of 1e-4 of those of their
/// images (kernels::sharesTurned). Methods don't allocate after the first call with the same n and
/// m.
class PropagationMatrix
{
public:
    /// Transducers in a block; an entry takes 4 or 8 bytes. Blocks are wide because the kernels sum
    /// over the transducers of a block; in FIXED a block of 400 points still fits a level-2 cache
    /// of 1 MiB.
    static constexpr int kBlockWidth = 512;

    explicit PropagationMatrix(Storage storage = Storage::FLOAT) : _storage(storage) {}
    bool isFixed() const { return _storage == Storage::FIXED; }
    /// Builds rows with distances in single precision from now on (kernels::QuickRows), or as
    /// exactly as before; only FIXED rows change.
    void buildQuickly(bool isQuick = true) { _isQuick = isQuick; }

    /// Returns true if everything that G depends on is unchanged since the last bind().
    bool isBoundTo(const TransducerArray& array, const Medium& medium) const;
    /// Binds to array and medium, unless already bound to them. Returns true if it did; all rows
    /// are then stale.
    bool bind(const TransducerArray& array, const Medium& medium);
    /// Makes room for \a points rows. Returns true if existing rows became stale.
    bool resize(int points);

    /// Unit of the entries and of the pressures of forward(), Pa: a power of two, chosen by bind().
    /// It is 1 unless the array's strongest transducer is outside 2^-10 .. 2^10 Pa m: then it is
    /// about that source strength, so that squares of pressures, their sums, and the squares of
    /// these stay within the range of floats.
    double unit_Pa() const { return _unit_Pa; }

    int points() const { return _points; }
    /// Number of columns: transducers with a gain other than 0 (all, if none has), so that dead
    /// ones cost nothing, plus zero columns that fill gaps (isFiller()).
    int transducers() const { return _lanes.count; }
    const TransducerArray& array() const { return _array; } ///< of bind()
    int arraySize() const { return _array.size(); } ///< all transducers, including dead ones
    int paddedTransducers() const
    {
        return _lanes.padded;
    } ///< length of every vector over transducers
    int blocks() const { return (_lanes.padded + kBlockWidth - 1) / kBlockWidth; }
    int offset(int block) const { return block * kBlockWidth; }
    int width(int block) const
    {
        return _lanes.padded - offset(block) < kBlockWidth ? _lanes.padded - offset(block)
                                                           : kBlockWidth;
    }

    /// Makes the matrix from now on G + o q0* / |q0|^2: the array's field, and the pressures \a
    /// outside_Pa (o, points() or empty: none) that something else adds to that of \a drive (q0,
    /// arraySize()). Call after bind() and resize(). Returns true if existing rows became stale.
    bool setOutside(const Eigen::VectorXcd& outside_Pa, const Eigen::VectorXcf& drive);
    /// Adds from now on rows \a chosen (points()) of \a rows_Pa (a row for each of them,
    /// arraySize() columns; null: none) to those of the array. Else as setOutside().
    bool setOutsideRows(const std::shared_ptr<const Eigen::MatrixXcf>& rows_Pa,
                        const std::vector<int>& chosen);
    bool hasOutside() const { return _outside.pressures_Pa.size() > 0; }
    /// Sets \a re, \a im (paddedTransducers()) to the phases of the outside pressures' drive, with
    /// amplitudes of 1.
    void outsidePhases(float* re, float* im) const;
    /// Returns what outside_Pa and the outside rows add at row \a l for the drive \a qRe, \a qIm
    /// (paddedTransducers()), Pa; 0 without them.
    std::complex<double> outsideAt_Pa(int l, const float* qRe, const float* qIm) const;

    /// Assigns the control point at \a r (m) to row \a l, whose entries are stale until buildRows()
    /// has been called for every block.
    void setPoint(int l, const Eigen::Vector3d& r);
    /// Computes \a rows of block \a block and adds their part of sum_i |G_li| to sums[l].
    void buildRows(int block, const int* rows, int count, double* sums);
    /// Computes all rows on one thread.
    void build(const Eigen::Matrix3Xd& points);

    /// The matrix orders transducers its own way (compactOrder): column (lane) \a lane belongs to
    /// transducer order()[lane]. Has transducers() entries.
    const std::vector<int>& order() const { return _lanes.order; }
    /// Returns true if column \a lane is 0 and belongs to no transducer; order() then repeats a
    /// neighbour.
    bool isFiller(int lane) const
    {
        return !_lanes.isFiller.empty() && _lanes.isFiller[static_cast<std::size_t>(lane)];
    }
    /// Returns true if some lanes are fillers or transducers of gain 0.
    bool hasSilentLanes() const { return _lanes.hasSilent; }
    /// Returns true if column \a lane is 0, for any reason.
    bool isSilent(int lane) const
    {
        return isFiller(lane) || (_array.gain.size() > 0 &&
                                  _array.gain[_lanes.order[static_cast<std::size_t>(lane)]] == 0.0);
    }

    /// z = G* w for one block; z and q point to whole vectors of paddedTransducers() floats.
    void backward(int block, const float* wRe, const float* wIm, float* zRe, float* zIm) const;
    /// p += G q for one block.
    void forward(int block, const float* qRe, const float* qIm, float* pRe, float* pIm) const;

    /// The same for the block's transducers from \a first on, a multiple of kernels::kLanes; FIXED
    /// only.
    void forwardFrom(
        int block, int first, const float* qRe, const float* qIm, float* pRe, float* pIm) const;

    std::complex<float> at(int l, int lane) const; ///< in unit_Pa()
    /// FLOAT: n rows of [re width][im width].
    const float* blockData(int block) const
    {
        return _entries.floats.data() + std::size_t(2) * offset(block) * _entries.capacity;
    }
    /// FIXED: n rows of \a width lanes, and the scale of each row.
    const std::int32_t* fixedData(int block) const
    {
        return _entries.fixed.data() + std::size_t(1) * offset(block) * _entries.capacity;
    }
    const float* fixedScale(int block) const
    {
        return _entries.scale.data() + std::size_t(1) * block * _entries.capacity;
    }
    double wavelength_m() const { return _wavelength_m; }

private:
    // Smallest and largest distance of transducers from a centre (Shell) and from a point (Range),
    // in wavelengths.
    struct Shell
    {
        Eigen::Vector3d centre;
        double nearest, farthest;
    };
    struct Range
    {
        double nearest, farthest;
    };

    // Columns of the matrix.
    struct Lanes
    {
        std::vector<int> order;
        std::vector<char> isFiller; // for each lane; empty: no fillers
        bool hasSilent = false;
        int count = 0, padded = 0;
    };
    // The array in the layout of the kernels.
    struct Geometry
    {
        Eigen::Matrix3Xd places;   // positions of the lanes, wavelengths
        Shell whole{};             // of the array
        std::vector<Shell> blocks; // of each block
        // For each block: 1 if its groups are small enough for the float kernel.
        std::vector<unsigned char> isCompact;
        std::vector<kernels::GroupGeometry> groups;
        base::AlignedBuffer<float> vectors; // nine of length padded
        bool hasOffset = false;
        kernels::DirectivityCubic cubic{};
        kernels::DirectivityTable table{};
    };
    struct Rows
    {
        Eigen::Matrix3Xd places; // control points, wavelengths
        // For each row, the point and then its images, and block: 1 if it is within the range of
        // the float kernel.
        std::vector<unsigned char> inFloat;
    };
    // Entries of G, by storage format.
    struct Entries
    {
        int capacity = 0; // allocated rows
        base::AlignedBuffer<float> floats;
        base::AlignedBuffer<std::int32_t> fixed;
        base::AlignedBuffer<float> scale; // of the rows in fixed, block by block
    };

    // What something outside adds, as products of a row and a column.
    struct Outside
    {
        Eigen::VectorXcd pressures_Pa;                   // for each row; empty: nothing
        base::AlignedBuffer<float> re, im;               // q0* / |q0|^2
        std::shared_ptr<const Eigen::MatrixXcf> rows_Pa; // null: none
        std::vector<int> chosen;                         // of them, for each row
    };

    void bindOrder();
    void bindGeometry();
    kernels::GroupGeometry bindGroup(int first, int count);
    void bindLane(int lane, int source, const Eigen::Vector3d& centre);
    Shell boundOf(int first, int count) const;
    Range rangeOf(const Shell& bound, const Eigen::Vector3d& r) const;
    bool suitsKernel(const Range& range) const;
    void findRange(const Eigen::Vector3d& x, unsigned char* inFloat) const;
    bool isInFloat(int l, int image, int block) const;
    kernels::BlockGeometry geometry(int block) const;
    template<typename Target>
    void
    buildBatch(int block, const kernels::PointBatch& batch, const Target& rows, double* sums) const;
    void buildBatch(int block, const kernels::PointBatch& batch, double* sums);
    void freeWaves(int block, int image, const int* rows, int count, float* waves) const;
    void buildMirroredRows(int block, const int* rows, int count, double* sums);
    void buildSummedRows(int block, const int* rows, int count, double* sums);
    void addOutside(int block, int l, float* re, float* im) const;
    void addOutsideRow(int block, int l, float* re, float* im) const;
    std::complex<float> outsideEntry_Pa(int l, int lane) const;
    void keepRow(int block, int l, const float* re, const float* im);
    float buildRowInDouble(int block, int l);
    float rowInDouble(int block, const Eigen::Vector3d& r, float* re, float* im) const;

    Storage _storage;
    bool _isQuick = false;
    TransducerArray _array;
    Medium _medium;
    double _wavelength_m = 0.0, _beta = 0.0, _unit_Pa = 1.0;
    int _points = 0;
    Lanes _lanes;
    Geometry _geometry;
    SheetGeometry _sheets;
    Rows _rows;
    Entries _entries;
    Outside _outside;
};

} // namespace midair::haptics
