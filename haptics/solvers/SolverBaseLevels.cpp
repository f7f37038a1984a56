// Second part of SolverBase: converts a method's field to the device's levels, keeps targets in Pa
// from being exceeded, and makes the report.

#include "haptics/base/Units.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/solvers/SolverBase.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// SOLVER.md, "From below".
constexpr float kMostOver = 1.1f;     // times the target; above it any quieter field is closer
constexpr double kNearEnough = 0.999; // of the target, at which nothing more is added
constexpr int kLevelPasses = 3;       // passes that adjust the level to the targets
constexpr float kLevelMargin = 1e-4f; // smaller errors are not worth another pass
constexpr float kSameLevel = 0.9999f; // an amplitude on a level is above this share of it

// A field that grows from silence, transducer by transducer.
class FromBelow
{
public:
    // Begins with silence, or with the measured field.
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

    // Adds transducer \a lane with the activation \a q, if that raises the level and keeps it at or
    // below the target.
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

// Replaces field.q, which is playable and too loud, by a drive with fewer transducers, some of them
// at lower levels, that approaches the level \a most. Returns its level; 0: even the quietest
// transducer is too loud. In a fixed order each takes the highest of its levels that fits, so that
// a higher target never gets a lower level: where a transducer first takes more than for the lower
// target, the sum already exceeds that target.
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

// Adds unused transducers to field.q, which is too quiet, each at the highest device level that
// fits, up to \a loudest, and in the best phase for all points. Returns true if any was added;
// field.p and y are not changed.
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

// Smallest pressure, relative to the largest, that 16 bits of G resolve to half a percent.
constexpr float kLeastClear = 0.02f;

// |<q, last>| below which no common phase is chosen (SOLVER.md, "Common phase").
constexpr float kLeastProduct = 1e-6f;

// Appends \a what to the message.
void add(SolveReport& result, const std::string& what)
{
    result.message += (result.message.empty() ? "" : "; ") + what;
}

} // namespace

// Scales field.q to the requested level, as far as the array is loud enough, then clips it and
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
    // Full use: rms |q| = 1 before clipping.
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

// The amplitudes are proportional to those of field.q, or equal with phaseOnly, and rounded in an
// even mix if levels are coarse. Their factor is found iteratively, because phases are rounded and
// amplitudes clipped.
void SolverBase::playTargets()
{
    const int width = _field.G.paddedTransducers();
    const auto m = static_cast<std::size_t>(_field.m());
    std::vector<float> shape(m, 1.0f);
    base::AlignedBuffer<float> amplitudes; // for the kernels
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

// Targets in Pa are not exceeded if a quieter field is closer to them, and every fitting transducer
// is used.
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
    // A reduced loudness is itself a limit.
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

// A common phase of all transducers can't be felt, so it is chosen to minimise the drive's change.
std::complex<float> SolverBase::alignToLast(FieldProblem& field, int levels)
{
    if (!hasLast(field)) return 1.0f;
    const int width = field.G.paddedTransducers();
    const kernels::InnerProduct product = kernels::innerProduct(
        width, field.q.re.data(), field.q.im.data(), _last.lanes.re.data(), _last.lanes.im.data());
    std::complex<float> turn(product.re, product.im);
    if (!(std::abs(turn) > kLeastProduct)) return 1.0f;
    turn /= std::abs(turn);
    if (levels > 0)
    {
        const float step = static_cast<float>(base::kTwoPi) / static_cast<float>(levels);
        turn = std::polar(1.0f, step * std::round(std::arg(turn) / step));
    }
    kernels::scaleBy(width, turn.real(), turn.imag(), field.q.re.data(), field.q.im.data());
    for (int l = 0; l < field.n(); ++l)
    {
        const auto s = static_cast<std::size_t>(l);
        field.u.set(s, field.u.at(s) * turn);
    }
    return turn;
}

// Computes field.y of field.q as played: from G, and from the model itself at points too quiet for
// its 16 bits.
void SolverBase::measure(const Outcome& outcome,
                         const ControlPoints& points,
                         const TransducerArray& array,
                         const Medium& medium)
{
    _field.clearSilent(_field.q); // changes of these don't change the drive
    if (!outcome.measured)
    {
        _field.forward(_field.q, _field.p);
        _field.phasesOf(_field.p);
    }
    if (!_field.G.isFixed()) return;
    const float clear = kLeastClear * _field.y.maxCoeff();
    std::vector<int> quiet;
    for (int l = 0; l < _field.n(); ++l)
        if (_field.y[l] < clear) quiet.push_back(l);
    if (quiet.empty()) return;
    Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(quiet.size()));
    for (Eigen::Index k = 0; k < places.cols(); ++k)
        places.col(k) = points.positions.col(
            _points.active[static_cast<std::size_t>(quiet[static_cast<std::size_t>(k)])]);
    Eigen::VectorXcf q;
    _field.fromLanes(_field.q, q);
    const Eigen::VectorXcf p =
        pressureAt(places, array, medium, q, _options.threads, _options.stop);
    for (Eigen::Index k = 0; k < places.cols(); ++k)
    {
        const int l = quiet[static_cast<std::size_t>(k)];
        const std::complex<double> outside_Pa =
            _field.G.outsideAt_Pa(l, _field.q.re.data(), _field.q.im.data());
        _field.y[l] =
            std::abs(p[k] + std::complex<float>(outside_Pa)) / static_cast<float>(_field.unit_Pa());
    }
}

