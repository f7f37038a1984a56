#include "device/boards/BoardCodec.h"

#include "haptics/base/DutyLaw.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace midair::device
{

int delaySteps(int phase, int steps)
{
    const int later = (256 - phase) * steps;
    return ((later + 128) / 256) % steps;
}

std::complex<float> pulseActivation(double delay_turns, double duty)
{
    return std::complex<float>(
        std::polar(base::pulseAmplitude(duty, 1), -base::kTwoPi * delay_turns));
}

double BoardCodec::fieldsPerSecond(int transducers) const
{
    std::vector<std::uint8_t> field;
    appendSilentField(field, transducers);
    return bytesPerSecond() / static_cast<double>(field.size());
}

void BoardCodec::appendSilentField(std::vector<std::uint8_t>& out, int transducers) const
{
    appendField(out, silentSignal(transducers));
}

void BoardCodec::appendSilence(std::vector<std::uint8_t>& out, int transducers) const
{
    appendOpening(out);
    for (int i = 0; i < silentFields(); ++i)
        appendSilentField(out, transducers);
}

BufferSwaps::BufferSwaps(const BoardCodec& codec, const DriveSequence& sequence) :
    _byte_s(1 / codec.bytesPerSecond()),
    _swap(codec.swap()->exchange),
    _idle(codec.swap()->ignored),
    _rate_Hz(sequence.rate_Hz)
{
    for (const DriveSignal& signal : sequence.signals)
    {
        std::vector<std::uint8_t> bytes;
        codec.appendOpening(bytes);
        codec.appendField(bytes, signal);
        bytes.pop_back(); // the swap
        std::size_t field = 0;
        while (field < static_cast<std::size_t>(_count) && _fields[field] != bytes)
            ++field;
        _count = std::max(_count, static_cast<int>(field) + 1);
        if (field == _fields.size()) return;
        _fields[field] = std::move(bytes);
        _order.push_back(field);
    }
}

void BufferSwaps::appendStart(std::vector<std::uint8_t>& out) const
{
    for (const std::size_t field : {1, 0})
    {
        out.insert(out.end(), _fields[field].begin(), _fields[field].end());
        out.push_back(_swap);
    }
}

std::size_t BufferSwaps::wantedAt(double time_s) const
{
    const auto step = static_cast<std::int64_t>(std::floor((time_s - _begin_s) * _rate_Hz));
    const auto count = static_cast<std::int64_t>(_order.size());
    return _order[static_cast<std::size_t>(((step % count) + count) % count)];
}

void BufferSwaps::append(std::vector<std::uint8_t>& out, double from_s, double until_s)
{
    const std::size_t before = out.size();
    const auto time_s = [&] { return from_s + static_cast<double>(out.size() - before) * _byte_s; };
    while (time_s() < until_s)
    {
        const std::size_t back = 1 - _front;
        if (wantedAt(time_s()) == back)
        {
            out.push_back(_swap);
            _front = back;
        }
        else if (_isDue[back])
        {
            out.insert(out.end(), _fields[back].begin(), _fields[back].end());
            _isDue[back] = false;
        }
        else
            out.push_back(_idle);
    }
}

void BufferSwaps::replace(BufferSwaps next, double now_s)
{
    const bool isInStep = next._rate_Hz == _rate_Hz && next._order.size() == _order.size();
    next._begin_s = isInStep ? _begin_s : now_s;
    next._front = _front;
    for (std::size_t field : {0, 1})
        next._isDue[field] = _isDue[field] || next._fields[field] != _fields[field];
    *this = std::move(next);
}

} // namespace midair::device
