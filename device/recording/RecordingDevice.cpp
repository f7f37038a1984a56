#include "device/recording/RecordingDevice.h"

#include "device/DeviceLog.h"
#include "device/drive/DriveEncoder.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <system_error>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

namespace midair::device
{

namespace
{

constexpr std::size_t kMostSequenceBytes = std::size_t(64) << 20;
constexpr std::size_t kMostSequenceFields = 4096;
constexpr double kHeartbeat_s = 0.05;

} // namespace

RecordingDevice::RecordingDevice(const std::string& file,
                                 int transducers,
                                 recording::Before before) :
    _file(file),
    _opened(recording::openForWriting(file, before)),
    _held(transducers),
    _start_s(base::steadySeconds()),
    _writer(transducers)
{
    if (before == recording::Before::CONTINUED && goOn()) return;
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    write(_writer.header(std::chrono::duration_cast<std::chrono::nanoseconds>(now).count()));
    if (!_failure.empty()) throw DeviceError("recording \"" + file + "\": " + _failure);
}

// Returns false if there is no recording to continue.
bool RecordingDevice::goOn()
{
    const auto ended = recording::endOf(_opened.descriptor());
    if (!ended) return false;
    const std::string name = "recording \"" + _file + "\": ";
    if (ended->transducers != _held.transducers())
        throw DeviceError(fmt::format(
            "{}was begun for {} transducers, but the array now has {}; choose another name",
            name,
            ended->transducers,
            _held.transducers()));
    const auto end = static_cast<off_t>(ended->bytes);
    if (::ftruncate(_opened.descriptor(), end) != 0 ||
        ::lseek(_opened.descriptor(), end, SEEK_SET) != end)
        throw DeviceError(name + "can't be continued: " + std::generic_category().message(errno));
    _start_s = ended->start_s;
    _bytes = ended->bytes;
    _fields = ended->fields;
    _writer.forget();
    return true;
}

RecordingDevice::~RecordingDevice()
{
    {
        const base::Lock lock(_mutex);
        _closing = true;
    }
    _wake.notifyAll();
    if (_thread.joinable()) _thread.join();
    const base::Lock lock(_mutex);
    silenceLocked();
    const recording::Ended ended{_held.transducers(), _fields, _bytes, _start_s};
    if (_failure.empty()) write(_writer.mark(elapsed_ns(), recording::Kind::END));
    recording::noteEnd(_opened.descriptor(), ended);
}

std::uint64_t RecordingDevice::elapsed_ns() const
{
    return static_cast<std::uint64_t>((base::steadySeconds() - _start_s) * 1e9);
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
            _failure = fmt::format("writing failed after {} fields: {}",
                                   _fields,
                                   std::generic_category().message(errno));
            deviceLog().error("recording \"{}\": {}", _file, _failure);
            _running = {};
            _held.clear();
            _counters.countLoss(_failure);
            return false;
        }
        done += static_cast<std::size_t>(count);
    }
    _bytes += bytes.size();
    return true;
}

bool RecordingDevice::writeField(std::uint64_t time_ns, const DriveSignal& signal)
{
    if (!write(_writer.field(time_ns, signal))) return false;
    ++_fields;
    return true;
}

void RecordingDevice::writeStepsUntil(std::uint64_t time_ns)
{
    if (!_running) return;
    const std::uint64_t late = _running.leaveOutLate(time_ns);
    if (late > 0)
        _counters.countFault(
            fmt::format("writing is too slow: {} steps of a sequence are left out", late));
    const std::uint64_t begun = _running.begun(time_ns);
    while (_running && _running.step() < begun)
    {
        const std::uint64_t step = _running.step();
        if (writeField(_running.time_ns(step), _running.signal(step))) _running.advance();
    }
}

void RecordingDevice::endSequence(std::uint64_t time_ns)
{
    writeStepsUntil(time_ns);
    _running = {};
}

bool RecordingDevice::send(const DriveSignal& signal)
{
    const double sentAt_s = base::steadySeconds();
    const base::Lock lock(_mutex);
    const bool whole = signal.fits(_held.transducers());
    const std::uint64_t now_ns = elapsed_ns();
    if (whole) endSequence(now_ns);
    if (!whole || !_failure.empty() || !writeField(now_ns, signal))
    {
        _counters.countRefused();
        return false;
    }
    _held.replace(signal);
    _counters.countPlayed(sentAt_s);
    return true;
}

