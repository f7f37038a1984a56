#include "device/PlayingDevice.h"

#include "device/DeviceUri.h"
#include "device/FieldCounters.h"
#include "device/Recording.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>

#include <spdlog/spdlog.h>

namespace midair::device
{

PlayingDevice::PlayingDevice(const std::string& file,
                             int transducers,
                             const Options& options,
                             std::unique_ptr<ArrayDevice> device) :
    _file(file),
    _transducers(transducers),
    _options(options),
    _device(std::move(device))
{
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw DeviceError("recording \"" + file +
                          "\": can't be read: " + std::generic_category().message(errno));
    _bytes.assign(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    const recording::Reader reader(_bytes.data(), _bytes.size(), file);
    if (reader.transducers() != transducers)
        throw DeviceError("recording \"" + file + "\": was made for " +
                          std::to_string(reader.transducers()) +
                          " transducers, but the array has " + std::to_string(transducers));
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

bool PlayingDevice::playOnce(std::unique_lock<std::mutex>& lock)
{
    recording::Reader reader(_bytes.data(), _bytes.size(), _file);
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
        if (entry.kind == recording::Kind::FIELD)
            _device->send(entry.signal);
        else
            _device->silence();
        lock.lock();
        _fields += entry.kind == recording::Kind::FIELD ? 1 : 0;
    }
    if (stop != recording::Stop::END && _ending.empty())
    {
        _ending = std::string(stop == recording::Stop::TRUNCATED ? "the file breaks off"
                                                                 : "the file is damaged") +
                  " at byte " + std::to_string(reader.offset()) + " of " +
                  std::to_string(_bytes.size()) + ", after " + std::to_string(_fields) +
                  " whole fields";
        spdlog::warn("recording \"{}\": {}", _file, _ending);
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
    _device
        ->silence(); // at once; run() does so again when it ends, for a field that was just on its way
}

bool PlayingDevice::finished() const
{
    std::lock_guard<std::mutex> lock(_mutex);
    return _finished;
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
    return "play:" + _file + ": " +
           (_finished ? "at the end" : "at " + shortNumber(_time_s) + " s") + ", " +
           std::to_string(_fields) + " fields" + (_ending.empty() ? "" : "; " + _ending) + " -> " +
           device;
}

} // namespace midair::device
