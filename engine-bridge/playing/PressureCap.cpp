#include "engine-bridge/playing/PressureCap.h"

#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/playing/FieldBounds.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/sequence/FieldOrder.h"
#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr int kMostSteps = 24;
constexpr double kHeadroom = 0.999; // makes one step enough if the levels are fine
// Just above the amplitude of a level, which rounding down then gives.
constexpr double kAboveLevel = 1.0001;
constexpr double kOneAmplitude = 0.999; // amplitudes above this share of the largest are the same
constexpr double kThinned = 0.999;      // most that a field with fewer transducers is called

// True if all sounding transducers have the same amplitude: a lower gain then makes the same field,
// only quieter.
bool isEven(const device::DriveSignal& signal)
{
    std::uint8_t one = 0;
    for (const std::uint8_t duty : signal.duty)
    {
        if (duty == 0) continue;
        if (one != 0 && duty != one) return false;
        one = duty;
    }
    return true;
}

// Largest change of an amplitude when it is rounded down to a duty level and then, by the device,
// to one of its amplitudes.
float coarsestStep(const std::vector<float>& amplitudes)
{
    constexpr auto kDutyStep = static_cast<float>(base::kPi / base::kDutyPeriod); // sin's steepest
    float step = 0.0f;
    for (std::size_t i = 1; i < amplitudes.size(); ++i)
        step = std::max(step, amplitudes[i] - amplitudes[i - 1]);
    return amplitudes.empty() ? kDutyStep : kDutyStep + 2.0f * step;
}

Eigen::VectorXcf decoded(const device::DriveSignal& signal)
{
    std::vector<std::complex<float>> q;
    device::decode(signal, q);
    return Eigen::Map<const Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size()));
}

double largest(const std::vector<Eigen::VectorXcf>& fields)
{
    float most = 0.0f;
    for (const Eigen::VectorXcf& q : fields)
        if (q.size() > 0) most = std::max(most, q.cwiseAbs().maxCoeff());
    return static_cast<double>(most);
}

std::vector<Eigen::VectorXcf>
scaled(const CappedPlaces& where, std::vector<Eigen::VectorXcf> fields, double factor)
{
    for (Eigen::VectorXcf& q : fields)
        haptics::scaleField(q, static_cast<float>(factor), where.arrays.front()->drive);
    return fields;
}

// Encodes as for sending: the array's dead transducers are off, whatever the field says.
bool encodeFor(const CappedPlaces& where, const Eigen::VectorXcf& q, device::DriveSignal& signal)
{
    if (!device::encode(q.data(), static_cast<int>(q.size()), signal)) return false;
    for (const int i : where.arrays.front()->dead)
        if (i < signal.size()) signal.duty[static_cast<std::size_t>(i)] = 0;
    return true;
}

std::vector<device::DriveSignal> signalsOf(const CappedPlaces& where,
                                           const std::vector<Eigen::VectorXcf>& fields)
{
    std::vector<device::DriveSignal> signals(fields.size());
    for (std::size_t k = 0; k < fields.size(); ++k)
        if (!encodeFor(where, fields[k], signals[k]))
            throw base::InputError("field in turn has an activation that is not finite");
    return signals;
}

// Transducers that were turned off get phase 0, like in silence: the checked bytes are exactly
// those that are sent, also for transducers that don't sound.
void restPhases(device::DriveSignal& signal)
{
    for (std::size_t i = 0; i < signal.duty.size(); ++i)
        if (signal.duty[i] == 0) signal.phase[i] = 0;
}

double power(const std::vector<Eigen::VectorXcf>& fields)
{
    double sum = 0.0;
    for (const Eigen::VectorXcf& q : fields)
        sum += static_cast<double>(q.squaredNorm());
    return sum;
}

// Rounds up to three digits: a cap named in a message must be high enough.
double upwards(double value)
{
    if (!(value > 0.0) || !std::isfinite(value)) return value;
    const double digit = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
    return std::ceil(value / digit) * digit;
}

// Keeps the first sounding transducer, in the order of thinning out.
void keepFirst(device::DriveSignal& signal)
{
    bool isKept = false;
    for (const int i : haptics::evenOrder(signal.size()))
    {
        std::uint8_t& duty = signal.duty[static_cast<std::size_t>(i)];
        if (isKept) duty = 0;
        isKept = isKept || duty > 0;
    }
}

