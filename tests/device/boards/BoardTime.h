#pragma once

#include "device/boards/ByteSink.h"
#include "haptics/base/Units.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <deque>
#include <mutex>
#include <utility>
#include <vector>

// What tests know of a serial board's time: its line, an Arduino's sketch, and the spectrum of what
// sounds.

using Envelope = std::vector<std::pair<double, float>>; ///< since when, s: pressure at a focus

/// A byte and when its last bit has left the line.
struct Sent
{
    double at_s;
    std::uint8_t byte;
};

/// The line behind a UART: a byte begins when it is written, and not before the last one has ended.
class Wire
{
public:
    explicit Wire(double bytesPerSecond) : _byte_s(1 / bytesPerSecond) {}

    void write(const std::vector<std::uint8_t>& bytes)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        const double now_s = midair::base::steadySeconds();
        for (const std::uint8_t byte : bytes)
        {
            _free_s = std::max(_free_s, now_s) + _byte_s;
            _sent.push_back({_free_s, byte});
        }
        _mostAhead_s = std::max(_mostAhead_s, _free_s - now_s);
    }
    /// Bytes that have not begun are taken back.
    void discard()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        const double now_s = midair::base::steadySeconds();
        while (!_sent.empty() && _sent.back().at_s - _byte_s > now_s)
            _sent.pop_back();
        _free_s = _sent.empty() ? now_s : _sent.back().at_s;
    }
    std::vector<Sent> sent() const
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        const double now_s = midair::base::steadySeconds();
        std::vector<Sent> gone = _sent;
        while (!gone.empty() && gone.back().at_s > now_s)
            gone.pop_back();
        return gone;
    }
    double mostAhead_s() const
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _mostAhead_s;
    }

private:
    const double _byte_s;
    mutable std::mutex _mutex;
    std::vector<Sent> _sent;
    double _free_s = 0;
    double _mostAhead_s = 0;
};

/// When the line had bytes all the time, at its longest, of \a bytesPerSecond: from, to.
inline std::pair<double, double> longestBusy(const std::vector<Sent>& sent, double bytesPerSecond)
{
    std::pair<double, double> longest;
    double begin_s = 0;
    for (std::size_t i = 0; i < sent.size(); ++i)
    {
        if (i == 0 || sent[i].at_s - sent[i - 1].at_s > 1.5 / bytesPerSecond)
            begin_s = sent[i].at_s;
        if (sent[i].at_s - begin_s > longest.second - longest.first)
            longest = {begin_s, sent[i].at_s};
    }
    return longest;
}

class WireSink : public midair::device::ByteSink
{
public:
    explicit WireSink(Wire& wire) : _wire(wire) {}
    bool write(const std::vector<std::uint8_t>& bytes) override
    {
        _wire.write(bytes);
        return true;
    }
    void discard() override { _wire.discard(); }

private:
    Wire& _wire;
};

/// DriverMEGA.ino as it runs: one turn of its loop a period of 25 us, in which it plays a pattern
/// and takes at most one byte.
class Sketch
{
public:
    Sketch()
    {
        _durations[0] = _newDurations[0] = 1;
        std::fill_n(_buffers[0].begin(), 50, std::uint8_t(0xFF));
    }

    void give(std::uint8_t byte) { _inbox.push_back(byte); }

    /// The 100 bytes of the pattern that the next period plays.
    const std::uint8_t* pattern() const { return &_buffers[_front][_pattern]; }

    /// One period; returns the pressure in it.
    float turn()
    {
        const float sounds = soundOf(&_buffers[_front][_pattern]);
        ++_periods;
        const auto next = static_cast<std::size_t>(_current) + 1;
        const bool isLast = next == kPatterns;
        const bool returns = !isLast && _durations[next] == 0;
        if (_periods == _durations[_current])
        {
            _periods = 0;
            ++_current;
            _pattern += kPattern;
            if (isLast || returns) _current = 0, _pattern = 0;
        }
        if (!_inbox.empty())
        {
            take(_inbox.front());
            _inbox.pop_front();
        }
        return sounds;
    }

private:
    static constexpr std::size_t kPatterns = 32;
    static constexpr std::size_t kPattern = 100;

