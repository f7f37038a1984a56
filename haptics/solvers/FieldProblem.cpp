#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

float playableAmplitude(const std::vector<float>& levels, float amplitude)
{
    const float wanted = std::clamp(amplitude, 0.0f, 1.0f);
    if (levels.empty()) return wanted;
    const auto above = std::lower_bound(levels.begin(), levels.end(), wanted);
    if (above == levels.begin()) return *above;
    if (above == levels.end()) return levels.back();
    return *above - wanted < wanted - *(above - 1) ? *above : *(above - 1);
}

void mixAmplitudes(const std::vector<float>& levels, float mean, int m, float* amplitudes)
{
    const float wanted = std::clamp(mean, 0.0f, 1.0f);
    float low = wanted, high = wanted;
    if (!levels.empty())
    {
        const auto above = std::lower_bound(levels.begin(), levels.end(), wanted);
        high = above == levels.end() ? levels.back() : *above;
        low = above == levels.begin() || high == wanted ? high : *(above - 1);
    }
    const float share = high > low ? (wanted - low) / (high - low) : 1.0f;
    float owed = 0.5f;
    for (int i = 0; i < m; ++i)
    {
        owed += share;
        const bool isHigh = owed >= 1.0f;
        owed -= isHigh ? 1.0f : 0.0f;
        amplitudes[i] = isHigh ? high : low;
    }
}

int FieldProblem::assign(const ControlPoints& points,
                         const std::vector<int>& active,
                         const TransducerArray& array,
                         const Medium& medium,
                         double tolerance_m,
                         bool isBound)
{
    const int n = static_cast<int>(active.size());
    const int before = G.points();
    const bool rebound = !isBound && G.bind(array, medium);
    const bool otherSize = G.resize(n);
    _drive = array.drive;
    if (rebound || otherSize) forget();
    reserve();
    if (n != before) _fresh.assign(_fresh.size(), 0);

    _stale.clear();
    for (int l = 0; l < n; ++l)
    {
        const Eigen::Vector3d r = points.positions.col(active[static_cast<std::size_t>(l)]);
        a[l] = static_cast<float>(points.targets[active[static_cast<std::size_t>(l)]]);
        unsigned char& fresh = _fresh[static_cast<std::size_t>(l)];
        if (fresh && (r - _positions.col(l)).norm() <= tolerance_m && tolerance_m > 0.0) continue;
        fresh = 0;
        _positions.col(l) = r;
        G.setPoint(l, r);
        _stale.push_back(l);
    }
    return static_cast<int>(_stale.size());
}

void FieldProblem::reserve()
{
    const auto n = static_cast<std::size_t>(G.points());
    const auto m = static_cast<std::size_t>(G.paddedTransducers());
    if (a.size() != G.points())
    {
        a.resize(G.points());
        y.resize(G.points());
    }
    for (SplitVector* v : {&u, &p, &w})
        v->reserve(n);
    for (SplitVector* v : {&z, &q})
        v->reserve(m);
    inverse.reserve(m);
    if (_positions.cols() < G.points())
    {
        _positions.resize(3, G.points());
        _fresh.assign(n, 0);
        _rowSums.resize(n);
        _stale.reserve(n);
    }
    // The sums of two threads never share a cache line.
    const std::size_t stride = (2 * n + 31) / 16 * 16;
    _partialStride = std::max(_partialStride, stride);
    _partial.reserve(_partialStride * static_cast<std::size_t>(_pool->threads()));
    _rowSumParts.reserve(_partialStride * static_cast<std::size_t>(_pool->threads()));
}

void FieldProblem::buildBlock(int thread, int block)
{
    // Rows between two checks for a stop request (SOLVER.md, "Limits"): with thousands of points
    // a block takes up to a tenth of a second if its entries are computed in double.
    constexpr int kRows = 512;
    const int count = static_cast<int>(_stale.size());
    for (int first = 0; first < count && !_stop.requested(); first += kRows)
        G.buildRows(block, _stale.data() + first, std::min(kRows, count - first), rowSums(thread));
}

void FieldProblem::sumRows()
{
    for (const int l : _stale)
    {
        const auto row = static_cast<std::size_t>(l);
        double sum = 0.0;
        for (int thread = 0; thread < threads(); ++thread)
            sum += rowSums(thread)[row];
        _rowSums[row] = sum;
        _fresh[row] = 1;
    }
}

void FieldProblem::build()
{
    const double start = elapsed_ms();
    eachBlock([this](int thread) { std::fill_n(rowSums(thread), n(), 0.0); },
              [this](int thread, int block) { buildBlock(thread, block); });
    sumRows();
    _build_ms = elapsed_ms() - start;
}