// Rounds up to a tenth, for the same reason.
double upwards_dB(double level_dB)
{
    return std::ceil(10.0 * level_dB) / 10.0;
}

// Keeps the first transducers of \a order.
device::DriveSignal
firstOf(const device::DriveSignal& all, const std::vector<int>& order, std::size_t count)
{
    device::DriveSignal some = all;
    for (std::size_t k = count; k < order.size(); ++k)
        some.duty[static_cast<std::size_t>(order[k])] = 0;
    restPhases(some);
    return some;
}

// One field, or several whose sounding transducers all have the same amplitude, so that the lowest
// level keeps their ratios.
bool mayThinOut(const std::vector<Eigen::VectorXcf>& fields)
{
    if (fields.size() == 1) return true;
    const double most = largest(fields);
    for (const Eigen::VectorXcf& q : fields)
        for (const std::complex<float>& one : q)
            if (one != 0.0f && std::abs(one) < kOneAmplitude * most) return false;
    return true;
}

void setToLowest(int duty, device::DriveSignal& signal)
{
    for (std::uint8_t& level : signal.duty)
        level = level > 0 ? static_cast<std::uint8_t>(duty) : level;
}

} // namespace

PressureCap::PressureCap(double max_Pa, Play play, device::DriveAbility ability) :
    _max_Pa(max_Pa),
    _play(std::move(play)),
    _ability(std::move(ability)),
    _coarsest(coarsestStep(_ability.amplitudes))
{
    if (!(max_Pa > 0.0 && max_Pa <= base::kMostPressure_Pa))
        throw base::InputError(
            fmt::format("the pressure cap is {:g} Pa, should be over 0 and at most 1e6", max_Pa));
}

// Without \a ears, most_Pa includes the level at ears, scaled so that one factor keeps both cap and
// ear limit.
std::vector<CappedField> PressureCap::playedOf(const FieldBounds& bounds,
                                               const std::vector<device::DriveSignal>& signals,
                                               std::vector<double>& most_Pa,
                                               std::vector<double>* ears) const
{
    std::vector<Eigen::VectorXcf> played;
    std::vector<float> rounding;
    for (const device::DriveSignal& signal : signals)
    {
        played.push_back(_play(signal));
        rounding.push_back(bounds.isLowered() && !isEven(signal) ? _coarsest : 0.0f);
    }
    Eigen::MatrixXf achieved_Pa;
    most_Pa = bounds.of(played, rounding, achieved_Pa, ears ? -1.0 : _max_Pa);
    std::vector<CappedField> fields(signals.size());
    for (std::size_t k = 0; k < fields.size(); ++k)
    {
        fields[k].played = std::move(played[k]);
        fields[k].achieved_Pa = achieved_Pa.col(static_cast<Eigen::Index>(k));
    }
    if (ears) ears->assign(fields.size(), 0.0);
    if (!bounds.where().ears) return fields;
    for (std::size_t k = 0; k < fields.size(); ++k)
    {
        const double excess = bounds.where().ears->excess(fields[k].played, rounding[k], _ability);
        if (ears)
            (*ears)[k] = excess;
        else if (!(_max_Pa * excess <= most_Pa[k])) // also for NaN
            most_Pa[k] = _max_Pa * excess;
    }
    return fields;
}

CappedField
PressureCap::hold(const Where& where, device::DriveSignal& signal, CappedField known) const
{
    const FieldBounds bounds(where, _ability, std::move(known));
    const device::DriveSignal wanted = signal;
    std::vector<double> most_Pa;
    double factor = 1.0;
    for (int step = 0; step < kMostSteps && factor > 0.0; ++step)
    {
        CappedField field = std::move(playedOf(bounds, {signal}, most_Pa).front());
        if (step > 0 && field.played.isZero(0.0f)) break;
        field.factor = factor;
        if (most_Pa.front() <= _max_Pa) return field;
        // With coarse levels a step may change nothing, so each next step is larger.
        factor *= kHeadroom * std::min(_max_Pa / most_Pa.front(), std::pow(0.8, step));
        if (!std::isfinite(factor)) break;
        device::scaleDuties(wanted, factor, signal);
        restPhases(signal);
    }
    std::vector<CappedField> fields(1);
    std::vector<device::DriveSignal> signals = {wanted};
    const double share = thinOut(bounds, signals, fields);
    signal = std::move(signals.front());
    if (share > 0.0)
    {
        fields.front().factor = std::min(share, kThinned);
        return std::move(fields.front());
    }
    CappedField field;
    field.factor = 0.0;
    field.played.setZero(signal.size());
    field.achieved_Pa.setZero(where.points.cols());
    return field;
}

