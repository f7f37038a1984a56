#include "haptics/solvers/many/FieldPath.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/kernels/ShapingKernels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// SOLVER.md, "Many fields".
constexpr int kCorrections = 4;
constexpr int kConjugateSteps = 12;
constexpr ShapedRounding::Effort kShaping{0.25f, 3, 0.7f};
constexpr double kPathReach = 1e-3; // as SolverBase
constexpr int kUnlimited = 1000;

// The nearest integer, |x| < 2^22, without a call per number.
float nearest(float x)
{
    constexpr float kToInteger = 12582912.0f; // 1.5 * 2^23
    return (x + kToInteger) - kToInteger;
}

// A number in 0 .. 1 that looks random (SplitMix64, Steele, Lea, Flood 2014).
float scattered(std::uint64_t state)
{
    state += 0x9e3779b97f4a7c15U;
    state = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9U;
    state = (state ^ (state >> 27)) * 0x94d049bb133111ebU;
    return static_cast<float>((state ^ (state >> 31)) >> 40) * 0x1p-24f;
}

} // namespace

FieldPath::FieldPath(const TransducerArray& array,
                     const Medium& medium,
                     const ManyFieldsOptions& options) :
    _options(options),
    _array(array),
    _medium(medium),
    _field(1, Storage::FIXED),
    _search(_tuning),
    _step(_tuning.largestTurn_rad, _tuning.mostFreedom)
{
    _array.drive.phaseLevels = ManyFields::phaseLevelsOf(array);
    _array.drive.amplitudeLevels.clear();
    _tuning.coldStarts = 1;
    _field.G.buildQuickly();
}

void FieldPath::begin(int path)
{
    _path = path;
    _isFirst = true;
}

void FieldPath::assign(const ManyPoints& all, int field)
{
    const int n = all.points;
    if (_points.size() != n)
    {
        _points.positions.resize(3, n);
        _points.targets.resize(n);
        _active.resize(static_cast<std::size_t>(n));
        for (int l = 0; l < n; ++l)
            _active[static_cast<std::size_t>(l)] = l;
    }
    const auto first = static_cast<std::size_t>(field) * static_cast<std::size_t>(n);
    _points.positions = Eigen::Map<const Eigen::Matrix3Xd>(all.positions + 3 * first, 3, n);
    if (all.targets != nullptr)
        _points.targets =
            Eigen::Map<const Eigen::VectorXd>(all.targets + (all.sameTargets ? 0 : first), n);
    else
        _points.targets.setOnes();
    // A silent point is held silent: left out, it would have the field that others leave there.
    _points.targets = (_points.targets / _points.targets.maxCoeff()).cwiseMax(kLeastTarget);
    const bool isBound = _level.data() != nullptr;
    _field.assign(_points, _active, _array, _medium, 0.0, isBound);
    if (isBound) return;
    const auto lanes = static_cast<std::size_t>(_field.G.paddedTransducers());
    _level.reserve(lanes);
    _last.reserve(lanes);
}

void FieldPath::startPhases()
{
    const std::uint64_t seed = _options.seed + 0x100000001b3U * static_cast<std::uint64_t>(_path);
    for (int l = 0; l < _field.n(); ++l)
    {
        const auto row = static_cast<std::size_t>(l);
        const float turns = scattered(seed * 0x9e3779b97f4a7c15U + row);
        _field.u.set(row, std::polar(1.0f, static_cast<float>(base::kTwoPi) * turns));
    }
}

float FieldPath::wrapped(float difference) const
{
    return difference - levels() * nearest(difference * (1.0f / levels()));
}

void FieldPath::checkReach(int field) const
{
    double largest = 0.0;
    for (int l = 0; l < _field.n(); ++l)
        largest = std::max(largest, _field.rowSum(l));
    for (int l = 0; l < _field.n(); ++l)
        if (!(_field.rowSum(l) > kPathReach * largest))
            throw base::InputError(fmt::format("point {} of field {} is out of the array's reach "
                                               "at ({:g}, {:g}, {:g}) m",
                                               l,
                                               field,
                                               _points.positions(0, l),
                                               _points.positions(1, l),
                                               _points.positions(2, l)));
}

