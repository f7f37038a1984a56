#include "device/autd3/emulator/unit/UnitFpga.h"

#include "haptics/base/DutyLaw.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>

namespace midair::device::emulation
{

namespace
{

constexpr Time_ns kTimeStep_ns = 3125; // resolution of a timed switch

Time_ns nextMultiple(Time_ns time_ns, Time_ns step_ns)
{
    return (time_ns / step_ns + 1) * step_ns;
}

Time_ns edgeFrom(Time_ns time_ns)
{
    return (time_ns + kPeriod_ns - 1) / kPeriod_ns * kPeriod_ns;
}

// Returns the equivalent of level nearest to value.
float nearestTurn(float level, float value)
{
    return level + 256.0F * std::round((value - level) / 256.0F);
}

constexpr std::uint64_t kHashStart = 0xCBF29CE484222325U; // FNV-1a
constexpr std::uint64_t kHashFactor = 0x100000001B3U;
constexpr int kFullWidth = 512;

std::uint64_t mixed(std::uint64_t hash, std::uint64_t value)
{
    return (hash ^ value) * kHashFactor;
}

// Strict mode requires dividers of at least the number of steps, so that targets are reached; 0:
// any divider.
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

// Number of last changes to play through the silencer after a pause; by default it moves for 40
// periods, and a bank changes at most once a period.
constexpr Time_ns kMostChanges = 160;

} // namespace

void BankTimeline::clear(std::uint32_t slots)
{
    *this = BankTimeline();
    for (int bank = 0; bank < 2; ++bank)
        _written[bank].slots = _valid[bank].slots = slots;
}

void BankTimeline::play(int bank, Time_ns at_ns, bool forEver)
{
    _last = {edgeFrom(at_ns), bank, bank == _bank};
    _switched = true;
    _bank = bank;
    _start_ns = at_ns;
    _forEver = forEver;
    _waits = false;
}

Result BankTimeline::activate(const Activating& command, int steps)
{
    const auto [bank, mode, value, fpga_ns, cpu_ns, margin_ns] = command;
    const bool forEver = _written[bank].rounds == 0;
    if (forEver != (mode == Activation::NOW)) return Result::MODE;
    const auto time_ns = static_cast<Time_ns>(std::min(value, std::uint64_t(kNever_ns / 2)));
    if (mode == Activation::TIME && time_ns - cpu_ns < margin_ns) return Result::TIME;
    const auto fits = [&](int heard)
    { return _written[heard].divider >= static_cast<std::uint32_t>(steps); };
    // Until a switch with rounds takes place, the other bank plays.
    if (!fits(bank) || (!forEver && !fits(_bank))) return Result::SILENCER;
    _valid = _written;
    if (forEver)
    {
        _requested = bank;
        play(bank, fpga_ns, true);
        return Result::DONE;
    }
    if (bank == _requested) return Result::DONE; // without effect
    _requested = bank;
    _waits = true;
    _due_ns = mode == Activation::TIME
                  ? time_ns / kTimeStep_ns * kTimeStep_ns
                  : nextMultiple(fpga_ns, _valid[bank].slot_ns() * Time_ns(_valid[bank].slots));
    return Result::DONE;
}

bool BankTimeline::takeSwitch(Time_ns fpga_ns, Switch& made)
{
    if (!_switched && _waits && _due_ns <= fpga_ns) play(_requested, _due_ns, false);
    if (!_switched) return false;
    _switched = false;
    made = _last;
    return true;
}

bool BankTimeline::reaches(int steps) const
{
    const auto fits = [&](int heard)
    { return _valid[heard].divider >= static_cast<std::uint32_t>(steps); };
    return fits(_requested) && (_valid[_requested].rounds == 0 || fits(_bank));
}

std::uint32_t BankTimeline::slotAt(Time_ns fpga_ns) const
{
    const BankRegisters& registers = playing();
    const auto step = std::uint64_t(fpga_ns / registers.slot_ns());
    if (_forEver) return static_cast<std::uint32_t>(step % registers.slots);
    if (endedAt(fpga_ns)) return registers.slots - 1;
    const Time_ns played = Time_ns(step) - _start_ns / registers.slot_ns();
    return played < 0 ? 0 : static_cast<std::uint32_t>(std::uint64_t(played) % registers.slots);
}

bool BankTimeline::endedAt(Time_ns fpga_ns) const
{
    if (_forEver) return false;
    const BankRegisters& registers = playing();
    return fpga_ns / registers.slot_ns() - _start_ns / registers.slot_ns() >=
           Time_ns(registers.slots) * registers.rounds;
}

void UnitSilencer::Gliding::headFor(float next, int steps)
{
    if (next == target) return;
    target = next;
    step = (target - value) / static_cast<float>(steps);
    left = steps;
}

void UnitSilencer::Gliding::pass(Time_ns periods, bool byRate, float rate)
{
    if (value == target) return;
    if (byRate)
    {
        const float way = rate * static_cast<float>(periods);
        value = value < target ? std::min(target, value + way) : std::max(target, value - way);
        return;
    }
    const Time_ns passed = std::min<Time_ns>(periods, left);
    left -= static_cast<int>(passed);
    value = left == 0 ? target : value + step * static_cast<float>(passed);
}

void UnitSilencer::head(const UnitPattern& target)
{
    for (int i = 0; i < kUnitTransducers; ++i)
    {
        Gliding& phase = _phase[i];
        // If it is already moving there, it continues: another turn of the same level is not a new
        // target.
        if (phase.target - 256.0F * std::floor(phase.target / 256.0F) != float(target.phase[i]))
            phase.headFor(nearestTurn(target.phase[i], phase.value), _settings.stepsPhase);
        _intensity[i].headFor(target.intensity[i], _settings.stepsIntensity);
    }
}

void UnitSilencer::jump(const UnitPattern& target)
{
    for (int i = 0; i < kUnitTransducers; ++i)
    {
        _phase[i] = {float(target.phase[i]), float(target.phase[i]), 0, 0};
        _intensity[i] = {float(target.intensity[i]), float(target.intensity[i]), 0, 0};
    }
}

void UnitSilencer::glide(Time_ns periods)
{
    for (int i = 0; i < kUnitTransducers; ++i)
    {
        Gliding& phase = _phase[i];
        phase.pass(periods, _settings.byRate, _settings.ratePhase / 256.0F);
        const float turns = 256.0F * std::floor(phase.value / 256.0F); // prevents accumulating
                                                                       // turns
        phase.value -= turns;
        phase.target -= turns;
        _intensity[i].pass(periods, _settings.byRate, _settings.rateIntensity / 256.0F);
    }
}

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
    // A pulse longer than half the period is equivalent to its complement.
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
    // Unwritten memory reads 0.
    const auto& all = _samples[bank];
    _steady = all.size() >= samples && std::all_of(all.begin(),
                                                   all.begin() + std::ptrdiff_t(samples),
                                                   [&](auto sample) { return sample == all[0]; });
}

Result UnitFpga::activatePatterns(const Activating& command)
{
    render(command.fpga_ns);
    return _patterns.activate(command, stepsOf(_silencer.settings(), true));
}

Result UnitFpga::activateModulation(const Activating& command)
{
    render(command.fpga_ns);
    const Result result = _modulation.activate(command, stepsOf(_silencer.settings(), false));
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
    // Targets change with slots and samples.
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
