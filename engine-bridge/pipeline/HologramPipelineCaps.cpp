// How a HologramPipeline keeps fields to the caps: of the pressure at points, and of the level at
// ears.
#include "device/limits/GuardedDevice.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/Limits.h"
#include "haptics/base/threads/SteadyClock.h"

#include <memory>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

void HologramPipeline::tellOfDeath()
{
    const haptics::TransducerArray& array = _options.array;
    _isDead = array.gain.size() > 0 && array.gain.isZero(0.0);
    if (_isDead)
        _messages.say({base::MessageCode::ARRAY_DEAD,
                       fmt::format("all {} transducers of the array are dead or have the gain 0; "
                                   "it is silent",
                                   array.size())});
}

// The stricter of the caps of options and device.
void HologramPipeline::setCaps()
{
    _output->setAmplitudeCap(_options.maxAmplitude);
    const device::DriveAbility ability = _output->ability();
    const double cap_Pa = device::stricterPressure(_options.maxPressure, ability.maxPressure_Pa);
    _capped = cap_Pa > 0.0;
    _cap_Pa = cap_Pa;
    _capName = cap_Pa == _options.maxPressure ? "MaxPressure" : "max-pressure of the device";
    _silenceTold = false;
    const auto wouldPlay = [this](const device::DriveSignal& signal)
    { return _output->wouldPlay(signal); };
    _cap = std::make_unique<PressureCap>(
        _capped ? cap_Pa : base::kMostPressure_Pa, wouldPlay, ability);
}

// A lower amplitude alone is the device's matter, but with a pressure cap the fields that are being
// capped are rounded to other levels then.
bool HologramPipeline::isStricter(const HologramOptions& options) const
{
    const double now_Pa = _cap_Pa;
    if (!(options.maxPressure >= 0.0) || !(options.earLimit >= 0.0)) return true;
    const double ears_dB = _ears.limit_dB();
    if (options.earLimit > 0.0 && !(ears_dB > 0.0 && options.earLimit >= ears_dB)) return true;
    // Lower amplitudes are rounded to other levels, for which a factor has to be found anew.
    if (ears_dB > 0.0 && !(options.maxAmplitude >= _output->amplitudeCap())) return true;
    if (options.maxPressure > 0.0 && !(now_Pa > 0.0 && options.maxPressure >= now_Pa)) return true;
    return now_Pa > 0.0 && !(options.maxAmplitude >= _output->amplitudeCap());
}

haptics::ExposureFigures HologramPipeline::exposure() const
{
    return _ears.reading(base::steadySeconds());
}

// Array and air never change without it.
void HologramPipeline::setEars()
{
    _ears.setPlace(_options.array, _options.medium, _options.earPoints);
    _ears.setLimit(_options.earLimit);
}

// With a limit the field is held down for where the ears are now; else they just hear another one.
bool HologramPipeline::hasMovedEars(const SceneSnapshot& snapshot)
{
    if (_ears.isUnmoved(snapshot.ears)) return false;
    _ears.setEars(snapshot.ears);
    if (_ears.limit_dB() > 0.0) return true;
    if (_last && _last->state == ArrayState::PLAYING)
        _ears.play(_last->sequence.fields, base::steadySeconds());
    return false;
}

// A hand that shadows may be gone before the next field, so the cap must hold without it too.
PressureCap::Where HologramPipeline::where(const haptics::TransducerArray& array,
                                           const Eigen::Matrix3Xd& points,
                                           bool modulated)
{
    static const Eigen::Matrix3Xd kNowhere(3, 0);
    std::vector<const haptics::TransducerArray*> arrays{&array};
    if (&array != &_options.array) arrays.push_back(&_options.array);
    return {_capped ? points : kNowhere,
            std::move(arrays),
            _options.medium,
            modulated,
            _options.solverOptions.threads,
            _options.solverOptions.stop,
            _ears.bound()};
}

void HologramPipeline::cap(const haptics::TransducerArray& array,
                           haptics::FieldSequence& sequence,
                           HologramResult& result)
{
    _proven = {};
    if (sequence.isHeld() && sequence.achieved_Pa.size() > 0)
        _proven.held = {1.0, sequence.fields.front(), sequence.achieved_Pa};
    if (!_capped && !(_ears.limit_dB() > 0.0)) return;
    if (_capped) result.maxPressure_Pa = _cap->max_Pa();
    if (sequence.isEmpty()) return;
    const haptics::ControlPoints points = sequence.points();
    const PressureCap::Where place =
        where(array, points.positions, sequence.modulation.amplitudeRate_Hz > 0.0);
    const std::vector<Eigen::VectorXcf> wanted = sequence.fields;
    sequence.report.capFactor = _cap->hold(place, sequence, &_proven);
    // Of parts that may sound alone the cap adds up each by itself.
    if (!_output->ability().part.empty()) _proven.held = {};
    if (sequence.report.capFactor >= 1.0) return;
    ++_counters.capped;
    if (sequence.report.capFactor <= 0.0)
        tellOfSilence(place, wanted, sequence.report);
    else if (_cap->isForEars(place, sequence.fields))
        _messages.say(
            {base::MessageCode::CAP_EARS,
             fmt::format("the field is held down to the ear limit of {:g} dB", _ears.limit_dB())});
    else
        _messages.say({base::MessageCode::CAP_PRESSURE, _cap->message()});
}

// The pressures in the message are those of one moment: told once, they are in each report.
void HologramPipeline::tellOfSilence(const PressureCap::Where& where,
                                     const std::vector<Eigen::VectorXcf>& wanted,
                                     haptics::SolveReport& report)
{
    if (_isDead) return; // told already
    // It is 0 as well where a scene or an object isn't understood, which is told by itself.
    const double most = _output->amplitudeCap();
    const std::string amplitude =
        most <= 0.0 ? "MaxAmplitude if it is 0, or mend what another message says is not understood"
        : most < 1.0 ? fmt::format("MaxAmplitude, which is {:g}", most)
                     : "max-amplitude of the device";
    const std::string told =
        _cap->tellOfSilence(where, wanted, {_capName, "Pressure or Loudness", amplitude}, report);
    if (!told.empty() && !std::exchange(_silenceTold, true))
        _messages.say({base::MessageCode::FIELD_SILENCED, told});
}

// What is wanted and gives silence is a fault: the array has no level so low, or doesn't get there.
void HologramPipeline::tellReport(const haptics::ControlPoints& points,
                                  haptics::FieldSequence& sequence)
{
    using base::MessageCode;
    haptics::SolveReport& report = sequence.report;
    const bool isRefused = report.stop == haptics::StopReason::REFUSED;
    const bool isSilence = report.stop == haptics::StopReason::NOTHING_TO_DO &&
                           points.targets.maxCoeff() > 0.0 && isSilent(sequence.fields);
    if (isSilence) report.stop = haptics::StopReason::SILENCED;
    if (isSilence) report.message = "silent: " + report.message;
    if (report.message.empty()) return;
    _messages.say({isSilence   ? MessageCode::FIELD_SILENCED
                   : isRefused ? MessageCode::SOLVER_REFUSED
                               : MessageCode::SOLVER_REPORT,
                   report.message});
}

} // namespace midair::bridge
