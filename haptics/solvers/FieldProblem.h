#pragma once

#include "haptics/base/AlignedBuffer.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/base/threads/ThreadPool.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

namespace midair::haptics
{

/// Pressures below this, in PropagationMatrix::unit_Pa(), have no phase; divisions by them use this
/// value, so the result stays finite.
constexpr float kLeastPressure = 1e-30f;

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

/// Copies the first \a count numbers.
inline void copy(const SplitVector& from, SplitVector& to, std::size_t count)
{
    std::copy_n(from.re.data(), count, to.re.data());
    std::copy_n(from.im.data(), count, to.im.data());
}

/// The active points, their matrix and the vectors of a solve, shared by all solvers. Symbols as in
/// the paper: G (n x m), q (m), p = G q (n), a the targets (n), u the phases of p. Pressures are in
/// unit_Pa().
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

    /// Returns true if array and medium equal those of the last assign() in everything that G
    /// depends on.
    bool isBoundTo(const TransducerArray& array, const Medium& medium) const
    {
        return G.isBoundTo(array, medium);
    }
    /// Assigns a valid problem. \a active: indices of the points to solve for. Rows of points that
    /// moved by at most \a tolerance_m are kept. \a isBound: result of isBoundTo(). \a drive
    /// (arraySize()): that of points.outside_Pa, if it has those. Returns the number of stale rows,
    /// which build() computes.
    int assign(const ControlPoints& points,
               const std::vector<int>& active,
               const TransducerArray& array,
               const Medium& medium,
               double tolerance_m,
               bool isBound = false,
               const Eigen::VectorXcf& drive = {});
    void build(); ///< computes the stale rows of G
    int staleRows() const { return static_cast<int>(_stale.size()); } ///< of the last assign()
    /// build() and projectRound() in one pass, which uses each block of G while it is cached.
    void buildAndProject(const SplitVector& w, SplitVector& p);
    /// Returns the duration of the last build on the calling thread.
    double build_ms() const { return _build_ms; }
    /// Makes the next assign() discard all rows.
    void forget() { _fresh.assign(_fresh.size(), 0); }

    int n() const { return G.points(); }
    /// Number of columns; dead transducers are left out, see PropagationMatrix.
    int m() const { return G.transducers(); }
    int arraySize() const { return G.arraySize(); } ///< all transducers, including dead ones
    const DriveResolution& drive() const { return _drive; }
    /// Returns true if more than half of the points, or of 256 and more of them that are evenly
    /// spread over their indices, have a neighbour nearer than \a spacing wavelengths.
    bool crowds(double spacing) const;
    /// Unit of G, p, y and of the row sums, Pa; 1 for usual arrays (PropagationMatrix::unit_Pa()).
    double unit_Pa() const { return G.unit_Pa(); }
    /// Returns mean_l sum_i |G_li|, in unit_Pa(): the mean pressure of a single focus.
    double meanRowSum() const;
    /// Returns sum_i |G_li|, in unit_Pa().
    double rowSum(int l) const { return _rowSums[static_cast<std::size_t>(l)]; }

    /// z = G* w.
    void backward(const SplitVector& w, SplitVector& z);
    /// p = G q.
    void forward(const SplitVector& q, SplitVector& p);
    /// One round, G read once: z = G* w, q = z/|z|, p = G q.
    void projectRound(const SplitVector& w, SplitVector& p);
    /// If \a onLevels, later rounds set q to the device's phase levels, so that their fields are
    /// playable as they are.
    void endRoundsOnLevels(bool onLevels) { _roundsEndOnLevels = onLevels; }
    /// y_l = |p_l|, u_l = p_l/|p_l|; u_l is kept where |p_l| is at most kLeastPressure.
    void phasesOf(const SplitVector& p);
    /// Sets \a to to unit amplitudes with the phases of \a from, rounded to the nearest level.
    void quantisePhases(const SplitVector& from, SplitVector& to);
    void clearPadding(SplitVector& v) const; ///< v_i = 0 for i >= m
    /// v_i = 0 for zero columns of G, whose drive has no effect.
    void clearSilent(SplitVector& v) const;
    /// Makes q playable: amplitudes times \a scale, clipped to 1 and rounded to the nearest level,
    /// and phases rounded to the nearest level.
    void quantise(float scale);

