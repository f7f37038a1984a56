// Second part of SolverBase: rounds a method's field to the device's levels and makes its report.
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

// Least pressure, relative to the largest, that 16 bits of G give to half a percent.
constexpr float kLeastClear = 0.02f;

// |<q, last>| below which no common phase is chosen (SOLVER.md, "Common phase").
constexpr float kLeastProduct = 1e-6f;

// Adds \a what to the message, after what it says already.
void add(SolveReport& result, const std::string& what)
{
    result.message += (result.message.empty() ? "" : "; ") + what;
}

} // namespace

// A common phase of all transducers can't be felt, so it is chosen such that the drive changes
// least.
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

// Finds field.y of field.q as it is played: from G, and at points that are too quiet for its 16
// bits from the model itself.
void SolverBase::measure(const Outcome& outcome,
                         const ControlPoints& points,
                         const TransducerArray& array,
                         const Medium& medium)
{
    _field.clearSilent(_field.q); // no change of these is one of the drive
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
        _field.y[quiet[static_cast<std::size_t>(k)]] =
            std::abs(p[k]) / static_cast<float>(_field.unit_Pa());
}

void SolverBase::report(const Outcome& outcome, SolveReport& result)
{
    const double level = fittedLevelInOrder(_field.y, _field.a);
    const RelativeErrors errors =
        relativeErrors(_field.y, _field.a, _targets.isAbsolute ? largestTarget() : level);
    // A method that ended before its phases were rounded does not know what is played of them.
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

// Targets in Pa that are missed.
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
    std::copy_n(_field.q.re.data(), padded, _last.lanes.re.data());
    std::copy_n(_field.q.im.data(), padded, _last.lanes.im.data());
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

// Rows that were kept are of where points were.
void SolverBase::keepAchieved(const SolveReport& result)
{
    if (_field.n() == result.points && result.rowsBuilt >= result.points)
        _last.achieved_Pa = static_cast<float>(_field.unit_Pa()) * _field.y;
}

} // namespace midair::haptics
