#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/HeldField.h"
#include "device/recording/Recording.h"
#include "device/recording/RecordingFile.h"
#include "device/recording/RunningSequence.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace midair::device
{

/// `record:FILE`: writes every field with its time into a file (Recording.h), for `play:` and for
/// tests. A field is handed to the operating system in one write before send() returns, so a crash
/// loses at most the last one.
///
/// A sequence is written step by step, each with the time at which it would be played: start +
/// k/rate, to the nanosecond. A thread that wakes up every 50 ms writes the steps that have begun;
/// so does every call that ends the sequence. What could not be written, on a full disk say, is a
/// loss of the device: it refuses all fields from then on. Steps that are more than two seconds
/// late, on a slow disk, are left out, which counts as a fault with a message.
class RecordingDevice : public ArrayDevice
{
public:
    /// \a before: what happens to the recording that is in \a file. One that is continued has the
    /// same clock and number of transducers, and goes on after a pause; throws DeviceError, and
    /// leaves it, for another number, and if the file can't be written or must not be
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
    bool goOn();
    std::uint64_t elapsed_ns() const;
    // These are called with _mutex held.
    bool write(const std::vector<std::uint8_t>& bytes);
    bool writeField(std::uint64_t time_ns, const DriveSignal& signal);
    void writeStepsUntil(std::uint64_t time_ns);
    void endSequence(std::uint64_t time_ns);
    void silenceLocked();
    void run();

    const std::string _file;
    const recording::OpenFile _opened;
    HeldField _held;
    mutable std::mutex _mutex;
    std::condition_variable _wake;
    recording::Writer _writer;
    std::chrono::steady_clock::time_point _start;
    FieldCounters _counters;
    recording::RunningSequence _running; ///< false while a field is held
    std::uint64_t _fields = 0;
    std::uint64_t _bytes = 0; ///< of whole records
    std::string _failure;
    bool _closing = false;
    std::thread _thread; ///< writes the steps of sequences; started by the first one
};

} // namespace midair::device
