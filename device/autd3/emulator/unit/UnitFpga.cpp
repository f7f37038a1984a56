#include "device/autd3/emulator/unit/UnitFpga.h"

#include "haptics/base/DutyLaw.h"

#include <algorithm>
#include <cmath>

namespace midair::device::emulation
{

namespace
{

constexpr std::uint64_t kHashStart = 0xCBF29CE484222325U; // FNV-1a
constexpr std::uint64_t kHashFactor = 0x100000001B3U;
constexpr int kFullWidth = 512;

std::uint64_t mixed(std::uint64_t hash, std::uint64_t value)
{
    return (hash ^ value) * kHashFactor;
}

// Strict, it wants dividers of as many periods as it takes, so that all is reached.
int stepsOf(const UnitSilencer::Settings& silencer, bool ofPatterns)
{
    if (!silencer.strict || silencer.byRate) return 0;
    return ofPatterns ? std::max(silencer.stepsIntensity, silencer.stepsPhase)
                      : silencer.stepsIntensity;
}

UnitFpga::WidthTable defaultWidths()
{
    UnitFpga::WidthTable widths{};
    for (int i = 0; i < 256; ++i)
        widths[i] =
            static_cast<std::uint16_t>(std::lround(kFullWidth / base::kPi * std::asin(i / 255.0)));
    return widths;
}

} // namespace

std::uint64_t contentOf(const std::uint8_t* phase, const std::uint8_t* duty)
{
    std::uint64_t hash = kHashStart;
    for (int i = 0; i < kUnitTransducers; ++i)
        hash = mixed(hash, duty[i] == 0 ? 0U : 256U * phase[i] + duty[i]);
    return hash;
}

void CycleContent::add(std::uint64_t field)
{
    if (_empty) _first = field;
    _empty = false;
    _alike = _alike && field == _first;
    _all = mixed(_all, field);
}

std::uint8_t dutyOfWidth(std::uint16_t width)
{
    // A pulse that is longer than half the period sounds as its rest.
    const int sounding = std::min<int>(width, kFullWidth - width);
    return static_cast<std::uint8_t>((base::kDutyPeriod * sounding + kFullWidth / 2) / kFullWidth);
}

void UnitFpga::clear(Time_ns now_ns)
{
    render(now_ns);
    for (int bank = 0; bank < 2; ++bank)
    {
        if (_slots[bank].empty()) _slots[bank].resize(1);
        _slots[bank][0] = UnitPattern();
        _samples[bank].resize(std::max<std::size_t>(2, _samples[bank].size()));
        _samples[bank][0] = _samples[bank][1] = 255;
    }
    _patterns.clear(1);
    _modulation.clear(2);
    _steady = true;
    _silencer.set(UnitSilencer::Settings());
    _correction.fill(0);
    _on.fill(true);
    _widths = defaultWidths();
    _gated = false;
}

UnitPattern UnitFpga::slotOf(int bank, std::uint32_t slot) const
{
    return slot < _slots[bank].size() ? _slots[bank][slot] : UnitPattern();
}

void UnitFpga::writeSlot(int bank, std::uint32_t slot, const UnitPattern& pattern, Time_ns now_ns)
{
    const bool plays = bank == _patterns.bank();
    const bool waits = _patterns.waits() && bank == _patterns.waitingBank();
    if ((plays || waits) && slot < _patterns.valid(bank).slots) ++_intrusions.banks;
    if (plays && slot == _patterns.slotAt(now_ns))
    {
        ++_intrusions.slots;
        render(now_ns);
    }
    if (_slots[bank].size() <= slot) _slots[bank].resize(slot + 1);
    _slots[bank][slot] = pattern;
}

void UnitFpga::writeSamples(
    int bank, std::uint32_t first, const std::uint8_t* samples, std::size_t count, Time_ns now_ns)
{
    if (bank == _modulation.bank()) render(now_ns);
    if (_samples[bank].size() < first + count) _samples[bank].resize(first + count);
    std::copy(samples, samples + count, _samples[bank].begin() + first);
    lookAtModulation();
}

void UnitFpga::lookAtModulation()
{
    const int bank = _modulation.bank();
    const std::size_t samples = _modulation.playing().slots;
    // What was never written reads 0.
    const auto& all = _samples[bank];
    _steady = all.size() >= samples && std::all_of(all.begin(),
                                                   all.begin() + std::ptrdiff_t(samples),
                                                   [&](auto sample) { return sample == all[0]; });
}

int UnitFpga::strictSteps(bool ofPatterns) const
{
    return stepsOf(_silencer.settings(), ofPatterns);
}

Result UnitFpga::activatePatterns(int bank,
                                  Activation mode,
                                  std::uint64_t value,
                                  Time_ns now_ns,
                                  Time_ns cpu_ns,
                                  Time_ns margin_ns)
{
    render(now_ns);
    return _patterns.activate(bank, mode, value, now_ns, cpu_ns, {margin_ns, strictSteps(true)});
}

Result UnitFpga::activateModulation(int bank,
                                    Activation mode,
                                    std::uint64_t value,
                                    Time_ns now_ns,
                                    Time_ns cpu_ns,
                                    Time_ns margin_ns)
{
    render(now_ns);
    const Result result =
        _modulation.activate(bank, mode, value, now_ns, cpu_ns, {margin_ns, strictSteps(false)});
    lookAtModulation();
    return result;
}

Result UnitFpga::setSilencer(const UnitSilencer::Settings& settings, Time_ns now_ns)
{
    if (!_patterns.reaches(stepsOf(settings, true)) ||
        !_modulation.reaches(stepsOf(settings, false)))
        return Result::SILENCER;
    render(now_ns);
    _silencer.set(settings);
    return Result::DONE;
}

void UnitFpga::setCorrection(const UnitLevels& levels, Time_ns now_ns)
{
    render(now_ns);
    _correction = levels;
}

void UnitFpga::setMask(const std::array<bool, kUnitTransducers>& on, Time_ns now_ns)
{
    render(now_ns);
    _on = on;
}

void UnitFpga::setGate(bool closed, Time_ns now_ns)
{
    render(now_ns);
    _gated = closed;
}

bool UnitFpga::takeSwitch(Time_ns now_ns, BankTimeline::Switch& made)
{
    if (_modulation.due_ns() <= now_ns) render(_modulation.due_ns());
    if (_modulation.takeSwitch(now_ns, made)) lookAtModulation();
    if (_patterns.due_ns() <= now_ns) render(_patterns.due_ns());
    return _patterns.takeSwitch(now_ns, made);
}

} // namespace midair::device::emulation