void SolverBase::report(const Outcome& outcome, SolveReport& result)
{
    const double level = fittedLevelInOrder(_field.y, _field.a);
    const RelativeErrors errors =
        relativeErrors(_field.y, _field.a, _targets.isAbsolute ? largestTarget() : level);
    // A method that ended before rounding its phases does not know the result.
    const bool isRight = errors.rms <= _options.rmsTolerance;
    result.stop =
        outcome.stop == StopReason::CONVERGED && !isRight ? StopReason::STALLED : outcome.stop;
    result.iterations = outcome.iterations;
    errors.tell(result);
    result.level_Pa = level * _field.a.maxCoeff() * _field.unit_Pa();
    result.loudness = loudnessOf(level,
                                 std::sqrt(static_cast<double>(_field.a.squaredNorm())),
                                 static_cast<double>(_field.meanRowSum()));
    result.leftOut = result.points - _field.n();
    if (result.leftOut > 0)
        add(result,
            fmt::format("{} of {} control points left out: target 0 or out of the array's reach",
                        result.leftOut,
                        result.points));
    if (_targets.raised > 0)
        add(result,
            fmt::format("{} of {} targets are below a thousandth of the largest and count as that",
                        _targets.raised,
                        _field.n()));
    if (_targets.isAbsolute && _loudness.wanted > 0.0)
        add(result,
            fmt::format("a loudness of {:g} counts as 1, since the targets are in Pa",
                        1.0 + _loudness.wanted));
    if (_targets.isAbsolute) reportTargets(result);
    if (hasLast(_field)) reportChange(result);
}

// Reports missed targets in Pa.
void SolverBase::reportTargets(SolveReport& result) const
{
    const Shortfall shortfall = shortfallOf(_field.y, _field.a, largestTarget());
    result.shortPoints = shortfall.points;
    result.worstShortfall = shortfall.worst;
    if (result.shortPoints > 0)
        add(result,
            fmt::format("{} of {} control points fall short; the worst, point {}, asks for {:.4g} "
                        "Pa and gets {:.4g} Pa",
                        result.shortPoints,
                        _field.n(),
                        _points.active[static_cast<std::size_t>(shortfall.which)],
                        _targets.largest * _field.a[shortfall.which],
                        _field.unit_Pa() * _field.y[shortfall.which]));
    if (result.level_Pa > (1.0 + kShortBy) * _targets.largest)
        add(result,
            fmt::format("the field is louder than asked for, {:.4g} Pa instead of {:.4g} Pa: the "
                        "next quieter field that was found plays {:.4g} Pa",
                        result.level_Pa,
                        _targets.largest,
                        _field.unit_Pa() * _targets.quieter));
    else if (_targets.isGrown)
        add(result,
            fmt::format("fewer transducers play, or at less, since the array's levels are too "
                        "coarse: {:.4g} Pa of {:.4g} Pa",
                        result.level_Pa,
                        _targets.largest));
}

void SolverBase::reportChange(SolveReport& result) const
{
    const kernels::DriveDifference difference = kernels::compareDrives(_field.G.paddedTransducers(),
                                                                       _field.q.re.data(),
                                                                       _field.q.im.data(),
                                                                       _last.lanes.re.data(),
                                                                       _last.lanes.im.data());
    result.meanPhaseStep_rad = difference.phaseSteps / _field.m();
    result.driveChange = difference.power > 0.0f ? difference.change / difference.power : 0.0;
    result.audibleChange = _audibleShare * result.driveChange;
    if (_last.good && result.level_Pa > 0.0 && _last.report.level_Pa > 0.0)
        result.levelJump = std::max(result.level_Pa / _last.report.level_Pa,
                                    _last.report.level_Pa / result.level_Pa);
}

void SolverBase::keep(const SolveReport& result, Eigen::VectorXcf& q)
{
    _field.fromLanes(_field.q, q);
    const auto padded = static_cast<std::size_t>(_field.G.paddedTransducers());
    _last.lanes.reserve(padded);
    copy(_field.q, _last.lanes, padded);
    _last.q = q;
    _last.active = _points.active;
    _last.identity = _points.identity;
    const auto n = static_cast<std::size_t>(_field.n());
    _last.u.reserve(n);
    copy(_field.u, _last.u, n);
    _last.targets = (_field.a * _targets.largest).cast<double>();
    _last.report = result;
    _last.good = true;
    keepAchieved(result);
}

Eigen::VectorXcf SolverBase::multipliers() const
{
    if (!_last.good || isShifted()) return {};
    const Eigen::VectorXcf own = multipliersOf(_field);
    if (own.size() != static_cast<Eigen::Index>(_last.active.size())) return {};
    Eigen::VectorXcf all = Eigen::VectorXcf::Zero(_last.report.points);
    for (std::size_t l = 0; l < _last.active.size(); ++l)
        all[_last.active[l]] = own[static_cast<Eigen::Index>(l)];
    return all;
}

bool SolverBase::startFrom(const Eigen::VectorXcf& c)
{
    if (!_last.good || isShifted() || c.size() != _last.report.points || !c.allFinite())
        return false;
    Eigen::VectorXcf own(static_cast<Eigen::Index>(_last.active.size()));
    for (std::size_t l = 0; l < _last.active.size(); ++l)
        own[static_cast<Eigen::Index>(l)] = c[_last.active[l]];
    if (!take(_field, own)) return false;
    _last.goesOn = true;
    return true;
}

// Kept rows belong to earlier positions, and quick ones aren't exact enough.
void SolverBase::keepAchieved(const SolveReport& result)
{
    if (!isCoarseTolerance(_options.rmsTolerance) && _field.n() == result.points &&
        result.rowsBuilt >= result.points)
        _last.achieved_Pa = static_cast<float>(_field.unit_Pa()) * _field.y;
}

} // namespace midair::haptics
