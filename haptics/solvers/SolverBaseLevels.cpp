// Fourth part of SolverBase: brings a method's field to the device's levels, targets in Pa no
// louder than they are.
#include "haptics/solvers/FieldFigures.h"
#include "haptics/solvers/SolverBase.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

// SOLVER.md, "From below".
constexpr float kMostOver = 1.1f;     // times the target; above it any quieter field is nearer
constexpr double kNearEnough = 0.999; // of the target, where nothing more is added
constexpr int kLevelPasses = 3;       // that bring the level to the targets
constexpr float kLevelMargin = 1e-4f; // less than that is no other pass worth
constexpr float kSameLevel = 0.9999f; // an amplitude that is on a level is above this much of it

// A field that grows from silence, transducer by transducer.
class FromBelow
{
public:
    // Begins with silence, or on top of the field that is measured.
    FromBelow(const FieldProblem& field, double most, bool onTop = false) :
        _field(field),
        _most(most),
        _squares(static_cast<double>(field.a.squaredNorm())),
        _p(Eigen::VectorXcd::Zero(field.n()))
    {
        if (!onTop) return;
        _level = static_cast<double>(fittedLevel(field));
        for (int l = 0; l < field.n(); ++l)
            _p[l] = field.p.at(static_cast<std::size_t>(l));
    }

    double level() const { return _level; }
    bool isThere() const { return _level >= kNearEnough * _most; }

    // Adds transducer \a lane with the activation \a q, if the level rises by it and stays at most
    // what is wanted.
    bool add(int lane, std::complex<float> q)
    {
        const std::complex<double> drive(q);
        double along = 0.0;
        for (int l = 0; l < _field.n(); ++l)
            along += static_cast<double>(_field.a[l]) *
                     std::abs(_p[l] + std::complex<double>(_field.G.at(l, lane)) * drive);
        const double level = along / _squares;
        if (!(level > _level) || level > _most) return false;
        for (int l = 0; l < _field.n(); ++l)
            _p[l] += std::complex<double>(_field.G.at(l, lane)) * drive;
        _level = level;
        return true;
    }

private:
    const FieldProblem& _field;
    double _most;
    double _squares;
    double _level = 0.0;
    Eigen::VectorXcd _p; // n
};

// Replaces field.q, which is playable and too loud, by the drive of some of its transducers, some
// of them at lower levels, that comes up to the level \a most. Returns its level; 0: the quietest
// transducer is too loud. In a fixed order, each takes the highest of its levels that fits, so that
// a higher target never gets a lower level: where a transducer first takes more than for the lower
// target, the sum is above that target already.
float growFromBelow(FieldProblem& field, float most)
{
    const std::vector<float>& levels = field.drive().amplitudeLevels;
    FromBelow grown(field, static_cast<double>(most));
    for (const int lane : evenOrder(field.m()))
    {
        const auto at = static_cast<std::size_t>(lane);
        const std::complex<float> wanted = field.q.at(at);
        const float amplitude = std::abs(wanted);
        field.q.set(at, 0.0f);
        if (!(amplitude > 0.0f) || grown.isThere()) continue;
        auto above = std::lower_bound(levels.begin(), levels.end(), kSameLevel * amplitude);
        std::complex<float> q = wanted;
        while (!grown.add(lane, q))
        {
            q = above == levels.begin() ? 0.0f : *--above * (wanted / amplitude);
            if (q == 0.0f) break;
        }
        field.q.set(at, q);
    }
    return static_cast<float>(grown.level());
}

// Adds transducers that are off to field.q, which is too quiet, each at the highest of the device's
// levels that fits, up to \a loudest, and in the phase that is best for all points. Returns true if
// there is one; field.p and y are not changed.
bool fillFromBelow(FieldProblem& field, float most, float loudest)
{
    std::vector<int> off;
    for (const int lane : evenOrder(field.m()))
        if (field.q.at(static_cast<std::size_t>(lane)) == 0.0f && !field.G.isSilent(lane))
            off.push_back(lane);
    if (off.empty()) return false;
    for (int l = 0; l < field.n(); ++l)
        field.w.set(static_cast<std::size_t>(l),
                    field.a[l] * field.u.at(static_cast<std::size_t>(l)));
    field.backward(field.w, field.z);
    field.quantisePhases(field.z, field.z);
    const std::vector<float>& levels = field.drive().amplitudeLevels;
    FromBelow grown(field, static_cast<double>(most), true);
    bool isAny = false;
    for (const int lane : off)
    {
        if (grown.isThere()) break;
        const auto at = static_cast<std::size_t>(lane);
        for (auto above = std::upper_bound(levels.begin(), levels.end(), loudest);
             above != levels.begin() && *(above - 1) > 0.0f;)
        {
            const std::complex<float> q = *--above * field.z.at(at);
            if (!grown.add(lane, q)) continue;
            field.q.set(at, q);
            isAny = true;
            break;
        }
    }
    return isAny;
}

} // namespace