    Eigen::MatrixXcf dense() const; ///< G (n x m) as one matrix, for methods that need columns

    /// Copies \a q (arraySize(), in the array's order) into \a lanes (m(), in the matrix's order,
    /// padded), and back; dead transducers get 0.
    void toLanes(const Eigen::VectorXcf& q, SplitVector& lanes) const;
    void fromLanes(const SplitVector& lanes, Eigen::VectorXcf& q) const;

    double elapsed_ms() const; ///< time since start()
    /// Begins a solve: wakes the pool's threads while the caller prepares it.
    void start()
    {
        _start = std::chrono::steady_clock::now();
        _pool->wake();
    }

    PropagationMatrix G;
    Eigen::VectorXf a;                  ///< n, the targets, > 0
    Eigen::VectorXf y;                  ///< n, |p|
    SplitVector u, p, w;                ///< n
    SplitVector z, q;                   ///< paddedTransducers()
    base::AlignedBuffer<float> inverse; ///< 1/|z_i|

    int threads() const { return _pool->threads(); }
    const base::StopToken& stop() const { return _stop; }
    /// Calls inBlock(thread, block) for each block, on all threads. Each thread has its own blocks,
    /// which stay in its core's cache between calls; a thread that is done helps those that woke up
    /// late. Throws Stopped on a stop request; some blocks are then not visited.
    template<typename InBlock>
    void eachBlock(const InBlock& inBlock)
    {
        for (int b = 0; b < G.blocks(); ++b)
            _isTaken[b].store(false, std::memory_order_relaxed);
        _pool->runHelped(
            [&](int thread)
            {
                const int first = firstBlock(thread), last = firstBlock(thread + 1);
                for (int b = first; b < last; ++b)
                    take(thread, b, inBlock);
                for (int b = G.blocks() - 1; b >= 0; --b)
                    if (b < first || b >= last) take(thread, b, inBlock);
            });
        _stop.throwIfRequested();
    }
    /// Returns the partial sums over the transducers of block \a block, 2 x n floats (re, im). Sums
    /// are made per block and then added in block order, so they don't depend on the number of
    /// threads.
    float* partial(int block)
    {
        return _partial.data() + static_cast<std::size_t>(block) * _partialStride;
    }
    /// partial = G q over one block, from its lane \a first on (only Storage::FIXED, if not 0).
    void forwardBlock(int block, const SplitVector& q, int first = 0);
    void sumPartials(SplitVector& p); ///< p = sum of the partial sums of all blocks
    void addPartials(SplitVector& p); ///< p += sum of the partial sums of all blocks

private:
    int firstBlock(int thread) const { return G.blocks() * thread / threads(); }
    template<typename InBlock>
    void take(int thread, int block, const InBlock& inBlock)
    {
        if (_stop.requested() || _isTaken[block].exchange(true, std::memory_order_relaxed)) return;
        inBlock(thread, block);
    }
    void reserve();
    void buildBlock(int block);
    void sumRows();
    void projectBlock(int block, const SplitVector& w);
    double* rowSums(int block)
    {
        return _rowSumParts.data() + static_cast<std::size_t>(block) * _partialStride;
    }

    std::shared_ptr<base::ThreadPool> _pool;
    base::StopToken _stop;
    DriveResolution _drive;
    bool _roundsEndOnLevels = false;
    Eigen::Matrix3Xd _positions;                   // positions for which the rows were built
    std::unique_ptr<std::atomic<bool>[]> _isTaken; // for each block: taken by a thread of
                                                   // eachBlock()
    int _takenBlocks = 0;                          // length of _isTaken
    std::vector<unsigned char> _fresh;             // 1: the row is built
    std::vector<int> _stale;                       // rows that build() computes
    std::vector<double> _rowSums;
    base::AlignedBuffer<double> _rowSumParts; // a part for each block
    base::AlignedBuffer<float> _partial;
    std::size_t _partialStride = 0;
    double _build_ms = 0.0;
    std::chrono::steady_clock::time_point _start;
};

