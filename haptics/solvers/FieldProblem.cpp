#include "haptics/solvers/FieldProblem.h"

#include "haptics/points/FittedLevel.h"

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

namespace
{

/// The playable amplitudes below and above a wanted one. Below the lowest level is silence, which
/// every array can play.
struct Between
{
    float low, high, share; ///< share of the way from low to high, 0 .. 1
};

Between betweenLevels(const std::vector<float>& levels, float wanted)
{
    if (levels.empty()) return {wanted, wanted, 1.0f};
    const auto above = std::lower_bound(levels.begin(), levels.end(), wanted);
    const float high = above == levels.end() ? levels.back() : *above;
    const float low = high == wanted ? high : above == levels.begin() ? 0.0f : *(above - 1);
    return {low, high, high > low ? (wanted - low) / (high - low) : 1.0f};
}

// Multiples of the golden ratio are evenly spread, and a larger mean raises some transducers and
// lowers none. Each place is computed alone, so that compilers vectorise the loop.
template<typename Choose>
void inEvenMix(int m, const Choose& choose)
{
    constexpr double kGolden = 0.6180339887498949;
    for (int i = 0; i < m; ++i)
    {
        const double sum = 0.5 + (i + 1) * kGolden;
        choose(i, sum - static_cast<double>(static_cast<int>(sum)));
    }
}

} // namespace

void mixAmplitudes(const std::vector<float>& levels, float mean, int m, float* amplitudes)
{
    const Between one = betweenLevels(levels, std::clamp(mean, 0.0f, 1.0f));
    const auto share = static_cast<double>(one.share);
    inEvenMix(m, [&](int i, double place) { amplitudes[i] = place < share ? one.high : one.low; });
}

void roundAmplitudes(const std::vector<float>& levels, int m, float* amplitudes, double most)
{
    if (levels.empty()) return;
    double wanted = 0.0, played = 0.0;
    for (int i = 0; i < m; ++i)
    {
        wanted += static_cast<double>(amplitudes[i]);
        played += static_cast<double>(playableAmplitude(levels, amplitudes[i]));
    }
    if (std::fabs(played - wanted) <= most * wanted)
    {
        for (int i = 0; i < m; ++i)
            amplitudes[i] = playableAmplitude(levels, amplitudes[i]);
        return;
    }
    inEvenMix(m,
              [&](int i, double place)
              {
                  const Between one = betweenLevels(levels, amplitudes[i]);
                  amplitudes[i] = place < static_cast<double>(one.share) ? one.high : one.low;
              });
}

std::vector<int> evenOrder(int m)
{
    std::vector<std::pair<double, int>> places(static_cast<std::size_t>(m));
    inEvenMix(m, [&](int i, double place) { places[static_cast<std::size_t>(i)] = {place, i}; });
    std::sort(places.begin(), places.end());
    std::vector<int> order;
    order.reserve(places.size());
    for (const auto& [place, i] : places)
        order.push_back(i);
    return order;
}

int FieldProblem::assign(const ControlPoints& points,
                         const std::vector<int>& active,
                         const TransducerArray& array,
                         const Medium& medium,
                         double tolerance_m,
                         bool isBound,
                         const Eigen::VectorXcf& drive)
{
    const int n = static_cast<int>(active.size());
    const int before = G.points();
    const bool rebound = !isBound && G.bind(array, medium);
    const bool otherSize = G.resize(n);
    _drive = array.drive;
    const Eigen::VectorXcd none, &given = points.outside_Pa;
    const bool otherOutside = G.setOutside(given.size() > 0 ? given(active).eval() : none, drive);
    const bool otherRows = G.setOutsideRows(points.outsideRows_Pa, active);
    if (rebound || otherSize || otherOutside || otherRows) forget();
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
    if (_takenBlocks < G.blocks())
    {
        _takenBlocks = G.blocks();
        _isTaken = std::make_unique<std::atomic<bool>[]>(static_cast<std::size_t>(_takenBlocks));
    }
    if (_positions.cols() < G.points())
    {
        _positions.resize(3, G.points());
        _fresh.assign(n, 0);
        _rowSums.resize(n);
        _stale.reserve(n);
    }
    // The sums of two blocks never share a cache line.
    const std::size_t stride = (2 * n + 31) / 16 * 16;
    _partialStride = std::max(_partialStride, stride);
    _partial.reserve(_partialStride * static_cast<std::size_t>(G.blocks()));
    _rowSumParts.reserve(_partialStride * static_cast<std::size_t>(G.blocks()));
}