// If even the lowest level exceeds the cap, fewer transducers may keep it: as many as possible, in
// an evenly mixed order, the same for each field. Returns the factor on the sum of amplitudes; 0:
// even a single transducer is too loud, and all \a signals are silence.
double PressureCap::thinOut(const FieldBounds& bounds,
                            std::vector<device::DriveSignal>& signals,
                            std::vector<CappedField>& fields) const
{
    const int transducers = signals.front().size();
    const int duty = lowestDuty(transducers);
    const std::vector<device::DriveSignal> wanted = signals;
    for (device::DriveSignal& signal : signals)
        setToLowest(duty, signal);
    const std::vector<device::DriveSignal> all = signals;
    const std::vector<int> order = haptics::evenOrder(transducers);
    for (device::DriveSignal& signal : signals)
        std::fill(signal.duty.begin(), signal.duty.end(), std::uint8_t(0));
    if (duty == 0) return 0.0;
    double before = 0.0, after = 0.0;
    std::size_t fits = 0, tooMany = order.size() + 1;
    for (std::size_t count = order.size(); fits + 1 < tooMany; count = (fits + tooMany) / 2)
    {
        std::vector<device::DriveSignal> some;
        some.reserve(all.size());
        for (const device::DriveSignal& signal : all)
            some.push_back(firstOf(signal, order, count));
        std::vector<double> most_Pa;
        std::vector<CappedField> played = playedOf(bounds, some, most_Pa);
        const bool isOver = !std::all_of(
            most_Pa.begin(), most_Pa.end(), [this](double one_Pa) { return one_Pa <= _max_Pa; });
        (isOver ? tooMany : fits) = count;
        if (isOver) continue;
        signals = std::move(some);
        fields = std::move(played);
    }
    for (std::size_t k = 0; k < fields.size() && fits > 0; ++k)
    {
        before += static_cast<double>(_play(wanted[k]).cwiseAbs().sum());
        after += static_cast<double>(fields[k].played.cwiseAbs().sum());
    }
    return before > 0.0 ? after / before : 0.0;
}

double PressureCap::holdAll(const Where& where,
                            std::vector<Eigen::VectorXcf>& fields,
                            std::vector<device::DriveSignal>* drives) const
{
    const std::vector<Eigen::VectorXcf> wanted = fields;
    std::vector<device::DriveSignal> signals; // of the last step
    const FieldBounds bounds(where, _ability);
    bool sounds = false; // whether the fields sounded at the last step
    // The factor that brings the loudest field down to the cap, as estimated from one step; 1: all
    // keep the cap.
    const auto nextFactor = [&]
    {
        double least = 1.0;
        sounds = false;
        std::vector<double> most_Pa;
        signals = signalsOf(where, fields);
        for (const CappedField& field : playedOf(bounds, signals, most_Pa))
            sounds = sounds || !field.played.isZero(0.0f);
        for (const double one_Pa : most_Pa)
        {
            if (one_Pa <= _max_Pa) continue;
            const double factor = kHeadroom * _max_Pa / one_Pa;
            least = std::isfinite(factor) ? std::min(least, factor) : 0.0;
        }
        return least;
    };
    const auto kept = [&](double factor)
    {
        if (drives) *drives = std::move(signals);
        return factor;
    };
    double whole = 1.0;
    for (int step = 0; step < kMostSteps && whole > 0.0; ++step)
    {
        const double factor = nextFactor();
        if (factor >= 1.0 && (step == 0 || sounds)) return kept(whole);
        if (factor >= 1.0) break; // past the lowest level
        // Steps grow, because rounding may raise the pressure again.
        whole *= factor * (1.0 - std::ldexp(1.0 - kHeadroom, std::min(step, 9)));
        fields = scaled(where, wanted, whole);
    }
    // The steps may have skipped the lowest level, which may keep the cap.
    const double lowestShare = kAboveLevel * lowest(where, wanted).amplitude / largest(wanted);
    if (lowestShare > 0.0 && lowestShare < 1.0)
    {
        fields = scaled(where, wanted, lowestShare);
        if (nextFactor() >= 1.0 && sounds) return kept(lowestShare);
    }
    if (mayThinOut(wanted))
    {
        signals = signalsOf(where, wanted);
        std::vector<CappedField> thinned(wanted.size());
        const double share = thinOut(bounds, signals, thinned);
        for (std::size_t k = 0; k < fields.size() && share > 0.0; ++k)
            fields[k] = decoded(signals[k]);
        if (share > 0.0) return kept(std::min(share, kThinned));
    }
    for (Eigen::VectorXcf& q : fields)
        q.setZero();
    signals = signalsOf(where, fields);
    return kept(0.0);
}

