#include "haptics/sequence/FieldSequence.h"

#include "haptics/base/DutyLaw.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/Exposure.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/RingingMean.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/sequence/FieldOrder.h"
#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>

namespace midair::haptics
{

bool keepAmplitudes(double cap, std::vector<Eigen::VectorXcf>& fields)
{
    if (cap >= 1.0) return false;
    const double most = base::dutyAmplitude(std::floor(base::dutyLevel(cap) + 1e-9));
    float largest = 0.0F;
    for (const Eigen::VectorXcf& q : fields)
        if (q.size() > 0) largest = std::max(largest, q.cwiseAbs().maxCoeff());
    if (!(largest > most)) return false;
    for (Eigen::VectorXcf& q : fields)
        q *= static_cast<float>(most / static_cast<double>(largest));
    return true;
}

Eigen::VectorXcd OutsideField::at(const Eigen::VectorXcf& q) const
{
    const double power = drive.squaredNorm();
    if (q.size() != drive.size() || !(power > 0.0))
        return Eigen::VectorXcd::Zero(pressure_Pa.size());
    return pressure_Pa * (std::complex<double>(drive.dot(q)) / power);
}

ControlPoints FieldSequence::points() const
{
    ControlPoints all;
    for (const ControlPoints& part : parts)
    {
        if (part.size() == 0) continue;
        if (all.size() == 0)
            all = part;
        else
            append(all, part);
    }
    return all;
}

Eigen::VectorXf achievedPressure(const FieldSequence& sequence,
                                 const TransducerArray& array,
                                 const Medium& medium,
                                 int threads,
                                 const base::StopToken& stop)
{
    if (sequence.evened && !sequence.isEmpty())
        return meanSquarePressure(
                   sequence.points().positions, array, medium, sequence.fields, threads, stop)
            .cwiseSqrt()
            .cast<float>();
    Eigen::VectorXf achieved_Pa;
    for (std::size_t k = 0; k < std::min(sequence.parts.size(), sequence.fields.size()); ++k)
    {
        const Eigen::Matrix3Xd& positions = sequence.parts[k].positions;
        if (positions.cols() == 0) continue;
        const Eigen::Index n = achieved_Pa.size();
        achieved_Pa.conservativeResize(n + positions.cols());
        Eigen::VectorXcf p =
            pressureAt(positions, array, medium, sequence.fields[k], threads, stop);
        if (sequence.outside && sequence.outside->pressure_Pa.size() == p.size())
            p += sequence.outside->at(sequence.fields[k]).cast<std::complex<float>>();
        achieved_Pa.tail(positions.cols()) = p.cwiseAbs();
    }
    return achieved_Pa;
}

namespace
{

void fillIn(const CycleSteps& steps, double rate_Hz, SolveReport& report)
{
    report.meanPhaseStep_rad = steps.meanPhaseStep_rad;
    report.driveChange = steps.driveChange;
    report.audibleChange = steps.driveChange * audibleShare(rate_Hz);
}

// Maximum number of steps for computations over all transducers per step.
constexpr int kMostSteps = 512;

// Returns the pattern of \a fields, or as many whole periods of the modulation as fit.
std::vector<PatternStep> patternFor(const Modulator& modulator, int fields)
{
    std::vector<PatternStep> steps = modulator.pattern(fields, kMostSteps);
    if (!steps.empty()) return steps;
    const double period =
        modulator.options().amplitudeRate_Hz > 0.0
            ? modulator.options().fieldRate_Hz / modulator.options().amplitudeRate_Hz
            : fields;
    const double periods = std::max(1.0, std::floor(kMostSteps / period));
    return modulator.steps(
        0, static_cast<std::int64_t>(std::max(1.0, std::round(periods * period))), fields);
}

ModulatorOptions withoutAmplitude(ModulatorOptions options)
{
    options.amplitudeRate_Hz = 0.0;
    return options;
}

double shareOf(double part, double whole)
{
    return whole > 0.0 ? std::clamp(part / whole, 0.0, 1.0) : 1.0;
}

std::size_t paddedSize(const Eigen::VectorXcf& q)
{
    constexpr std::size_t kLanes = kernels::kLanes;
    return (static_cast<std::size_t>(q.size()) + kLanes - 1) / kLanes * kLanes;
}

// As the kernels need it.
SplitVector inLanes(const Eigen::VectorXcf& q)
{
    SplitVector lanes;
    lanes.reserve(paddedSize(q));
    for (Eigen::Index i = 0; i < q.size(); ++i)
        lanes.set(static_cast<std::size_t>(i), q[i]);
    return lanes;
}

} // namespace

void rateSteps(FieldSequence& sequence)
{
    const CycleSteps steps =
        sequence.fields.size() > 1 ? cycleSteps(sequence.fields) : CycleSteps();
    fillIn(steps, sequence.modulation.fieldRate_Hz, sequence.report);
}

void rateRinging(FieldSequence& sequence, double ringing_s)
{
    SolveReport& report = sequence.report;
    report.ringingShare = report.ringingModulation = 1.0;
    if (!sequence.changes() || sequence.isEmpty() || ringing_s == 0.0) return;
    const Modulator modulator(sequence.modulation);
    const double step_s = 1.0 / sequence.modulation.fieldRate_Hz;
    if (sequence.modulation.amplitudeRate_Hz > 0.0)
    {
        // All transducers follow it alike, so one represents all.
        const RadiatedPower one = radiatedPower({Eigen::VectorXcf::Ones(1)},
                                                patternFor(modulator, 1),
                                                step_s,
                                                ringing_s,
                                                sequence.modulation.amplitudeRate_Hz);
        report.ringingModulation = shareOf(one.ringing_swing, one.steady_swing);
        report.ringingShare = shareOf(one.ringing_mean, one.steady_mean);
    }
    if (sequence.isHeld()) return;
    // A modulation slower than these steps loses no power to ringing.
    const int fields = static_cast<int>(sequence.fields.size());
    std::vector<PatternStep> steps = patternFor(modulator, fields);
    if (steps.size() > kMostSteps)
        steps = Modulator(withoutAmplitude(sequence.modulation)).steps(0, fields, fields);
    const RadiatedPower power = radiatedPower(sequence.fields, steps, step_s, ringing_s);
    report.ringingShare = shareOf(power.ringing_mean, power.steady_mean);
}

// With a(t) = q + d e^{-t/tau}, d = last - q, the mean of |a|^2 over T is
//     |q|^2 + 2 Re<q, d> (tau/T)(1 - x) + |d|^2 (tau/2T)(1 - x^2),   x = e^{-T/tau}.
void rateSwitch(const Eigen::VectorXcf& last,
                double rate_Hz,
                double ringing_s,
                FieldSequence& sequence)
{
    if (!sequence.isHeld() || sequence.fields.front().size() != last.size()) return;
    const Eigen::VectorXcf& q = sequence.fields.front();
    const double power = q.squaredNorm();
    if (!(power > 0.0) || !(last.squaredNorm() > 0.0f) || !(ringing_s > 0.0)) return;
    const Eigen::VectorXcf d = last - q;
    const double x = std::exp(-1.0 / (rate_Hz * ringing_s));
    const double once = ringing_s * rate_Hz * (1.0 - x);
    const double ringing = power + 2.0 * once * static_cast<double>(std::real(q.dot(d))) +
                           0.5 * once * (1.0 + x) * static_cast<double>(d.squaredNorm());
    sequence.report.ringingShare *= shareOf(ringing, power);
}

void continueFrom(const Eigen::VectorXcf& last,
                  double rate_Hz,
                  const DriveResolution& drive,
                  FieldSequence& sequence)
{
    if (!sequence.isHeld() || sequence.fields.front().size() != last.size()) return;
    alignField(sequence.fields.front(), last, drive);
    sequence.achieved_Pa.resize(0);
    rateStep(last, rate_Hz, sequence);
}

void rateStep(const Eigen::VectorXcf& last, double rate_Hz, FieldSequence& sequence)
{
    if (!sequence.isHeld() || sequence.fields.front().size() != last.size()) return;
    const SplitVector before = inLanes(last), now = inLanes(sequence.fields.front());
    const kernels::DriveDifference difference =
        kernels::compareDrives(static_cast<int>(paddedSize(last)),
                               now.re.data(),
                               now.im.data(),
                               before.re.data(),
                               before.im.data());
    CycleSteps step;
    step.meanPhaseStep_rad =
        static_cast<double>(difference.phaseSteps) / static_cast<double>(last.size());
    // In a cycle the change is relative to both fields, because each follows the other.
    const Eigen::VectorXcf& field = sequence.fields.front();
    const float power = field.squaredNorm();
    step.driveChange = power > 0.0f ? (field - last).squaredNorm() / power : 0.0;
    fillIn(step, rate_Hz, sequence.report);
}

void rateLevel(const ControlPoints& points,
               const Eigen::VectorXf& achieved_Pa,
               SolveReport& report,
               double least_Pa)
{
    Eigen::VectorXd y = achieved_Pa.cast<double>(), a = points.targets;
    Eigen::Index wanted = 0; // points whose target is not 0
    for (Eigen::Index l = 0; l < a.size(); ++l)
    {
        if (!(a[l] > 0.0)) continue;
        y[wanted] = y[l];
        a[wanted++] = a[l];
    }
    y.conservativeResize(wanted);
    a.conservativeResize(wanted);
    if (wanted == 0)
    {
        // No points, or all targets are 0: no errors.
        RelativeErrors().tell(report);
        report.loudness = report.level_Pa = report.worstShortfall = 0.0;
        report.shortPoints = 0;
        return;
    }
    raiseTargets(a);
    const double s = fittedLevel(y, a);
    const double level_Pa = s * a.maxCoeff();
    if (report.level_Pa > 0.0) report.loudness *= level_Pa / report.level_Pa;
    report.level_Pa = level_Pa;
    // Silence has no fitted level. Every point misses its whole target, as for targets in Pa.
    RelativeErrors errors{1.0, 1.0, std::sqrt(a.squaredNorm() / wanted) / a.maxCoeff(), 1.0};
    if (s > 0.0)
        errors = points.absolute ? relativeErrors(y, a, 1.0, least_Pa) : relativeErrors(y, a, s);
    errors.tell(report);
    if (!points.absolute) return;
    const Shortfall shortfall = shortfallOf(y, a, 1.0);
    report.shortPoints = shortfall.points;
    report.worstShortfall = shortfall.worst;
}

} // namespace midair::haptics
