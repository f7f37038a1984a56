#include "device/recording/PlayingDevice.h"

#include "device/DeviceLog.h"
#include "device/FieldCounters.h"
#include "device/recording/Recording.h"

#include <algorithm>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device
{

PlayingDevice::PlayingDevice(recording::Show show,
                             const Options& options,
                             std::unique_ptr<ArrayDevice> device) :
    _show(std::move(show)),
    _options(options),
    _device(std::move(device))
{
    _thread = std::thread([this] { run(); });
}

PlayingDevice::~PlayingDevice()
{
    {
        std::lock_guard<std::mutex> lock(_mutex);
        _stop = true;
    }
    _wake.notify_all();
    _thread.join();
}

void PlayingDevice::run()
{
    std::unique_lock<std::mutex> lock(_mutex);
    do
    {
        if (!playOnce(lock)) break;
    } while (_options.loop && _fields > 0);
    _finished = true;
    lock.unlock();
    _device->silence();
}

void PlayingDevice::leaveOutDead(DriveSignal& signal) const
{
    for (const int i : _options.dead)
        if (i >= 0 && static_cast<std::size_t>(i) < signal.duty.size())
            signal.duty[static_cast<std::size_t>(i)] = 0;
}

bool PlayingDevice::playOnce(std::unique_lock<std::mutex>& lock)
{
    recording::Reader reader(_show.bytes(), _show.file());
    recording::Entry entry;
    const auto start = std::chrono::steady_clock::now();
    recording::Stop stop = reader.next(entry);
    for (; stop == recording::Stop::MORE; stop = reader.next(entry))
    {
        _time_s = static_cast<double>(entry.time_ns) * 1e-9;
        const auto due = start + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                     std::chrono::duration<double>(_time_s / _options.speed));
        if (_wake.wait_until(lock, due, [&] { return _stop; })) return false;
        const std::chrono::duration<double> late = std::chrono::steady_clock::now() - due;
        _worstLateness_s = std::max(_worstLateness_s, late.count());
        lock.unlock();
        leaveOutDead(entry.signal);
        if (entry.kind == recording::Kind::FIELD)
            _device->sendUnled(entry.signal);
        else
            _device->silence();
        lock.lock();
        _fields += entry.kind == recording::Kind::FIELD ? 1 : 0;
    }
    if (stop != recording::Stop::END && _ending.empty())
    {
        _ending = fmt::format("the file {} at byte {} of {}, after {} whole fields",
                              stop == recording::Stop::TRUNCATED ? "breaks off" : "is damaged",
                              reader.offset(),
                              _show.bytes().size(),
                              _fields);
        deviceLog().warn("recording \"{}\": {}", _show.file(), _ending);
    }
    return true;
}

bool PlayingDevice::send(const DriveSignal&)
{
    return false;
}

void PlayingDevice::silence()
{
    {
        std::lock_guard<std::mutex> lock(_mutex);
        _stop = true;
    }
    _wake.notify_all();
    // At once; run() does it again when it ends, for a field that it was just sending.
    _device->silence();
}

bool PlayingDevice::finished() const
{
    std::lock_guard<std::mutex> lock(_mutex);
    return _finished;
}

std::string PlayingDevice::ending() const
{
    std::lock_guard<std::mutex> lock(_mutex);
    return _ending;
}

DeviceReport PlayingDevice::report() const
{
    DeviceReport report = _device->report();
    std::lock_guard<std::mutex> lock(_mutex);
    if (!_finished || _ending.empty()) return report;
    report.state = DeviceState::LOST;
    ++report.faults;
    report.message = "recording \"" + _show.file() + "\": " + _ending;
    return report;
}

DriveAbility PlayingDevice::ability() const
{
    DriveAbility ability = _device->ability();
    ability.sequenceFields = 0;
    return ability;
}

double PlayingDevice::worstLateness_s() const
{
    std::lock_guard<std::mutex> lock(_mutex);
    return _worstLateness_s;
}

std::string PlayingDevice::status() const
{
    const std::string device = _device->status();
    std::lock_guard<std::mutex> lock(_mutex);
    const std::string dead =
        _options.dead.empty() ? ""
                              : fmt::format("; {} dead transducers left out", _options.dead.size());
    return fmt::format("play:{}: {}, {} fields{}{} -> {}",
                       _show.file(),
                       _finished ? "at the end" : fmt::format("at {:g} s", _time_s),
                       _fields,
                       _ending.empty() ? "" : "; " + _ending,
                       dead,
                       device);
}

} // namespace midair::device