// The error of plain rounding is above what the tolerance leaves for it.
bool FieldPath::isShaped() const
{
    return quiet().rounding(_field, 1.0f) >
           _tuning.unshaped * static_cast<float>(_options.rmsTolerance);
}

// Turns all phases together, so that the drive changes least.
void FieldPath::alignToLast()
{
    const int width = _field.G.paddedTransducers();
    kernels::unitAtLevel(width, levels(), _last.data(), _field.z.re.data(), _field.z.im.data());
    _field.clearPadding(_field.z);
    const kernels::InnerProduct product = kernels::innerProduct(
        width, _field.q.re.data(), _field.q.im.data(), _field.z.re.data(), _field.z.im.data());
    const std::complex<float> sum(product.re, product.im);
    if (!(std::abs(sum) > 0.0f)) return;
    const std::complex<float> by = sum / std::abs(sum);
    kernels::scaleBy(width, by.real(), by.imag(), _field.q.re.data(), _field.q.im.data());
    _search.turn(by);
    for (int l = 0; l < _field.n(); ++l)
    {
        const auto row = static_cast<std::size_t>(l);
        _field.u.set(row, _field.u.at(row) * by);
        _field.p.set(row, _field.p.at(row) * by);
    }
}

// Limits phases to \a most levels from the last field's; returns true if that changed q.
bool FieldPath::keepNear(float most)
{
    const int width = _field.G.paddedTransducers();
    kernels::phaseInLevels(width, levels(), _field.q.re.data(), _field.q.im.data(), _level.data());
    bool isAny = false;
    for (int i = 0; i < _field.m(); ++i)
    {
        const auto lane = static_cast<std::size_t>(i);
        const float step = wrapped(_level[lane] - _last[lane]);
        if (!(std::fabs(step) > most)) continue;
        _level[lane] = wrapped(_last[lane] + std::clamp(step, -most, most));
        isAny = true;
    }
    if (!isAny) return false;
    kernels::unitAtLevel(width, levels(), _level.data(), _field.q.re.data(), _field.q.im.data());
    _field.clearPadding(_field.q);
    _field.forward(_field.q, _field.p);
    _field.phasesOf(_field.p);
    return true;
}

// Gauss-Newton steps until the error before rounding is a share of the tolerance. A step leaves
// about the square of the error before it, so the last one isn't measured.
void FieldPath::correct()
{
    const float goal = _tuning.enough * static_cast<float>(_options.rmsTolerance);
    // Shaped rounding may miss the limited phases by its reach.
    const float slack = isShaped() ? ShapedRounding::reach(_field, kShaping) : 0.0f;
    const float most =
        std::floor(static_cast<float>(_options.largestPhaseStep_rad / phaseStep_rad()) + 1e-3f) -
        slack;
    // Pi is no limit.
    const bool isLimited = _options.largestPhaseStep_rad > 0.0 &&
                           _options.largestPhaseStep_rad < (1.0 - 1e-6) * base::kPi && !_isFirst;
    if (isLimited)
    {
        alignToLast();
        keepNear(most);
    }
    for (int k = 0; k < kCorrections; ++k)
    {
        const float level = _search.naturalLevel(_field);
        const float error = quiet().error(_field, level);
        if (!(error > goal)) break;
        const float next = error * quiet().bend(_field, level);
        _step.solve(_field,
                    _field.q,
                    quiet(),
                    _search.weights(_field),
                    static_cast<double>(_tuning.enough * goal),
                    kConjugateSteps);
        for (int block = 0; block < _field.G.blocks(); ++block)
            _step.turn(_field, block, _field.q);
        _search.adjust(_step, 1.0f);
        if (isLimited && keepNear(most)) continue;
        if (next <= goal) break;
        _field.forward(_field.q, _field.p);
        _field.phasesOf(_field.p);
    }
    _search.normalise();
}

