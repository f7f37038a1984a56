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

/// Pressures below this have no phase, and quotients by them take this instead, so that they stay
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

/// The points that are solved for, their matrix and every vector of a solve: what all solvers
/// share. Symbols as in the paper: G (n x m), q (m), p = G q (n), a the targets (n), u the phases
/// of p.
class FieldProblem
{
public:
    explicit FieldProblem(int threads, Storage storage = Storage::FLOAT) :
        FieldProblem(std::make_shared<base::ThreadPool>(threads), storage)
    {
    }
    /// \a pool isn't null; nobody else runs it meanwhile. What reads all of G throws Stopped where
    /// \a stop asks for it.
    explicit FieldProblem(std::shared_ptr<base::ThreadPool> pool,
                          Storage storage = Storage::FLOAT,
                          base::StopToken stop = {}) :
        G(storage),
        _pool(std::move(pool)),
        _stop(std::move(stop))
    {
    }

    /// True if array and medium are those of the last assign, as far as G depends on them.
    bool isBoundTo(const TransducerArray& array, const Medium& medium) const
    {
        return G.isBoundTo(array, medium);
    }
    /// Takes over a problem whose input is sound; \a isBound if isBoundTo has just said so. \a
    /// active are the indices of the points to be solved for. Rows of points that moved by no more
    /// than \a tolerance_m are kept. Returns how many rows are stale now; build() computes them.
    int assign(const ControlPoints& points,
               const std::vector<int>& active,
               const TransducerArray& array,
               const Medium& medium,
               double tolerance_m,
               bool isBound = false);
    void build();
    /// build() and projectRound() in one: a block of G takes part in the round while it is in the
    /// cache.
    void buildAndProject(const SplitVector& w, SplitVector& p);
    /// How long the last build took, on the calling thread.
    double build_ms() const { return _build_ms; }
    /// The next assign keeps no rows.
    void forget() { _fresh.assign(_fresh.size(), 0); }

    int n() const { return G.points(); }
    int m() const { return G.transducers(); }
    const DriveResolution& drive() const { return _drive; }
    /// mean_l sum_i |G_li|, Pa: what one focus would have.
    double meanRowSum() const;
    double rowSum(int l) const { return _rowSums[static_cast<std::size_t>(l)]; }

    /// z = G* w.
    void backward(const SplitVector& w, SplitVector& z);
    /// p = G q.
    void forward(const SplitVector& q, SplitVector& p);
    /// One round, G read once: z = G* w, q = z/|z|, p = G q.
    void projectRound(const SplitVector& w, SplitVector& p);
    /// y_l = |p_l|, u_l = p_l/|p_l| (u_l stays where p_l = 0).
    void phasesOf(const SplitVector& p);
    /// Unit amplitudes, phases of \a from to the nearest level.
    void quantisePhases(const SplitVector& from, SplitVector& to);
    void clearPadding(SplitVector& v); ///< v_i = 0 for i >= m
    /// q as a device can play it: amplitudes times \a scale, clipped to 1 and rounded to the
    /// nearest level.
    void quantise(float scale);

    Eigen::MatrixXcf dense() const; ///< G itself, for methods that need columns

    /// \a q (transducers in the array's order) into \a lanes (in the matrix's order, padded), and
    /// back.
    void toLanes(const Eigen::VectorXcf& q, SplitVector& lanes) const;
    void fromLanes(const SplitVector& lanes, Eigen::VectorXcf& q) const;

    double elapsed_ms() const;
    void start() { _start = std::chrono::steady_clock::now(); }

    PropagationMatrix G;
    Eigen::VectorXf a;                  ///< n, the targets, > 0
    Eigen::VectorXf y;                  ///< n, |p|
    SplitVector u, p, w;                ///< n
    SplitVector z, q;                   ///< paddedTransducers()
    base::AlignedBuffer<float> inverse; ///< 1/|z_i|

    int threads() const { return _pool->threads(); }
    const base::StopToken& stop() const { return _stop; }
    /// Calls before(thread) once and then inBlock(thread, block) for every block of the thread, on
    /// all threads. Blocks belong to threads by their number alone, so that sums come out the same
    /// every time. Throws Stopped, some blocks left out, where that is asked for.
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
    /// Partial sums over transducers of thread \a thread, 2 x n floats, and their sum into \a p.
    float* partial(int thread)
    {
        return _partial.data() + static_cast<std::size_t>(thread) * _partialStride;
    }
    void clearPartial(int thread);
    /// partial += G q over one block.
    void forwardBlock(int thread, int block, const SplitVector& q);
    void sumPartials(SplitVector& p);

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
    Eigen::Matrix3Xd _positions; // of the rows as they were built
    std::vector<unsigned char> _fresh;
    std::vector<int> _stale; // rows that build() computes
    std::vector<double> _rowSums;
    base::AlignedBuffer<double> _rowSumParts; // thread by thread
    base::AlignedBuffer<float> _partial;
    std::size_t _partialStride = 0;
    double _build_ms = 0.0;
    std::chrono::steady_clock::time_point _start;
};

/// The level nearest to \a amplitude among the ascending \a levels; itself, within 0 .. 1, where
/// there are none.
float playableAmplitude(const std::vector<float>& levels, float amplitude);
/// \a m amplitudes of \a mean between two of the ascending \a levels: some at the one, some at the
/// other, evenly spread.
void mixAmplitudes(const std::vector<float>& levels, float mean, int m, float* amplitudes);

} // namespace midair::haptics
