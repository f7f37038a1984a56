#include "haptics/FieldProblem.h"

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

int FieldProblem::assign(const ControlPoints& points,
                         const std::vector<int>& active,
                         const TransducerArray& array,
                         const Medium& medium,
                         double tolerance_m)
{
    const int n = static_cast<int>(active.size());
    const int before = G.points();
    const bool otherField = G.bind(array, medium);
    const bool otherSize = G.resize(n);
    _drive = array.drive;
    if (otherField || otherSize) forget();
    reserve();
    if (n != before) _fresh.assign(_fresh.size(), 0);

    int stale = 0;
    for (int l = 0; l < n; ++l)
    {
        const Eigen::Vector3d r = points.positions.col(active[static_cast<std::size_t>(l)]);
        a[l] = static_cast<float>(points.targets[active[static_cast<std::size_t>(l)]]);
        unsigned char& fresh = _fresh[static_cast<std::size_t>(l)];
        if (fresh && (r - _positions.col(l)).norm() <= tolerance_m && tolerance_m > 0.0) continue;
        fresh = 0;
        _positions.col(l) = r;
        G.setPoint(l, r);
        ++stale;
    }
    return stale;
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
    }
    // Apart by a cache line, so that threads do not share one.
    const std::size_t stride = (2 * n + 31) / 16 * 16;
    _partialStride = std::max(_partialStride, stride);
    _partial.reserve(_partialStride * static_cast<std::size_t>(_pool.threads()));
    _rowSumParts.reserve(_partialStride * static_cast<std::size_t>(_pool.threads()));
}

void FieldProblem::build()
{
    _pool.run(
        [this](int thread)
        {
            double* sums = _rowSumParts.data() + static_cast<std::size_t>(thread) * _partialStride;
            std::fill(sums, sums + n(), 0.0);
            for (int b = firstBlock(thread); b < lastBlock(thread); ++b)
                for (int l = 0; l < n(); ++l)
                    if (!_fresh[static_cast<std::size_t>(l)])
                        sums[l] += static_cast<double>(G.buildRow(b, l));
        });
    for (int l = 0; l < n(); ++l)
    {
        const auto row = static_cast<std::size_t>(l);
        if (_fresh[row]) continue;
        double sum = 0.0;
        for (int thread = 0; thread < _pool.threads(); ++thread)
            sum += _rowSumParts[static_cast<std::size_t>(thread) * _partialStride + row];
        _rowSums[row] = sum;
        _fresh[row] = 1;
    }
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
        for (int thread = 0; thread < _pool.threads(); ++thread)
        {
            re += partial(thread)[l];
            im += partial(thread)[n() + l];
        }
        sum.set(static_cast<std::size_t>(l), {re, im});
    }
}

void FieldProblem::backward(const SplitVector& from, SplitVector& to)
{
    _pool.run(
        [&](int thread)
        {
            for (int b = firstBlock(thread); b < lastBlock(thread); ++b)
                G.backward(b, from.re.data(), from.im.data(), to.re.data(), to.im.data());
        });
}

void FieldProblem::forward(const SplitVector& from, SplitVector& to)
{
    _pool.run(
        [&](int thread)
        {
            clearPartial(thread);
            for (int b = firstBlock(thread); b < lastBlock(thread); ++b)
                G.forward(
                    b, from.re.data(), from.im.data(), partial(thread), partial(thread) + n());
        });
    sumPartials(to);
}

void FieldProblem::projectRound(const SplitVector& weights, SplitVector& to)
{
    _pool.run(
        [&](int thread)
        {
            clearPartial(thread);
            for (int b = firstBlock(thread); b < lastBlock(thread); ++b)
            {
                G.backward(b, weights.re.data(), weights.im.data(), z.re.data(), z.im.data());
                const int i = G.offset(b);
                kernels::projectToUnit(G.width(b),
                                       z.re.data() + i,
                                       z.im.data() + i,
                                       q.re.data() + i,
                                       q.im.data() + i,
                                       inverse.data() + i);
                G.forward(b, q.re.data(), q.im.data(), partial(thread), partial(thread) + n());
            }
        });
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
        if (y[l] > 1e-30f) u.set(row, value / y[l]);
    }
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
