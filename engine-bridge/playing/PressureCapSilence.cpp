// The part of PressureCap that tells of fields which no level of the device can play.
#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/playing/FieldBounds.h"
#include "engine-bridge/playing/PressureCap.h"

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

LowestLevel PressureCap::lowest(const Where& where,
                                const std::vector<Eigen::VectorXcf>& fields) const
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
        for (std::uint8_t& level : signal.duty)
            level = level > 0 ? static_cast<std::uint8_t>(duty) : level;
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
    else if (where.ears && least.ears >= least.pressure_Pa / _max_Pa)
        told = fmt::format("silent: the array's levels can't keep to the ear limit of {:g} dB; "
                           "transducers at their lowest level, {:.3g} of full drive, give up to "
                           "{:.1f} dB: raise {} above that",
                           where.ears->limit_dB(),
                           least.amplitude,
                           upwards_dB(where.ears->limit_dB() + 20.0 * std::log10(least.ears)),
                           remedy.ears);
    else
        told = fmt::format("silent: the array's levels can't keep to the cap of {:g} Pa at any "
                           "control point; transducers at their lowest level, {:.3g} of full "
                           "drive, give up to {:.3g} Pa: raise {} above that",
                           _max_Pa,
                           least.amplitude,
                           least_Pa,
                           remedy.cap);
    report.stop = StopReason::SILENCED;
    report.message += (report.message.empty() ? "" : "; ") + told;
    return told;
}

} // namespace midair::bridge