void FieldProblem::buildBlock(int block)
{
    // Rows between two checks for a stop request (SOLVER.md, "Limits"): with thousands of points a
    // block takes up to a tenth of a second if its entries are computed in double.
    constexpr int kRows = 512;
    std::fill_n(rowSums(block), n(), 0.0);
    const int count = static_cast<int>(_stale.size());
    for (int first = 0; first < count && !_stop.requested(); first += kRows)
        G.buildRows(block, _stale.data() + first, std::min(kRows, count - first), rowSums(block));
}

void FieldProblem::sumRows()
{
    for (const int l : _stale)
    {
        const auto row = static_cast<std::size_t>(l);
        double sum = 0.0;
        for (int block = 0; block < G.blocks(); ++block)
            sum += rowSums(block)[row];
        _rowSums[row] = sum;
        _fresh[row] = 1;
    }
}

void FieldProblem::build()
{
    const double start = elapsed_ms();
    eachBlock([this](int, int block) { buildBlock(block); });
    sumRows();
    _build_ms = elapsed_ms() - start;
}

void FieldProblem::buildAndProject(const SplitVector& weights, SplitVector& to)
{
    double build_ms = 0.0;
    eachBlock(
        [&](int thread, int block)
        {
            const double start = thread == 0 ? elapsed_ms() : 0.0;
            buildBlock(block);
            if (thread == 0) build_ms += elapsed_ms() - start;
            projectBlock(block, weights);
        });
    sumRows();
    sumPartials(to);
    clearPadding(q);
    _build_ms = build_ms;
}

bool FieldProblem::crowds(double spacing) const
{
    // Each point is compared with all others, so with thousands of points a part of them must do.
    constexpr int kSample = 256;
    const int stride = std::max(1, n() / kSample);
    const double most = std::pow(spacing * G.wavelength_m(), 2);
    int crowded = 0, looked = 0;
    for (int l = 0; l < n(); l += stride, ++looked)
    {
        const Eigen::Vector3d r = _positions.col(l);
        bool isNear = false;
        for (int k = 0; k < n() && !isNear; ++k)
            isNear = k != l && (_positions.col(k) - r).squaredNorm() < most;
        crowded += isNear;
    }
    return 2 * crowded > looked;
}

double FieldProblem::meanRowSum() const
{
    double sum = 0.0;
    for (int l = 0; l < n(); ++l)
        sum += rowSum(l);
    return n() > 0 ? sum / n() : 0.0;
}

void FieldProblem::sumPartials(SplitVector& sum)
{
    std::fill_n(sum.re.data(), n(), 0.0f);
    std::fill_n(sum.im.data(), n(), 0.0f);
    addPartials(sum);
}

void FieldProblem::addPartials(SplitVector& sum)
{
    for (int l = 0; l < n(); ++l)
    {
        float re = 0.0f, im = 0.0f;
        for (int block = 0; block < G.blocks(); ++block)
        {
            re += partial(block)[l];
            im += partial(block)[n() + l];
        }
        const auto row = static_cast<std::size_t>(l);
        sum.set(row, sum.at(row) + std::complex<float>(re, im));
    }
}

