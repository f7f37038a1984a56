#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/recording/Recording.h"
#include "device/recording/RecordingFile.h"
#include "haptics/base/threads/Mutex.h"

#include <cstdint>
#include <string>
#include <thread>

namespace midair::device
{

namespace recording
{

/// A sequence on the clock of a recording: computes which steps have begun by a time, and which are
/// not in the file yet.
class RunningSequence
{
public:
    /// Steps that are later than this are left out of the file, s.
    static constexpr double kMostBacklog_s = 2;

    RunningSequence() = default; ///< no sequence: converts to false
    /// \a sequence has at least one signal. Its first step begins at \a start_ns.
    RunningSequence(const DriveSequence& sequence, std::uint64_t start_ns);

    explicit operator bool() const { return !_sequence.signals.empty(); }

    std::uint64_t step() const { return _next; } ///< first step not in the file, from 0
    void advance() { ++_next; }
    /// start_ns + step/rate, rounded to the nanosecond.
    std::uint64_t time_ns(std::uint64_t step) const;
    const DriveSignal& signal(std::uint64_t step) const;
    /// Returns the number of steps begun by \a time_ns, which must not be before the start.
    std::uint64_t begun(std::uint64_t time_ns) const;
    /// Skips the steps that are more than kMostBacklog_s late at \a time_ns; returns their number.
    std::uint64_t leaveOutLate(std::uint64_t time_ns);

private:
    DriveSequence _sequence;
    std::uint64_t _start_ns = 0;
    std::uint64_t _next = 0;
};

} // namespace recording

/// `record:FILE`: writes every field with its time into a file (Recording.h), for `play:` and for
/// tests. Each field is one write to the operating system before send() returns, so a crash loses
/// at most the last one.
///
/// A sequence is written step by step, each with its playing time: start + k/rate, to the
/// nanosecond. A thread that wakes up every 50 ms, and every call that ends the sequence, writes
/// the steps that have begun. A write error, such as a full disk, is a loss of the device: it
/// refuses all fields from then on. Steps that are more than two seconds late, on a slow disk, are
/// left out, which counts as a fault with a message.
class RecordingDevice : public ArrayDevice
{
public:
    /// \a before: what happens to an existing recording in \a file. A continued one has the same
    /// clock and number of transducers, and resumes after a pause. Throws DeviceError, without
    /// changing the file, for another number, and if the file can't or must not be written
    /// (RecordingFile.h).
    RecordingDevice(const std::string& file,
                    int transducers,
                    recording::Before before = recording::Before::REPLACED);
    ~RecordingDevice() override; ///< writes silence and the end mark

    RecordingDevice(const RecordingDevice&) = delete;
    RecordingDevice& operator=(const RecordingDevice&) = delete;

    bool send(const DriveSignal& signal) override;
    bool sendSequence(const DriveSequence& sequence) override;
    void silence() override;
    std::string status() const override;
    DeviceReport report() const override { return _counters.report(); }
    DriveAbility ability() const override;
    std::vector<std::complex<float>> played() const override;

private:
    bool goOn() MIDAIR_REQUIRES(_mutex);
    std::uint64_t elapsed_ns() const;
    bool write(const std::vector<std::uint8_t>& bytes) MIDAIR_REQUIRES(_mutex);
    bool writeField(std::uint64_t time_ns, const DriveSignal& signal) MIDAIR_REQUIRES(_mutex);
    void writeStepsUntil(std::uint64_t time_ns) MIDAIR_REQUIRES(_mutex);
    void endSequence(std::uint64_t time_ns) MIDAIR_REQUIRES(_mutex);
    void silenceLocked() MIDAIR_REQUIRES(_mutex);
    void run() MIDAIR_EXCLUDES(_mutex);

    const std::string _file;
    const recording::OpenFile _opened;
    HeldField _held;         ///< any thread
    FieldCounters _counters; ///< any thread
    double _start_s;         ///< base::steadySeconds(); written by the constructor alone
    mutable base::Mutex _mutex;
    base::Condition _wake;
    recording::Writer _writer MIDAIR_GUARDED_BY(_mutex);
    recording::RunningSequence _running MIDAIR_GUARDED_BY(_mutex); ///< false while a field is held
    std::uint64_t _fields MIDAIR_GUARDED_BY(_mutex) = 0;
    std::uint64_t _bytes MIDAIR_GUARDED_BY(_mutex) = 0; ///< of whole records
    std::string _failure MIDAIR_GUARDED_BY(_mutex);
    bool _closing MIDAIR_GUARDED_BY(_mutex) = false;
    /// Writes the steps of sequences; the first one starts it, under _mutex.
    std::thread _thread;
};

} // namespace midair::device
