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
        const base::Lock lock(_mutex);
        _stop = true;
    }
    _wake.notifyAll();
    _thread.join();
}

void PlayingDevice::run()
{
    {
        base::Lock lock(_mutex);
        while (playOnce(lock) && _options.loop && _fields > 0)
        {
        }
        _finished = true;
    }
    _device->silence();
}

void PlayingDevice::leaveOutDead(DriveSignal& signal) const
{
    for (const int i : _options.dead)
        if (i >= 0 && static_cast<std::size_t>(i) < signal.duty.size())
            signal.duty[static_cast<std::size_t>(i)] = 0;
}

bool PlayingDevice::playOnce(base::Lock& lock)
{
    recording::Reader reader(_show.bytes(), _show.file());
    recording::Entry entry;
    const double start_s = base::steadySeconds();
    recording::Stop stop = reader.next(entry);
    for (; stop == recording::Stop::MORE; stop = reader.next(entry))
    {
        _time_s = static_cast<double>(entry.time_ns) * 1e-9;
        const double due_s = start_s + _time_s / _options.speed;
        while (!_stop && _wake.waitUntil_s(lock, due_s))
        {
        }
        if (_stop) return false;
        _worstLateness_s = std::max(_worstLateness_s, base::steadySeconds() - due_s);
        {
            const base::Unlocked unlocked(_mutex);
            leaveOutDead(entry.signal);
            if (entry.kind == recording::Kind::FIELD)
                _device->sendUnled(entry.signal);
            else
                _device->silence();
        }
        _fields += entry.kind == recording::Kind::FIELD ? 1 : 0;
    }
    if (stop != recording::Stop::END && _ending.empty())
    {
        _isDamaged = stop == recording::Stop::CORRUPT;
        const std::size_t bytes = _show.bytes().size();
        const std::size_t left = bytes - reader.offset();
        if (_isDamaged)
            _ending = fmt::format("the file is damaged at byte {} of {}, after {} whole fields",
                                  reader.offset(),
                                  bytes,
                                  _fields);
        else
            _ending = "ended without its last mark" +
                      (left == 0 ? "" : fmt::format("; of one more there are {} bytes", left));
        deviceLog().warn("recording \"{}\": {} fields, {}", _show.file(), _fields, _ending);
    }
    return true;
}

void PlayingDevice::silence()
{
    {
        const base::Lock lock(_mutex);
        _stop = true;
    }
    _wake.notifyAll();
    // At once; run() repeats it when it ends, for a field that it was sending.
    _device->silence();
}

bool PlayingDevice::finished() const
{
    const base::Lock lock(_mutex);
    return _finished;
}

std::string PlayingDevice::ending() const
{
    const base::Lock lock(_mutex);
    return _ending;
}

DeviceReport PlayingDevice::report() const
{
    DeviceReport report = _device->report();
    const base::Lock lock(_mutex);
    if (!_finished || !_isDamaged) return report;
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
    const base::Lock lock(_mutex);
    return _worstLateness_s;
}

std::string PlayingDevice::status() const
{
    const std::string device = _device->status();
    const base::Lock lock(_mutex);
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
