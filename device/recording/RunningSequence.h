#pragma once

#include "device/drive/DriveSequence.h"

#include <cstdint>

namespace midair::device::recording
{

/// A sequence on the clock of a recording: tells which steps have begun by a time, and which of
/// them are not in the file yet.
class RunningSequence
{
public:
    /// Steps that are later than this in the file are left out, s.
    static constexpr double kMostBacklog_s = 2;

    RunningSequence() = default; ///< no sequence: converts to false
    /// \a sequence has at least one signal. Its first step begins at \a start_ns.
    RunningSequence(const DriveSequence& sequence, std::uint64_t start_ns);

    explicit operator bool() const { return !_sequence.signals.empty(); }

    std::uint64_t step() const { return _next; } ///< the first step not in the file, from 0
    void advance() { ++_next; }
    /// start_ns + step/rate, rounded to the nanosecond.
    std::uint64_t time_ns(std::uint64_t step) const;
    const DriveSignal& signal(std::uint64_t step) const;
    /// The number of steps that have begun by \a time_ns, which must not be before the start.
    std::uint64_t begun(std::uint64_t time_ns) const;
    /// Skips the steps that are more than kMostBacklog_s late at \a time_ns; returns their number.
    std::uint64_t leaveOutLate(std::uint64_t time_ns);

private:
    DriveSequence _sequence;
    std::uint64_t _start_ns = 0;
    std::uint64_t _next = 0;
};

} // namespace midair::device::recording
