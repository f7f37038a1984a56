#pragma once

#include "haptics/base/AlignedBuffer.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/base/threads/ThreadPool.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <chrono>
#include <memory>
#include <utility>
#include <vector>

namespace midair::haptics
{

/// Pressures below this have no phase; divisions by them use this value, so that the result stays
/// finite.
constexpr float kLeastPressure_Pa = 1e-30f;

/// A complex vector as two aligned arrays of floats.
struct SplitVector
{
    base::AlignedBuffer<float> re, im;

    void reserve(std::size_t count)
    {
        re.reserve(count);
        im.reserve(count);
    }
    std::complex<float> at(std::size_t i) const { return {re[i], im[i]}; }
    void set(std::size_t i, std::complex<float> value)
    {
        re[i] = value.real();
        im[i] = value.imag();
    }
};

/// The points that are solved for, their matrix and the vectors of a solve, as all solvers use
/// them. Symbols as in the paper: G (n x m), q (m), p = G q (n), a the targets (n), u the phases of
/// p.
class FieldProblem
{
public:
    explicit FieldProblem(int threads, Storage storage = Storage::FLOAT) :
        FieldProblem(std::make_shared<base::ThreadPool>(threads), storage)
    {
    }
    /// \a pool: not null; nothing else may run on it at the same time. Functions that read all of G
    /// throw Stopped on a request of \a stop.
    explicit FieldProblem(std::shared_ptr<base::ThreadPool> pool,
                          Storage storage = Storage::FLOAT,
                          base::StopToken stop = {}) :
        G(storage),
        _pool(std::move(pool)),
        _stop(std::move(stop))
    {
    }

    /// Returns true if array and medium equal those of the last assign() in all that G depends on.
    bool isBoundTo(const TransducerArray& array, const Medium& medium) const
    {
        return G.isBoundTo(array, medium);
    }
    /// Assigns a valid problem. \a active: indices of the points to be solved for. Rows of points
    /// that moved by no more than \a tolerance_m are kept. \a isBound: result of isBoundTo().
    /// Returns the number of stale rows, which build() computes.
    int assign(const ControlPoints& points,
               const std::vector<int>& active,
               const TransducerArray& array,
               const Medium& medium,
               double tolerance_m,
               bool isBound = false);
    void build(); ///< computes the stale rows of G
    /// build() and projectRound() in one pass, which uses each block of G while it is in the cache.
    void buildAndProject(const SplitVector& w, SplitVector& p);
    /// Returns the time that the last build took on the calling thread.
    double build_ms() const { return _build_ms; }
    /// Makes the next assign() keep no rows.
    void forget() { _fresh.assign(_fresh.size(), 0); }

    int n() const { return G.points(); }
    int m() const { return G.transducers(); }
    const DriveResolution& drive() const { return _drive; }
    /// Returns mean_l sum_i |G_li|, Pa: the pressure that a single focus would have.
    double meanRowSum() const;
    /// Returns sum_i |G_li|, Pa.
    double rowSum(int l) const { return _rowSums[static_cast<std::size_t>(l)]; }

    /// z = G* w.
    void backward(const SplitVector& w, SplitVector& z);
    /// p = G q.
    void forward(const SplitVector& q, SplitVector& p);
    /// One round, G read once: z = G* w, q = z/|z|, p = G q.
    void projectRound(const SplitVector& w, SplitVector& p);
    /// y_l = |p_l|, u_l = p_l/|p_l|; u_l is kept where |p_l| is at most kLeastPressure_Pa.
    void phasesOf(const SplitVector& p);
    /// Sets \a to to unit amplitudes with the phases of \a from, rounded to the nearest level.
    void quantisePhases(const SplitVector& from, SplitVector& to);
    void clearPadding(SplitVector& v); ///< v_i = 0 for i >= m
    /// Makes q playable by the device: amplitudes times \a scale, clipped to 1 and rounded to the
    /// nearest level, and phases rounded to the nearest level.
    void quantise(float scale);

    Eigen::MatrixXcf dense() const; ///< G (n x m) as one matrix, for methods that need columns

    /// Copies \a q (m, in the array's order) into \a lanes (in the matrix's order, padded), and
    /// back.
    void toLanes(const Eigen::VectorXcf& q, SplitVector& lanes) const;
    void fromLanes(const SplitVector& lanes, Eigen::VectorXcf& q) const;

    double elapsed_ms() const; ///< time since start()
    void start() { _start = std::chrono::steady_clock::now(); }

    PropagationMatrix G;
    Eigen::VectorXf a;                  ///< n, the targets, > 0
    Eigen::VectorXf y;                  ///< n, |p|
    SplitVector u, p, w;                ///< n
    SplitVector z, q;                   ///< paddedTransducers()
    base::AlignedBuffer<float> inverse; ///< 1/|z_i|

    int threads() const { return _pool->threads(); }
    const base::StopToken& stop() const { return _stop; }
    /// On every thread, calls before(thread) once and then inBlock(thread, block) for each of the
    /// thread's blocks. A block's number alone decides its thread, so that sums are reproducible.
    /// Throws Stopped on a stop request; some blocks are then not visited.
    template<typename Before, typename InBlock>
    void eachBlock(const Before& before, const InBlock& inBlock)
    {
        _pool->run(
            [&](int thread)
            {
                before(thread);
                const int last = G.blocks() * (thread + 1) / threads();
                for (int b = G.blocks() * thread / threads(); b < last && !_stop.requested(); ++b)
                    inBlock(thread, b);
            });
        _stop.throwIfRequested();
    }
    /// Returns the partial sums over the transducers of thread \a thread, 2 x n floats (re, im).
    float* partial(int thread)
    {
        return _partial.data() + static_cast<std::size_t>(thread) * _partialStride;
    }
    void clearPartial(int thread);
    /// partial += G q over one block.
    void forwardBlock(int thread, int block, const SplitVector& q);
    void sumPartials(SplitVector& p); ///< p = sum of the partial sums of all threads

private:
    void reserve();
    void buildBlock(int thread, int block);
    void sumRows();
    void projectBlock(int thread, int block, const SplitVector& w);
    double* rowSums(int thread)
    {
        return _rowSumParts.data() + static_cast<std::size_t>(thread) * _partialStride;
    }

    std::shared_ptr<base::ThreadPool> _pool;
    base::StopToken _stop;
    DriveResolution _drive;
    Eigen::Matrix3Xd _positions;       // positions for which the rows were built
    std::vector<unsigned char> _fresh; // 1: the row is built
    std::vector<int> _stale;           // rows that build() computes
    std::vector<double> _rowSums;
    base::AlignedBuffer<double> _rowSumParts; // a part for each thread
    base::AlignedBuffer<float> _partial;
    std::size_t _partialStride = 0;
    double _build_ms = 0.0;
    std::chrono::steady_clock::time_point _start;
};

/// Returns the level nearest to \a amplitude among the ascending \a levels; without levels,
/// \a amplitude limited to 0 .. 1.
float playableAmplitude(const std::vector<float>& levels, float amplitude);
/// Sets \a m amplitudes with the mean \a mean: some at the next of the ascending \a levels below
/// it, some at the next above, evenly distributed.
void mixAmplitudes(const std::vector<float>& levels, float mean, int m, float* amplitudes);

} // namespace midair::haptics