/// Returns the level nearest to \a amplitude among the ascending \a levels; without levels, \a
/// amplitude limited to 0 .. 1.
float playableAmplitude(const std::vector<float>& levels, float amplitude);
/// Sets \a m amplitudes with the mean \a mean: some at the next of the ascending \a levels below it
/// (0 below the first), some at the next above, evenly distributed.
void mixAmplitudes(const std::vector<float>& levels, float mean, int m, float* amplitudes);
/// Largest change by roundAmplitudes() of the sum of all amplitudes (SOLVER.md, "Amplitudes").
constexpr double kCoarseSum = 0.01;
constexpr double kCoarseTarget = 1e-3; ///< for targets in Pa
/// Rounds \a m amplitudes of 0 .. 1 to playable ones: each to the nearest of the ascending \a
/// levels; if that would change the sum of all by more than the share \a most, to the next level
/// below or above, in an even mix that keeps the sum.
void roundAmplitudes(const std::vector<float>& levels,
                     int m,
                     float* amplitudes,
                     double most = kCoarseSum);
/// Returns 0 .. m - 1 in the order in which an even mix raises them.
std::vector<int> evenOrder(int m);

// Figures of the field in a FieldProblem: y = |p| in Pa, a the targets.

/// Returns the rms of y_l/(s a_l) - 1.
inline float errorOf(const FieldProblem& field, float s)
{
    return relativeRms(field.y, field.a, s);
}

/// Returns s = (y.a)/(a.a), Pa at a_l = 1.
inline float fittedLevel(const FieldProblem& field)
{
    return fittedLevel(field.y, field.a);
}

/// Returns the loudness E = s |a| / mean_l(sum_i |G_li|).
inline float loudnessAt(const FieldProblem& field, float s)
{
    return loudnessOf(s, field.a.norm(), static_cast<float>(field.meanRowSum()));
}

/// Returns an estimate of the rms error due to changes of the transducers' drives by \a spread
/// (rms, relative), which are independent of each other (haptics/SOLVER.md, "Rounding"). \a
/// amplitude: rms |q_i|.
inline float errorOfSpread(const FieldProblem& field, float amplitude, float spread)
{
    // Quieter fields count as this loud, so that the estimate stays finite.
    constexpr float kLeastLoudness = 0.05f;
    return spread * std::sqrt(static_cast<float>(field.n()) / static_cast<float>(field.m())) /
           std::max(loudnessAt(field, fittedLevel(field)) / amplitude, kLeastLoudness);
}

/// errorOfSpread() of rounding to the device's phase levels; 0 for continuous phases.
inline float roundingError(const FieldProblem& field, float amplitude)
{
    constexpr float kOneLevel = 1.814f; // pi/sqrt(3): rms of a rounded phase times the levels, rad
    const int levels = field.drive().phaseLevels;
    if (levels == 0) return 0.0f;
    return errorOfSpread(field, amplitude, kOneLevel / static_cast<float>(std::max(levels, 2)));
}

// A round of weighted Gerchberg-Saxton between the points and the transducers, which play unit
// amplitudes (SOLVER.md, "Rounds").

/// Sets field.w to w_l u_l, where u = field.u are the phases of the pressures.
void weighPhases(FieldProblem& field, const Eigen::VectorXf& weights);

/// Makes a round: z = G* (w u), q = z/|z|, p = G q, y = |p|, u = p/|p|, all in \a field. Reads G
/// once.
void projectionRound(FieldProblem& field, const Eigen::VectorXf& weights);

/// Multiplies each weight w_l by s a_l/|p_l|, limited to 1/mostReweighing .. mostReweighing; s is
/// the fitted level.
void reweigh(const FieldProblem& field, Eigen::VectorXf& weights, float mostReweighing = 5.0f);

} // namespace midair::haptics