void FieldProblem::backward(const SplitVector& from, SplitVector& to)
{
    eachBlock([&](int, int block)
              { G.backward(block, from.re.data(), from.im.data(), to.re.data(), to.im.data()); });
}

void FieldProblem::forwardBlock(int block, const SplitVector& from, int first)
{
    float *re = partial(block), *im = re + n();
    std::fill_n(re, 2 * n(), 0.0f);
    if (first == 0)
        G.forward(block, from.re.data(), from.im.data(), re, im);
    else
        G.forwardFrom(block, first, from.re.data(), from.im.data(), re, im);
}

void FieldProblem::forward(const SplitVector& from, SplitVector& to)
{
    eachBlock([&](int, int block) { forwardBlock(block, from); });
    sumPartials(to);
}

void FieldProblem::projectBlock(int block, const SplitVector& weights)
{
    G.backward(block, weights.re.data(), weights.im.data(), z.re.data(), z.im.data());
    const int i = G.offset(block);
    kernels::projectToUnit(G.width(block),
                           z.re.data() + i,
                           z.im.data() + i,
                           q.re.data() + i,
                           q.im.data() + i,
                           inverse.data() + i);
    if (_roundsEndOnLevels && _drive.phaseLevels > 0)
        kernels::quantisePhase(G.width(block),
                               _drive.phaseLevels,
                               q.re.data() + i,
                               q.im.data() + i,
                               q.re.data() + i,
                               q.im.data() + i);
    forwardBlock(block, q);
}

void FieldProblem::projectRound(const SplitVector& weights, SplitVector& to)
{
    eachBlock([&](int, int block) { projectBlock(block, weights); });
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
        if (y[l] > kLeastPressure) u.set(row, value / y[l]);
    }
}

void FieldProblem::toLanes(const Eigen::VectorXcf& from, SplitVector& lanes) const
{
    lanes.reserve(static_cast<std::size_t>(G.paddedTransducers())); // it may be shorter, for
                                                                    // another array
    for (int lane = 0; lane < m(); ++lane)
        lanes.set(static_cast<std::size_t>(lane), from[G.order()[static_cast<std::size_t>(lane)]]);
    clearSilent(lanes);
    clearPadding(lanes);
}

void FieldProblem::fromLanes(const SplitVector& lanes, Eigen::VectorXcf& to) const
{
    if (to.size() != arraySize()) to.resize(arraySize());
    const bool hasSilent = G.hasSilentLanes();
    if (hasSilent || m() < arraySize()) to.setZero();
    for (int lane = 0; lane < m(); ++lane)
        if (!hasSilent || !G.isSilent(lane))
            to[G.order()[static_cast<std::size_t>(lane)]] =
                lanes.at(static_cast<std::size_t>(lane));
}

void FieldProblem::clearSilent(SplitVector& v) const
{
    for (int lane = 0; lane < m() && G.hasSilentLanes(); ++lane)
        if (G.isSilent(lane)) v.set(static_cast<std::size_t>(lane), 0.0f);
}

void FieldProblem::clearPadding(SplitVector& v) const
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

void weighPhases(FieldProblem& field, const Eigen::VectorXf& weights)
{
    for (int l = 0; l < field.n(); ++l)
    {
        const auto row = static_cast<std::size_t>(l);
        field.w.set(row, field.u.at(row) * weights[l]);
    }
}

void projectionRound(FieldProblem& field, const Eigen::VectorXf& weights)
{
    weighPhases(field, weights);
    field.projectRound(field.w, field.p);
    field.phasesOf(field.p);
}

void reweigh(const FieldProblem& field, Eigen::VectorXf& weights, float mostReweighing)
{
    const float s = fittedLevel(field.y, field.a);
    for (int l = 0; l < field.n(); ++l)
        weights[l] *= std::clamp(s * field.a[l] / std::max(field.y[l], kLeastPressure),
                                 1.0f / mostReweighing,
                                 mostReweighing);
}

} // namespace midair::haptics