// Amplitudes are rounded to levels, so the played factor differs from the requested one.
double
PressureCap::hold(const Where& where, haptics::FieldSequence& sequence, CappedDrives* capped) const
{
    const double before = power(sequence.fields);
    CappedDrives made;
    double factor = 1.0;
    if (sequence.isHeld())
    {
        Eigen::VectorXcf& q = sequence.fields.front();
        device::DriveSignal& signal = made.drives.emplace_back();
        if (!encodeFor(where, q, signal))
            throw base::InputError(
                "solver gave activations that are not finite; nothing is played");
        made.held = hold(where, signal, {1.0, q, sequence.achieved_Pa});
        factor = made.held.factor;
        if (factor < 1.0) q = decoded(signal);
    }
    else
        factor = holdAll(where, sequence.fields, &made.drives);
    if (factor < 1.0) sequence.achieved_Pa.resize(0);
    if (capped) *capped = std::move(made);
    if (factor >= 1.0 || factor <= 0.0 || before <= 0.0) return factor;
    return std::min(1.0, std::sqrt(power(sequence.fields) / before));
}

bool PressureCap::isForEars(const Where& where, const std::vector<Eigen::VectorXcf>& fields) const
{
    if (!where.ears) return false;
    std::vector<device::DriveSignal> signals(fields.size());
    for (std::size_t k = 0; k < fields.size(); ++k)
        if (!encodeFor(where, fields[k], signals[k])) return false;
    std::vector<double> most_Pa;
    std::vector<double> ears;
    playedOf(FieldBounds(where, _ability), signals, most_Pa, &ears);
    double atPoints = 0.0;
    double atEars = 0.0;
    for (std::size_t k = 0; k < fields.size(); ++k)
    {
        atPoints = std::max(atPoints, most_Pa[k] / _max_Pa);
        atEars = std::max(atEars, ears[k]);
    }
    return atEars >= atPoints;
}

bool PressureCap::keepsToEars(const Where& where,
                              const std::vector<device::DriveSignal>& signals) const
{
    if (!where.ears || signals.empty()) return true;
    std::vector<double> most_Pa;
    std::vector<double> ears;
    playedOf(FieldBounds(where, _ability), signals, most_Pa, &ears);
    // NaN fails this comparison.
    return std::all_of(ears.begin(), ears.end(), [](double excess) { return excess <= 1.0; });
}

std::string PressureCap::message() const
{
    return fmt::format("the field is held down to the cap of {:g} Pa at any control point",
                       _max_Pa);
}

bool isSilent(const std::vector<Eigen::VectorXcf>& fields)
{
    return std::all_of(
        fields.begin(), fields.end(), [](const Eigen::VectorXcf& q) { return q.isZero(0.0f); });
}

// The part of PressureCap that explains fields which no level of the device can play.

// Returns the lowest duty that sounds; 0 if none does.
int PressureCap::lowestDuty(int transducers) const
{
    device::DriveSignal all = device::silentSignal(transducers);
    for (int duty = 1; duty < 256; ++duty)
    {
        std::fill(all.duty.begin(), all.duty.end(), static_cast<std::uint8_t>(duty));
        if (!_play(all).isZero(0.0f)) return duty;
    }
    return 0;
}