    void take(std::uint8_t byte)
    {
        if (byte == 0)
        {
            _front = 1 - _front;
            _pattern = 0;
            _writing = _digit = 0;
        }
        else if ((byte & 0x0F) == 1)
        {
            std::uint8_t& at = _buffers[1 - _front].at(_writing / 2);
            at = static_cast<std::uint8_t>(_writing % 2 == 0 ? byte & 0xF0 : at | byte >> 4);
            ++_writing;
        }
        else if ((byte & 0x3F) == 0x30)
        {
            std::uint8_t& at = _newDurations.at(_digit / 4);
            at = static_cast<std::uint8_t>(_digit % 4 == 0 ? byte & 0xC0
                                                           : at | (byte & 0xC0) >> _digit % 4 * 2);
            ++_digit;
        }
        else if (byte == 0x10)
        {
            _durations = _newDurations;
            _digit = 0;
        }
    }

    // The fundamental of what the first port's first pin is told, as all are told alike.
    static float soundOf(const std::uint8_t* pattern)
    {
        std::complex<double> sum = 0;
        for (int step = 0; step < 10; ++step)
            if (pattern[step * 10] & 1) sum += std::polar(1.0, midair::base::kTwoPi * step / 10);
        return static_cast<float>(std::abs(sum) * std::sin(midair::base::kPi / 10));
    }

    std::array<std::array<std::uint8_t, kPatterns * kPattern>, 2> _buffers{};
    std::array<std::uint8_t, kPatterns> _durations{};
    std::array<std::uint8_t, kPatterns> _newDurations{};
    std::deque<std::uint8_t> _inbox;
    std::size_t _front = 0;
    std::size_t _pattern = 0; ///< where the one that is emitted begins
    std::uint8_t _current = 0;
    std::uint8_t _periods = 0;
    std::size_t _writing = 0;
    std::size_t _digit = 0;
};

/// The amplitude of the squared pressure at a frequency over that of its mean: the depth that the
/// skin feels, 1 for a full cosine.
class Spectrum
{
public:
    Spectrum(const Envelope& envelope, double from_s, double to_s) : _from_s(from_s), _to_s(to_s)
    {
        for (std::size_t i = 0; i < envelope.size(); ++i)
        {
            const double begin_s = std::max(from_s, envelope[i].first);
            const double end_s =
                std::min(to_s, i + 1 < envelope.size() ? envelope[i + 1].first : to_s);
            if (end_s > begin_s)
                _pieces.push_back({begin_s, end_s, std::pow(double(envelope[i].second), 2)});
        }
        for (const Piece& piece : _pieces)
            _mean += piece.power * (piece.end_s - piece.begin_s);
    }

    double depth(double frequency_Hz) const
    {
        std::complex<double> sum = 0;
        const double w = midair::base::kTwoPi * frequency_Hz;
        const auto turn = [&](double t) { return std::polar(1.0, -w * (t - _from_s)); };
        for (const Piece& piece : _pieces)
            sum += piece.power * (turn(piece.end_s) - turn(piece.begin_s)) /
                   std::complex<double>(0, -w);
        return 2 * std::abs(sum) / _mean;
    }

    /// The strongest line from 20 to 600 Hz.
    double strongest_Hz() const
    {
        double best_Hz = 0;
        double most = 0;
        for (double f = 20; f <= 600; f += 0.4 / (_to_s - _from_s))
            if (const double now = depth(f); now > most) most = now, best_Hz = f;
        return best_Hz;
    }

private:
    struct Piece
    {
        double begin_s, end_s, power;
    };
    std::vector<Piece> _pieces;
    double _from_s, _to_s;
    double _mean = 0;
};
