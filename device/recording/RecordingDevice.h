#pragma once

#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/HeldField.h"
#include "device/recording/Recording.h"
#include "device/recording/RecordingFile.h"

#include <chrono>
#include <mutex>

namespace midair::device
{

/// `record:FILE`: writes every field with its time into a file (Recording.h), for `play:` and for tests.
/// A field goes to the operating system in one write before send() returns, so a crash costs at most the last one.
class RecordingDevice : public ArrayDevice
{
public:
    /// Replaces \a file where that is a recording, or with \a overwrite any regular file; throws DeviceError where it can't be
    /// written or must not be (RecordingFile.h).
    RecordingDevice(const std::string& file, int transducers, bool overwrite = false);
    ~RecordingDevice() override; ///< writes silence and the end mark

    RecordingDevice(const RecordingDevice&) = delete;
    RecordingDevice& operator=(const RecordingDevice&) = delete;

    bool send(const DriveSignal& signal) override;
    void silence() override;
    std::string status() const override;
    DeviceReport report() const override { return _counters.report(); }
    std::vector<std::complex<float>> played() const override { return _held.activations(); }

private:
    std::uint64_t elapsed_ns() const;
    bool write(const std::vector<std::uint8_t>& bytes); ///< with _mutex held
    void silenceLocked();

    const std::string _file;
    const recording::OpenFile _opened;
    HeldField _held;
    mutable std::mutex _mutex;
    recording::Writer _writer;
    std::chrono::steady_clock::time_point _start;
    FieldCounters _counters;
    std::uint64_t _fields = 0;
    std::uint64_t _bytes = 0;
    std::string _failure;
};

} // namespace midair::device