void FieldProblem::buildAndProject(const SplitVector& weights, SplitVector& to)
{
    double build_ms = 0.0;
    eachBlock(
        [this](int thread)
        {
            std::fill_n(rowSums(thread), n(), 0.0);
            clearPartial(thread);
        },
        [&](int thread, int block)
        {
            const double start = thread == 0 ? elapsed_ms() : 0.0;
            buildBlock(thread, block);
            if (thread == 0) build_ms += elapsed_ms() - start;
            projectBlock(thread, block, weights);
        });
    sumRows();
    sumPartials(to);
    clearPadding(q);
    _build_ms = build_ms;
}

double FieldProblem::meanRowSum() const
{
    double sum = 0.0;
    for (int l = 0; l < n(); ++l)
        sum += rowSum(l);
    return n() > 0 ? sum / n() : 0.0;
}

void FieldProblem::clearPartial(int thread)
{
    std::fill(partial(thread), partial(thread) + 2 * n(), 0.0f);
}

void FieldProblem::sumPartials(SplitVector& sum)
{
    for (int l = 0; l < n(); ++l)
    {
        float re = 0.0f, im = 0.0f;
        for (int thread = 0; thread < _pool->threads(); ++thread)
        {
            re += partial(thread)[l];
            im += partial(thread)[n() + l];
        }
        sum.set(static_cast<std::size_t>(l), {re, im});
    }
}

void FieldProblem::backward(const SplitVector& from, SplitVector& to)
{
    eachBlock([](int) {},
              [&](int, int block)
              { G.backward(block, from.re.data(), from.im.data(), to.re.data(), to.im.data()); });
}

void FieldProblem::forwardBlock(int thread, int block, const SplitVector& from)
{
    G.forward(block, from.re.data(), from.im.data(), partial(thread), partial(thread) + n());
}

void FieldProblem::forward(const SplitVector& from, SplitVector& to)
{
    eachBlock([this](int thread) { clearPartial(thread); },
              [&](int thread, int block) { forwardBlock(thread, block, from); });
    sumPartials(to);
}

void FieldProblem::projectBlock(int thread, int block, const SplitVector& weights)
{
    G.backward(block, weights.re.data(), weights.im.data(), z.re.data(), z.im.data());
    const int i = G.offset(block);
    kernels::projectToUnit(G.width(block),
                           z.re.data() + i,
                           z.im.data() + i,
                           q.re.data() + i,
                           q.im.data() + i,
                           inverse.data() + i);
    forwardBlock(thread, block, q);
}

void FieldProblem::projectRound(const SplitVector& weights, SplitVector& to)
{
    eachBlock([this](int thread) { clearPartial(thread); },
              [&](int thread, int block) { projectBlock(thread, block, weights); });
    sumPartials(to);
    clearPadding(q);
}

void FieldProblem::phasesOf(const SplitVector& field)
{
    for (int l = 0; l < n(); ++l)
    {
        const auto row = static_cast<std::size_t>(l);
        const std::complex<float> value = field.at(row);
        y[l] = std::abs(value);
        if (y[l] > kLeastPressure_Pa) u.set(row, value / y[l]);
    }
}

void FieldProblem::toLanes(const Eigen::VectorXcf& from, SplitVector& lanes) const
{
    for (int lane = 0; lane < m(); ++lane)
        lanes.set(static_cast<std::size_t>(lane), from[G.order()[static_cast<std::size_t>(lane)]]);
}

void FieldProblem::fromLanes(const SplitVector& lanes, Eigen::VectorXcf& to) const
{
    if (to.size() != m()) to.resize(m());
    for (int lane = 0; lane < m(); ++lane)
        to[G.order()[static_cast<std::size_t>(lane)]] = lanes.at(static_cast<std::size_t>(lane));
}

void FieldProblem::clearPadding(SplitVector& v)
{
    for (int i = m(); i < G.paddedTransducers(); ++i)
        v.set(static_cast<std::size_t>(i), 0.0f);
}

void FieldProblem::quantisePhases(const SplitVector& from, SplitVector& to)
{
    const int width = G.paddedTransducers();
    kernels::quantisePhase(
        width, _drive.phaseLevels, from.re.data(), from.im.data(), to.re.data(), to.im.data());
    clearPadding(to);
}

void FieldProblem::quantise(float scale)
{
    const int width = G.paddedTransducers();
    for (int i = 0; i < width; ++i)
    {
        const auto s = static_cast<std::size_t>(i);
        inverse[s] = playableAmplitude(_drive.amplitudeLevels, scale * std::abs(q.at(s)));
    }
    quantisePhases(q, q);
    kernels::scaleBy(width, inverse.data(), q.re.data(), q.im.data());
}

Eigen::MatrixXcf FieldProblem::dense() const
{
    Eigen::MatrixXcf result(n(), m());
    for (int i = 0; i < m(); ++i)
        for (int l = 0; l < n(); ++l)
            result(l, i) = G.at(l, i);
    return result;
}

double FieldProblem::elapsed_ms() const
{
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - _start)
        .count();
}

} // namespace midair::haptics