// Scales field.q to the level asked for, as far as the array is loud enough, then clips it and
// rounds it to the device's levels.
void SolverBase::makePlayable()
{
    alignToLast(_field);
    if (_targets.isAbsolute) return playTargets();
    const int width = _field.G.paddedTransducers();
    if (_options.phaseOnly)
    {
        const float amplitude = playableAmplitude(_field.drive().amplitudeLevels,
                                                  static_cast<float>(_options.loudness));
        _field.quantisePhases(_field.q, _field.q);
        kernels::scaleBy(width, amplitude, 0.0f, _field.q.re.data(), _field.q.im.data());
        return;
    }
    double power = 0.0;
    for (int i = 0; i < _field.m(); ++i)
        power += std::norm(_field.q.at(static_cast<std::size_t>(i)));
    // To full use: rms |q| = 1 before clipping.
    const double full = power > 0.0 ? std::sqrt(_field.m() / power) : 0.0;
    const auto scale = static_cast<float>(full * _options.loudness);
    for (int i = 0; i < _field.m(); ++i)
    {
        const auto s = static_cast<std::size_t>(i);
        const float amplitude = std::abs(_field.q.at(s));
        _field.q.set(s, _field.q.at(s) * (amplitude * scale > 1.0f ? 1.0f / amplitude : scale));
    }
    _field.quantise(1.0f);
}

// The amplitudes are in proportion to those of field.q, or with phaseOnly all alike, and rounded in
// an even mix where levels are coarse. Their factor is found by repeating, since phases are rounded
// and amplitudes clipped.
void SolverBase::playTargets()
{
    const int width = _field.G.paddedTransducers();
    const auto m = static_cast<std::size_t>(_field.m());
    std::vector<float> shape(m, 1.0f);
    base::AlignedBuffer<float> amplitudes; // as the kernels need it
    amplitudes.reserve(static_cast<std::size_t>(width));
    std::fill_n(amplitudes.data(), width, 0.0f);
    double power = 0.0;
    for (std::size_t i = 0; i < m && !_options.phaseOnly; ++i)
    {
        shape[i] = std::abs(_field.q.at(i));
        power += static_cast<double>(shape[i]) * static_cast<double>(shape[i]);
    }
    const double rms = _options.phaseOnly ? 1.0 : std::sqrt(power / static_cast<double>(m));
    const auto most = static_cast<float>(rms > 0.0 ? _options.loudness / rms : 0.0);
    _field.quantisePhases(_field.q, _field.z);
    const auto playAt = [&](float gain)
    {
        for (std::size_t i = 0; i < m; ++i)
            amplitudes[i] = std::min(gain * shape[i], 1.0f);
        if (_options.phaseOnly)
            mixAmplitudes(_field.drive().amplitudeLevels, gain, _field.m(), amplitudes.data());
        else
            roundAmplitudes(
                _field.drive().amplitudeLevels, _field.m(), amplitudes.data(), kCoarseTarget);
        copy(_field.z, _field.q, static_cast<std::size_t>(width));
        kernels::scaleBy(width, amplitudes.data(), _field.q.re.data(), _field.q.im.data());
        _field.forward(_field.q, _field.p);
        _field.phasesOf(_field.p);
        return fittedLevel(_field);
    };
    float gain = most;
    float level = playAt(gain);
    for (int pass = 0; pass < kLevelPasses && level > 0.0f; ++pass)
    {
        const float ratio = largestTarget() / level;
        if (std::fabs(ratio - 1.0f) < kLevelMargin || (ratio > 1.0f && gain == most)) break;
        gain = std::min(gain * ratio, most);
        level = playAt(gain);
    }
}

// Targets in Pa are not exceeded where something quieter is nearer to them, and nothing that still
// fits is left off.
void SolverBase::keepToTargets(Outcome& outcome)
{
    _targets.isGrown = false;
    if (!_targets.isAbsolute) return;
    const auto measure = [this]
    {
        _field.forward(_field.q, _field.p);
        _field.phasesOf(_field.p);
    };
    if (!outcome.measured) measure();
    outcome.measured = true;
    const float wanted = largestTarget(), level = fittedLevel(_field);
    const auto margin = static_cast<float>(kShortBy);
    // A share of the loudness is a limit of its own.
    if (level < (1.0f - margin) * wanted && _options.loudness >= 1.0)
    {
        const std::vector<float>& levels = _field.drive().amplitudeLevels;
        const auto lowest = std::upper_bound(levels.begin(), levels.end(), 0.0f);
        float loudest = lowest == levels.end() ? 0.0f : *lowest;
        for (std::size_t i = 0; i < static_cast<std::size_t>(_field.m()); ++i)
            loudest = std::max(loudest, std::abs(_field.q.at(i)));
        if (fillFromBelow(_field, wanted, loudest / kSameLevel)) measure();
        return;
    }
    if (!(level > (1.0f + margin) * wanted)) return;
    const auto width = static_cast<std::size_t>(_field.G.paddedTransducers());
    copy(_field.q, _field.z, width);
    _targets.quieter = growFromBelow(_field, wanted);
    _targets.isGrown = level > kMostOver * wanted || wanted - _targets.quieter < level - wanted;
    if (!_targets.isGrown) return copy(_field.z, _field.q, width);
    measure();
    if (outcome.stop == StopReason::CONVERGED) outcome.stop = StopReason::STALLED;
}

} // namespace midair::haptics
