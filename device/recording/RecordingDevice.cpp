#include "device/recording/RecordingDevice.h"

#include <cerrno>
#include <system_error>

#include <spdlog/spdlog.h>
#include <unistd.h>

namespace midair::device
{

RecordingDevice::RecordingDevice(const std::string& file, int transducers, bool overwrite) :
    _file(file),
    _opened(recording::openForWriting(file, overwrite)),
    _held(transducers),
    _writer(transducers),
    _start(std::chrono::steady_clock::now())
{
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    write(_writer.header(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count()));
    if (!_failure.empty()) throw DeviceError("recording \"" + file + "\": " + _failure);
}

RecordingDevice::~RecordingDevice()
{
    std::lock_guard<std::mutex> lock(_mutex);
    silenceLocked();
    if (_failure.empty()) write(_writer.mark(elapsed_ns(), recording::Kind::END));
}

std::uint64_t RecordingDevice::elapsed_ns() const
{
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() -
                                                                _start)
        .count();
}

bool RecordingDevice::write(const std::vector<std::uint8_t>& bytes)
{
    std::size_t done = 0;
    while (done < bytes.size())
    {
        const ssize_t count =
            ::write(_opened.descriptor(), bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0)
        {
            _failure = std::string("writing failed after ") + std::to_string(_fields) +
                       " fields: " + std::generic_category().message(errno);
            spdlog::error("recording \"{}\": {}", _file, _failure);
            return false;
        }
        done += static_cast<std::size_t>(count);
    }
    _bytes += bytes.size();
    return true;
}

bool RecordingDevice::send(const DriveSignal& signal)
{
    const double sentAt_s = base::steadySeconds();
    std::lock_guard<std::mutex> lock(_mutex);
    const bool whole =
        signal.size() == _held.transducers() && signal.duty.size() == signal.phase.size();
    if (!whole || !_failure.empty())
    {
        _counters.countRefused();
        return false;
    }
    if (!write(_writer.field(elapsed_ns(), signal)))
    {
        _held.clear();
        _counters.countRefused();
        _counters.change(
            [&](DeviceReport& report)
            {
                report.state = DeviceState::LOST;
                ++report.faults;
                report.message = _failure;
            });
        return false;
    }
    ++_fields;
    _held.replace(signal);
    _counters.countPlayed(sentAt_s);
    return true;
}

void RecordingDevice::silenceLocked()
{
    if (_failure.empty() && !_held.silent())
        write(_writer.mark(elapsed_ns(), recording::Kind::SILENCE));
    _held.clear();
}

void RecordingDevice::silence()
{
    std::lock_guard<std::mutex> lock(_mutex);
    silenceLocked();
}

std::string RecordingDevice::status() const
{
    std::lock_guard<std::mutex> lock(_mutex);
    if (!_failure.empty()) return "record:" + _file + ": " + _failure;
    return "record:" + _file + ": " + std::to_string(_fields) + " fields, " +
           std::to_string(_bytes) + " bytes";
}

} // namespace midair::device