bool RecordingDevice::sendSequence(const DriveSequence& sequence)
{
    const double sentAt_s = base::steadySeconds();
    const base::Lock lock(_mutex);
    const bool whole =
        sequence.fits(_held.transducers()) &&
        sequence.signals.size() <= static_cast<std::size_t>(ability().sequenceFields);
    const std::uint64_t now_ns = elapsed_ns();
    if (whole) endSequence(now_ns);
    if (!whole || !_failure.empty() || !writeField(now_ns, sequence.signals.front()))
    {
        _counters.countRefused();
        return false;
    }
    _held.replace(sequence.signals.front());
    _counters.countPlayed(sentAt_s);
    if (sequence.signals.size() == 1) return true; // held like a single field
    _running = {sequence, now_ns};
    _running.advance();
    if (!_thread.joinable()) _thread = std::thread([this] { run(); });
    _wake.notifyAll();
    return true;
}

void RecordingDevice::run()
{
    base::Lock lock(_mutex);
    while (!_closing)
    {
        const bool isRunning = bool(_running);
        const double until_s = base::steadySeconds() + kHeartbeat_s;
        while (!_closing && isRunning && _wake.waitUntil_s(lock, until_s))
        {
        }
        while (!_closing && !isRunning && !_running)
            _wake.wait(lock);
        writeStepsUntil(elapsed_ns());
    }
}

void RecordingDevice::silenceLocked()
{
    const std::uint64_t now_ns = elapsed_ns();
    const bool sounds = _running || !_held.silent();
    endSequence(now_ns);
    if (_failure.empty() && sounds) write(_writer.mark(now_ns, recording::Kind::SILENCE));
    _held.clear();
}

void RecordingDevice::silence()
{
    const base::Lock lock(_mutex);
    silenceLocked();
}

DriveAbility RecordingDevice::ability() const
{
    DriveAbility ability;
    const std::size_t bytes = 2 * static_cast<std::size_t>(_held.transducers());
    ability.sequenceFields = static_cast<int>(
        std::clamp(kMostSequenceBytes / bytes, std::size_t(1), kMostSequenceFields));
    return ability;
}

std::vector<std::complex<float>> RecordingDevice::played() const
{
    const base::Lock lock(_mutex);
    if (!_running) return _held.activations();
    std::vector<std::complex<float>> q;
    decode(_running.signal(_running.begun(elapsed_ns()) - 1), q);
    return q;
}

std::string RecordingDevice::status() const
{
    const base::Lock lock(_mutex);
    if (!_failure.empty()) return "record:" + _file + ": " + _failure;
    return fmt::format("record:{}: {} fields, {} bytes", _file, _fields, _bytes);
}

recording::RunningSequence::RunningSequence(const DriveSequence& sequence, std::uint64_t start_ns) :
    _sequence(sequence),
    _start_ns(start_ns)
{
}

std::uint64_t recording::RunningSequence::time_ns(std::uint64_t step) const
{
    const double passed_ns = static_cast<double>(step) * (1e9 / _sequence.rate_Hz);
    return _start_ns + static_cast<std::uint64_t>(std::llround(passed_ns));
}

const DriveSignal& recording::RunningSequence::signal(std::uint64_t step) const
{
    return _sequence.signals[static_cast<std::size_t>(step % _sequence.signals.size())];
}

std::uint64_t recording::RunningSequence::begun(std::uint64_t time_ns) const
{
    const double passed_s = static_cast<double>(time_ns - _start_ns) * 1e-9;
    std::uint64_t steps = static_cast<std::uint64_t>(passed_s * _sequence.rate_Hz) + 1;
    // The product may be rounded past a step's start in either direction.
    while (this->time_ns(steps) <= time_ns)
        ++steps;
    while (steps > 1 && this->time_ns(steps - 1) > time_ns)
        --steps;
    return steps;
}

std::uint64_t recording::RunningSequence::leaveOutLate(std::uint64_t time_ns)
{
    const std::uint64_t steps = begun(time_ns);
    const auto most = static_cast<std::uint64_t>(kMostBacklog_s * _sequence.rate_Hz) + 1;
    if (steps <= _next + most) return 0;
    const std::uint64_t late = steps - most - _next;
    _next += late;
    return late;
}

} // namespace midair::device
