// The part of PressureCap that tells of fields which no level of the device can play.
#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/playing/FieldBounds.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

// Rounds up to three digits: a cap of the pressure that is told must be enough.
double upwards(double value)
{
    if (!(value > 0.0) || !std::isfinite(value)) return value;
    const double digit = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
    return std::ceil(value / digit) * digit;
}

// Leaves the first transducer that sounds, in the order in which they are thinned out.
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

} // namespace

bool isSilent(const std::vector<Eigen::VectorXcf>& fields)
{
    return std::all_of(
        fields.begin(), fields.end(), [](const Eigen::VectorXcf& q) { return q.isZero(0.0f); });
}

// Returns the lowest duty that sounds; 0: none does.
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

void PressureCap::setToLowest(int duty, device::DriveSignal& signal) const
{
    for (std::uint8_t& level : signal.duty)
        level = level > 0 ? static_cast<std::uint8_t>(duty) : level;
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
        // Encoded at full drive: what is too weak for a duty keeps its phase that way.
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

// What no number of transducers is quiet enough for.
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
        return fmt::format("silent: the array's levels can't keep to the ear limit of {:g} dB; "
                           "{} {} up to {:.1f} dB: raise {} above that",
                           where.ears->limit_dB(),
                           who,
                           give,
                           upwards_dB(where.ears->limit_dB() + 20.0 * std::log10(least.ears)),
                           remedy.ears);
    return fmt::format("silent: the array's levels can't keep to the cap of {:g} Pa at any control "
                       "point; {} {} up to {:.3g} Pa: raise {} above that",
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
    // Whatever was asked for: no level sounds.
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