LowestLevel PressureCap::lowest(const Where& where,
                                const std::vector<Eigen::VectorXcf>& fields,
                                bool alone) const
{
    LowestLevel result;
    if (fields.empty()) return result;
    const auto transducers = static_cast<int>(fields.front().size());
    const int duty = lowestDuty(transducers);
    if (duty == 0) return result;
    std::vector<device::DriveSignal> signals;
    for (const Eigen::VectorXcf& q : fields)
    {
        // Encoded at full drive, which keeps the phases of transducers that are too weak for a
        // duty.
        const Eigen::VectorXcf full = q.unaryExpr(
            [](const std::complex<float>& one) { return one == 0.0f ? one : one / std::abs(one); });
        device::DriveSignal signal;
        if (!device::encode(full.data(), transducers, signal)) continue;
        setToLowest(duty, signal);
        if (alone) keepFirst(signal);
        signals.push_back(std::move(signal));
    }
    std::vector<double> most_Pa;
    std::vector<double> ears;
    playedOf(FieldBounds(where, _ability), signals, most_Pa, &ears);
    for (const double one_Pa : most_Pa)
        result.pressure_Pa = std::max(result.pressure_Pa, one_Pa);
    for (const double excess : ears)
        result.ears = std::max(result.ears, excess);
    device::DriveSignal one = device::silentSignal(transducers);
    std::fill(one.duty.begin(), one.duty.end(), static_cast<std::uint8_t>(duty));
    result.amplitude = 1.0;
    for (const std::complex<float>& q : _play(one))
        if (std::abs(q) > 0.0f)
            result.amplitude = std::min(result.amplitude, static_cast<double>(std::abs(q)));
    return result;
}

// Explains a cap that is too low for any number of transducers.
std::string PressureCap::tellOfCap(const Where& where,
                                   const std::vector<Eigen::VectorXcf>& wanted,
                                   const SilenceRemedy& remedy) const
{
    const bool alone = mayThinOut(wanted);
    const LowestLevel least = lowest(where, wanted, alone);
    const std::string who = fmt::format("{}, {:.3g} of full drive,",
                                        alone ? "one transducer alone at its lowest level"
                                              : "transducers at their lowest level",
                                        least.amplitude);
    const char* give = alone ? "gives" : "give";
    if (where.ears && least.ears >= least.pressure_Pa / _max_Pa)
        return fmt::format(
            "silent: the array's levels are too coarse for the ear limit of {:g} dB; "
            "{} {} up to {:.1f} dB: raise {} above that",
            where.ears->limit_dB(),
            who,
            give,
            upwards_dB(where.ears->limit_dB() + 20.0 * std::log10(least.ears)),
            remedy.ears);
    return fmt::format("silent: the array's levels are too coarse for the cap of {:g} Pa at any "
                       "control point; {} {} up to {:.3g} Pa: raise {} above that",
                       _max_Pa,
                       who,
                       give,
                       upwards(least.pressure_Pa),
                       remedy.cap);
}

std::string PressureCap::tellOfSilence(const Where& where,
                                       const std::vector<Eigen::VectorXcf>& wanted,
                                       const SilenceRemedy& remedy,
                                       haptics::SolveReport& report) const
{
    using haptics::StopReason;
    for (const StopReason said : {StopReason::REFUSED,
                                  StopReason::NOTHING_TO_DO,
                                  StopReason::STOPPED,
                                  StopReason::SILENCED})
        if (report.stop == said) return {};
    const LowestLevel least = lowest(where, wanted);
    const double least_Pa = upwards(least.pressure_Pa);
    std::string told;
    // No level sounds, whatever was requested.
    if (least.amplitude <= 0.0)
        told = fmt::format("silent: the cap of the amplitude is below the array's lowest level: "
                           "raise {}",
                           remedy.amplitude);
    else if (report.capFactor > 0.0)
    {
        told = fmt::format("silent: the field asked for is weaker than the array's lowest level, "
                           "{:.3g} of full drive",
                           least.amplitude);
        if (least_Pa > 0.0) told += fmt::format(", which gives up to {:.3g} Pa", least_Pa);
        told += ": raise " + remedy.target;
    }
    else
        told = tellOfCap(where, wanted, remedy);
    report.stop = StopReason::SILENCED;
    report.message += (report.message.empty() ? "" : "; ") + told;
    return told;
}

} // namespace midair::bridge
