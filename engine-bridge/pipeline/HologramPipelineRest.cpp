// What a HologramPipeline does while no snapshot comes: refines the field, asks the monitor, looks
// after the device.
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <utility>

namespace midair::bridge
{

double HologramPipeline::rest_s() const
{
    if (rendersContacts())
        return std::clamp(
            _contactField_s + contactPeriod_s() - base::steadySeconds(), 0.0, kAttend_s);
    if (_playsContacts) return 0.0; // they have just ended
    if (!_output->isPlaying()) return kAttend_s;
    if (_refiner->hasWork()) return 0.0;
    return _monitor->isPending() ? kMonitorPoll_s : kAttend_s;
}

std::shared_ptr<const HologramResult> HologramPipeline::attend()
{
    if (!_last) return nullptr;
    try
    {
        if ((rendersContacts() || _playsContacts) && !_changed)
        {
            if (auto result = attendContacts()) return _last = result;
            return nullptr;
        }
        if (_output->isPlaying() && _last->points.size() > 0 && !_changed)
        {
            if (auto result = refine()) return _last = result;
            if (auto result = askMonitor()) return _last = result;
        }
        if (auto result = lookAfterDevice()) return _last = result;
    }
    catch (const base::Stopped&)
    {
        // The thread that requested the stop silences the device, or replaces or ends this
        // pipeline.
    }
    catch (...)
    {
        _messages.say({base::MessageCode::FIELD_REST,
                       base::whatWasThrown()}); // what is played already goes on
        _refiner->end();
    }
    return nullptr;
}

std::shared_ptr<const HologramResult> HologramPipeline::refine()
{
    auto sequence = _refiner->step(_last->points, _last->sequence.modulation);
    _counters.solves += static_cast<std::uint64_t>(_refiner->takeSolves());
    if (!sequence) return nullptr;
    _solved.resize(0);
    if (_hasContacts) _whole = *sequence;
    auto result = std::make_shared<HologramResult>(*_last);
    result->outline = sequence->isHeld();
    continueLast(*sequence);
    const haptics::TransducerArray& array =
        _around.shadowed(_last->points, _options.array, _options.wavelength_m());
    cap(array, *sequence, *result);
    play(std::move(*sequence), *result);
    _monitor->forget();
    measure(array, *result);
    rateFromLast(*result);
    finish(*result);
    return result;
}

std::shared_ptr<const HologramResult> HologramPipeline::askMonitor()
{
    if (!_monitor->isOn()) return nullptr;
    _monitor->submit(_last->sequence,
                     _refiner->snapshot().objects,
                     _around.shadowed(_last->points, _options.array, _options.wavelength_m()));
    const auto found = _monitor->takeNew();
    if (!found) return nullptr;
    if (!found->error.empty()) _messages.say({base::MessageCode::MONITOR_FAILED, found->error});
    auto result = std::make_shared<HologramResult>(*_last);
    finish(*result);
    return result;
}

// Figures of a field that rests were taken when it was sent: a ramp or a thermal budget goes on.
bool HologramPipeline::isMeasured() const
{
    if (_last->sequence.fields.size() != 1 || !_output->ability().fades) return true;
    const std::vector<Eigen::VectorXcf> now = _output->played();
    return now.size() == 1 && now.front() == _last->played();
}

std::shared_ptr<const HologramResult> HologramPipeline::lookAfterDevice()
{
    const auto attention = _output->attend(_options.solverOptions.stop);
    const bool isTold = _output->tellOfDriver();
    // After other options the next process() tells more than what has become of the last field.
    if (attention == ArrayOutput::Attention::NOTHING && !isTold && isMeasured() &&
        (_changed || stateOf(*_last) == _last->state))
        return nullptr;
    if (attention == ArrayOutput::Attention::RESENT) ++_counters.resent;
    auto result = std::make_shared<HologramResult>(*_last);
    measure(_around.shadowed(result->points, _options.array, _options.wavelength_m()), *result);
    finish(*result);
    return result;
}

} // namespace midair::bridge
