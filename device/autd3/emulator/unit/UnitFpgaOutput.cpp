// What a unit's FPGA puts out of its banks.

#include "device/autd3/emulator/unit/UnitFpga.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>

namespace midair::device::emulation
{

namespace
{

// So many of the last changes are played through the silencer after a pause; by default it glides
// for 40 periods, and a bank changes once a period at most.
constexpr Time_ns kMostChanges = 160;

} // namespace

std::uint64_t UnitFpga::content() const
{
    const int bank = _patterns.bank();
    const std::uint32_t slots = _patterns.playing().slots;
    CycleContent content;
    UnitPattern last;
    std::uint64_t number = 0;
    for (std::uint32_t slot = 0; slot < slots; ++slot)
    {
        const UnitPattern pattern = slotOf(bank, slot);
        if (slot == 0 || !(pattern == last))
        {
            const DriveSignal levels = inOurLevels(pattern);
            number = contentOf(levels.phase.data(), levels.duty.data());
            last = pattern;
        }
        content.add(number);
    }
    return content.value();
}

DriveSignal UnitFpga::inOurLevels(const UnitPattern& pattern) const
{
    DriveSignal signal = silentSignal(kUnitTransducers);
    for (int i = 0; i < kUnitTransducers; ++i)
    {
        const std::uint8_t delay = static_cast<std::uint8_t>(pattern.phase[i] + _correction[i]);
        signal.phase[i] = static_cast<std::uint8_t>(256 - delay);
        signal.duty[i] = _on[i] ? dutyOfWidth(_widths[pattern.intensity[i]]) : 0;
    }
    return signal;
}

DriveSignal UnitFpga::field(Time_ns now_ns) const
{
    return inOurLevels(slotOf(_patterns.bank(), _patterns.slotAt(now_ns)));
}

std::uint8_t UnitFpga::sampleAt(Time_ns now_ns) const
{
    const std::vector<std::uint8_t>& samples = _samples[_modulation.bank()];
    const std::uint32_t sample = _steady ? 0 : _modulation.slotAt(now_ns);
    return sample < samples.size() ? samples[sample] : 0;
}

UnitPattern UnitFpga::target(Time_ns now_ns) const
{
    UnitPattern pattern = slotOf(_patterns.bank(), _patterns.slotAt(now_ns));
    const int sample = sampleAt(now_ns);
    for (int i = 0; i < kUnitTransducers; ++i)
    {
        pattern.phase[i] = static_cast<std::uint8_t>(pattern.phase[i] + _correction[i]);
        const bool silent = _gated || !_on[i];
        pattern.intensity[i] =
            static_cast<std::uint8_t>(silent ? 0 : (pattern.intensity[i] * sample + 127) / 255);
    }
    return pattern;
}

void UnitFpga::render(Time_ns now_ns)
{
    const Time_ns until_ns = now_ns / kPeriod_ns * kPeriod_ns;
    if (until_ns < _rendered_ns) // the clock was set
    {
        _rendered_ns = until_ns;
        return;
    }
    // The targets change where a slot or a sample does.
    const auto changes_ns = [this](Time_ns from_ns)
    {
        Time_ns step_ns = kNever_ns;
        if (_patterns.playing().slots > 1 && !_patterns.endedAt(from_ns))
            step_ns = _patterns.playing().slot_ns();
        return _steady ? step_ns : std::min(step_ns, _modulation.playing().slot_ns());
    };
    Time_ns step_ns = changes_ns(_rendered_ns);
    if (step_ns != kNever_ns && (until_ns - _rendered_ns) / step_ns > kMostChanges)
    {
        _rendered_ns = (until_ns - kMostChanges * step_ns) / kPeriod_ns * kPeriod_ns;
        _silencer.jump(target(_rendered_ns));
    }
    while (_rendered_ns < until_ns)
    {
        step_ns = changes_ns(_rendered_ns);
        const Time_ns next_ns = step_ns == kNever_ns
                                    ? until_ns
                                    : std::min(until_ns, (_rendered_ns / step_ns + 1) * step_ns);
        _silencer.head(target(_rendered_ns));
        _silencer.glide((next_ns - _rendered_ns) / kPeriod_ns);
        _rendered_ns = next_ns;
    }
    _silencer.head(target(_rendered_ns));
}

std::vector<std::complex<float>> UnitFpga::output(Time_ns now_ns)
{
    render(now_ns);
    std::vector<std::complex<float>> q(kUnitTransducers);
    for (int i = 0; i < kUnitTransducers; ++i)
    {
        const auto index = static_cast<int>(std::lround(_silencer.intensity(i)));
        const double width = _widths[std::clamp(index, 0, 255)];
        const double amplitude = base::pulseAmplitude(width, 512);
        const double phase = -base::kTwoPi * std::lround(_silencer.phase(i)) / 256.0;
        q[i] = std::complex<float>(std::polar(amplitude, phase));
    }
    return q;
}

} // namespace midair::device::emulation