// Sets _level to the levels that are played, and q to them if rounding was shaped.
void FieldPath::round()
{
    const int width = _field.G.paddedTransducers();
    if (isShaped())
    {
        for (int block = 0; block < _field.G.blocks(); ++block)
        {
            const int first = _field.G.offset(block);
            float *re = _field.q.re.data() + first, *im = _field.q.im.data() + first;
            kernels::quantisePhase(ShapedRounding::first(_field, block, kShaping),
                                   _field.drive().phaseLevels,
                                   re,
                                   im,
                                   re,
                                   im);
        }
        _field.clearPadding(_field.q);
        _field.forward(_field.q, _field.p);
        _field.phasesOf(_field.p);
        ShapedRounding::Effort effort = kShaping;
        if (quiet().any()) effort.passes *= _tuning.quietPasses;
        _rounding.shape(_field, quiet(), nullptr, _search.naturalLevel(_field), effort);
    }
    kernels::phaseInLevels(width, levels(), _field.q.re.data(), _field.q.im.data(), _level.data());
    for (int i = 0; i < width; ++i)
        _level[static_cast<std::size_t>(i)] = nearest(_level[static_cast<std::size_t>(i)]);
}

void FieldPath::write(std::uint8_t* phases) const
{
    const PropagationMatrix& G = _field.G;
    const bool hasSilent = G.hasSilentLanes();
    if (hasSilent || G.transducers() < G.arraySize()) std::fill_n(phases, G.arraySize(), 0);
    // Copies, since a store of bytes could change the originals.
    const int count = _array.drive.phaseLevels, lanes = G.transducers();
    const int* to = G.order().data();
    const float* levels = _level.data();
    for (int lane = 0; lane < lanes; ++lane)
    {
        if (hasSilent && G.isSilent(lane)) continue;
        // Phases are -count / 2 .. count / 2; without a branch, which no processor foresees.
        const int level = static_cast<int>(levels[lane]);
        phases[to[lane]] =
            static_cast<std::uint8_t>(level + (count & -static_cast<int>(level < 0)));
    }
}

ManyFieldsFigures FieldPath::measure()
{
    kernels::unitAtLevel(_field.G.paddedTransducers(),
                         levels(),
                         _level.data(),
                         _field.q.re.data(),
                         _field.q.im.data());
    _field.clearPadding(_field.q);
    _field.forward(_field.q, _field.p);
    for (int l = 0; l < _field.n(); ++l)
        _field.y[l] = std::abs(_field.p.at(static_cast<std::size_t>(l)));
    float most = 0.0f;
    for (int i = 0; i < _field.m() && !_isFirst; ++i)
    {
        const auto lane = static_cast<std::size_t>(i);
        most = std::max(most, std::fabs(wrapped(_level[lane] - _last[lane])));
    }
    const float s = fittedLevel(_field);
    return {quiet().error(_field, s),
            s * static_cast<float>(_field.unit_Pa()),
            loudnessAt(_field, s),
            most * static_cast<float>(phaseStep_rad())};
}

void FieldPath::solve(const ManyPoints& all,
                      int field,
                      std::uint8_t* phases,
                      ManyFieldsFigures* figures)
{
    assign(all, field);
    _field.start();
    _pace.start(_field, 0.0);
    if (_isFirst)
    {
        startPhases();
        _field.build();
    }
    else
        _search.build(_field);
    checkReach(field);
    _search.search(_field, !_isFirst, kUnlimited, _options.seed, _pace);
    correct();
    round();
    write(phases);
    if (figures != nullptr) *figures = measure();
    std::swap(_level, _last);
    _isFirst = false;
}

} // namespace midair::haptics
