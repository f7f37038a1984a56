#include "device/autd3/emulator/unit/FieldWatch.h"

#include "device/autd3/emulator/unit/UnitFpga.h"

#include <algorithm>

namespace midair::device::emulation
{

namespace
{

constexpr std::size_t kMostExpected = 256;

} // namespace

FieldWatch::FieldWatch(int units, Time_ns tolerance_ns) :
    _tolerance_ns(tolerance_ns),
    _units(static_cast<std::size_t>(units))
{
    const DriveSignal silent = silentSignal(kUnitTransducers);
    const std::uint64_t content = contentOf(silent.phase.data(), silent.duty.data());
    _silence = {0, std::vector<std::uint64_t>(_units.size(), content)};
    for (Seen& unit : _units)
        unit.content = content;
}

void FieldWatch::expect(std::uint64_t number, const DriveSignal& signal)
{
    expect(number, std::vector<DriveSignal>{signal});
}

void FieldWatch::expect(std::uint64_t number, const std::vector<DriveSignal>& cycle)
{
    Expected expected{number, {}};
    for (std::size_t unit = 0; unit < _units.size(); ++unit)
    {
        CycleContent content;
        for (const DriveSignal& signal : cycle)
            if (signal.fits(static_cast<int>(_units.size()) * kUnitTransducers))
                content.add(contentOf(signal.phase.data() + unit * kUnitTransducers,
                                      signal.duty.data() + unit * kUnitTransducers));
        expected.contents.push_back(content.value());
    }
    _expected.push_back(std::move(expected));
    if (_expected.size() > kMostExpected) _expected.pop_front();
}

bool FieldWatch::known(int unit, std::uint64_t content) const
{
    const auto has = [&](const Expected& one) { return one.contents[unit] == content; };
    return has(_silence) || std::any_of(_expected.begin(), _expected.end(), has);
}

const FieldWatch::Expected* FieldWatch::together() const
{
    const auto plays = [this](const Expected& one)
    {
        for (std::size_t unit = 0; unit < _units.size(); ++unit)
            if (_units[unit].counts() && _units[unit].content != one.contents[unit]) return false;
        return true;
    };
    const auto found = std::find_if(_expected.rbegin(), _expected.rend(), plays);
    if (found != _expected.rend()) return &*found;
    return plays(_silence) ? &_silence : nullptr;
}

void FieldWatch::begin(Time_ns at_ns)
{
    _changing = true;
    _since_ns = at_ns;
}

void FieldWatch::end(Time_ns at_ns)
{
    const Time_ns took_ns = at_ns - _since_ns;
    _changing = false;
    if (took_ns <= _tolerance_ns)
    {
        ++_report.whole;
        _report.worstSkew_ns = std::max(_report.worstSkew_ns, took_ns);
        return;
    }
    ++_report.torn;
    _report.longestTear_ns = std::max(_report.longestTear_ns, took_ns);
}

void FieldWatch::look(Time_ns at_ns)
{
    if (_expected.empty())
    {
        lookBySwitches(at_ns, false);
        return;
    }
    if (std::none_of(_units.begin(), _units.end(), [](const Seen& one) { return one.counts(); }))
    {
        if (_changing) end(at_ns);
        return;
    }
    const Expected* field = together();
    if (field == nullptr)
    {
        if (!_changing) begin(at_ns);
        return;
    }
    const bool isNew = field->number != _report.lastNumber;
    if (!_changing && isNew) begin(at_ns); // a single unit, or all others are ignored
    if (_changing) end(at_ns);
    if (isNew && field->number > _newest)
    {
        _newest = field->number;
        ++_report.numbersPlayed;
    }
    _report.lastNumber = field->number;
}

void FieldWatch::lookBySwitches(Time_ns at_ns, bool again)
{
    // A second switch of a unit before the others made the first: they missed one.
    if (_changing && again)
    {
        ++_report.torn;
        _report.longestTear_ns = std::max(_report.longestTear_ns, at_ns - _since_ns);
        for (Seen& unit : _units)
            unit.switched = false;
        _changing = false;
    }
    const auto any = [this](bool switched)
    {
        return std::any_of(_units.begin(),
                           _units.end(),
                           [&](const Seen& unit)
                           { return unit.counts() && unit.switched == switched; });
    };
    if (!_changing && any(true)) begin(at_ns);
    if (!_changing || any(false)) return;
    end(at_ns);
    for (Seen& unit : _units)
    {
        unit.missed = unit.closed && !unit.switched;
        unit.switched = false;
    }
}

void FieldWatch::switched(int unit, Time_ns at_ns, std::uint64_t content, bool replays)
{
    Seen& seen = _units[unit];
    const bool same = seen.content == content;
    if (!_expected.empty() && !known(unit, content)) ++_report.unknown;
    seen.content = content;
    for (Seen& other : _units)
        if (other.light == Light::CLEARED) other.light = Light::LIT;
    seen.light = Light::LIT;
    if (!_expected.empty())
    {
        look(at_ns);
        return;
    }
    if (replays && same) return; // a switch taken back
    if (seen.switched) lookBySwitches(at_ns, true);
    seen.switched = true;
    lookBySwitches(at_ns, false);
}

void FieldWatch::changed(int unit, Time_ns at_ns, std::uint64_t content)
{
    if (_units[unit].content == content) return;
    if (!_expected.empty() && _units[unit].counts() && !known(unit, content)) ++_report.unknown;
    _units[unit].content = content;
    look(at_ns);
}

void FieldWatch::cleared(int unit, Time_ns at_ns, std::uint64_t content)
{
    _units[unit] = {content, Light::CLEARED, false, false, false};
    look(at_ns);
}

void FieldWatch::rebooted(int unit, Time_ns at_ns, std::uint64_t content)
{
    _units[unit] = {content, Light::OFF, false, false, false};
    look(at_ns);
}

void FieldWatch::closed(int unit, Time_ns at_ns, bool isClosed)
{
    if (_units[unit].closed == isClosed) return;
    _units[unit].closed = isClosed;
    if (!isClosed && _units[unit].missed) // the others play another field by now
        for (Seen& other : _units)
            other.switched = &other != &_units[unit];
    _units[unit].missed = false;
    look(at_ns);
}

FieldWatchReport FieldWatch::report(Time_ns now_ns) const
{
    FieldWatchReport report = _report;
    if (_changing && now_ns - _since_ns > _tolerance_ns)
    {
        ++report.torn;
        report.longestTear_ns = std::max(report.longestTear_ns, now_ns - _since_ns);
    }
    return report;
}

} // namespace midair::device::emulation
