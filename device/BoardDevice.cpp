#include "device/BoardDevice.h"

#include <algorithm>

#include <spdlog/spdlog.h>

namespace midair::device
{

namespace
{

constexpr double kReconnect_s = 0.25;
constexpr double kFarewell_s = 0.5;

} // namespace

BoardDevice::BoardDevice(const std::string& name,
                         std::unique_ptr<BoardCodec> codec,
                         int transducers,
                         Open open) :
    _name(name),
    _codec(std::move(codec)),
    _transducers(transducers),
    _open(std::move(open))
{
    if (!_codec->takes(transducers))
        throw DeviceError("device \"" + name + "\": a " + _codec->name() + " has " +
                          _codec->takesText() + ", but the array has " +
                          std::to_string(transducers));
    _codec->appendSilence(_silentFrame, transducers);
    _playing.phase.assign(transducers, 0);
    _playing.duty.assign(transducers, 0);
    connect();
    _ready = true;
    _thread = std::thread([this] { run(); });
}

BoardDevice::~BoardDevice()
{
    {
        std::unique_lock<std::mutex> lock(_mutex);
        silenceLocked();
        _quiet.wait_for(lock,
                        std::chrono::duration<double>(kFarewell_s),
                        [&] { return !_silenceWanted || !_ready; });
        _closing = true;
    }
    _wake.notify_all();
    _thread.join();
}

void BoardDevice::connect()
{
    std::unique_ptr<ByteSink> sink = _open(_silentFrame);
    std::vector<std::uint8_t> bytes;
    _codec->appendOpening(bytes);
    bytes.insert(bytes.end(), _silentFrame.begin(), _silentFrame.end());
    if (!sink->write(bytes)) throw DeviceError("device \"" + _name + "\": " + sink->error());
    _lineFree_s = steadySeconds() + static_cast<double>(bytes.size()) / _codec->bytesPerSecond();
    _sink = std::move(sink);
}

void BoardDevice::lose(std::string why)
{
    _sink.reset();
    _ready = false;
    _silenceWanted = false;
    std::fill(_playing.duty.begin(), _playing.duty.end(), std::uint8_t(0));
    const std::uint64_t dropped = _slotFull ? 1 : 0;
    _slotFull = false;
    _counters.change(
        [&](DeviceReport& report)
        {
            report.state = DeviceState::LOST;
            report.dropped += dropped;
            ++report.faults;
            report.message = why;
        });
    _quiet.notify_all();
    spdlog::error("{}: {}; silent until it is back", _name, why);
}

void BoardDevice::run()
{
    std::unique_lock<std::mutex> lock(_mutex);
    while (!_closing)
    {
        if (_sink == nullptr)
        {
            _wake.wait_for(
                lock, std::chrono::duration<double>(kReconnect_s), [&] { return _closing; });
            if (_closing) break;
            try
            {
                connect();
            }
            catch (const DeviceError&)
            {
                continue; // what is wrong was said when it was lost
            }
            _ready = true;
            _counters.change(
                [](DeviceReport& report)
                {
                    report.state = DeviceState::READY;
                    ++report.reconnects;
                });
            spdlog::info("{}: back, silent until the next field", _name);
            continue;
        }
        if (!writePaced(lock))
            _wake.wait(lock, [&] { return _slotFull || _silenceWanted || _closing; });
    }
}

// Waits until the line is free, since what is in the operating system's buffer can't be overtaken. False: nothing to do.
bool BoardDevice::writePaced(std::unique_lock<std::mutex>& lock)
{
    const bool fresh = _codec->restarts();
    const auto urgent = [&] { return (_silenceWanted && fresh) || _closing; };
    if (!_slotFull && !_silenceWanted) return false;
    const double wait_s = _lineFree_s - steadySeconds();
    if (wait_s > 0 && !urgent())
    {
        _wake.wait_for(lock, std::chrono::duration<double>(wait_s), urgent);
        return true;
    }
    const bool silent = _silenceWanted;
    const std::uint64_t epoch = _epoch;
    DriveSignal field;
    const double sentAt_s = _slotAt_s;
    _bytes.clear();
    if (silent)
        _bytes = _silentFrame;
    else
    {
        field = std::move(_slot);
        _slotFull = false;
        _codec->appendField(_bytes, field);
    }
    lock.unlock();
    if (silent && fresh) _sink->discard();
    const bool written = _sink->write(_bytes);
    lock.lock();
    _lineFree_s = steadySeconds() + static_cast<double>(_bytes.size()) / _codec->bytesPerSecond();
    if (!written)
    {
        if (!silent) _counters.change([](DeviceReport& report) { ++report.lost; });
        lose(_sink->error());
        return true;
    }
    if (silent && epoch == _epoch)
    {
        _silenceWanted = false;
        _quiet.notify_all();
    }
    if (!silent)
    {
        _counters.change(
            [&](DeviceReport& report)
            {
                ++report.played;
                report.lastHandedOver_s = steadySeconds();
                report.latency_s = report.lastHandedOver_s - sentAt_s;
            });
        if (epoch == _epoch) _playing = std::move(field);
    }
    return true;
}

bool BoardDevice::send(const DriveSignal& signal)
{
    std::lock_guard<std::mutex> lock(_mutex);
    const bool whole = signal.size() == _transducers && signal.duty.size() == signal.phase.size();
    if (!whole || !_ready || _closing)
    {
        _counters.countRefused();
        return false;
    }
    _counters.change(
        [&](DeviceReport& report)
        {
            ++report.sent;
            report.dropped += _slotFull ? 1 : 0;
        });
    _slot = signal;
    _slotAt_s = steadySeconds();
    _slotFull = true;
    _wake.notify_all();
    return true;
}

void BoardDevice::silenceLocked()
{
    const std::uint64_t dropped = _slotFull ? 1 : 0;
    _slotFull = false;
    _counters.change([&](DeviceReport& report) { report.dropped += dropped; });
    std::fill(_playing.duty.begin(), _playing.duty.end(), std::uint8_t(0));
    if (!_ready) return;
    ++_epoch;
    _silenceWanted = true;
    _wake.notify_all();
}

void BoardDevice::silence()
{
    std::lock_guard<std::mutex> lock(_mutex);
    silenceLocked();
}

DeviceReport BoardDevice::report() const
{
    std::lock_guard<std::mutex> lock(_mutex);
    DeviceReport report = _counters.report();
    report.pending = report.sent - report.played - report.dropped - report.lost - report.refused;
    return report;
}

std::string BoardDevice::status() const
{
    const DeviceReport now = report();
    return _name + ": " + (now.state == DeviceState::LOST ? "not there; " : "") +
           countersText(now) + " (the board does not answer)";
}

std::vector<std::complex<float>> BoardDevice::played() const
{
    std::vector<std::complex<float>> q;
    std::lock_guard<std::mutex> lock(_mutex);
    _codec->played(_playing, q);
    return q;
}

std::vector<std::complex<float>> BoardDevice::wouldPlay(const DriveSignal& signal) const
{
    std::vector<std::complex<float>> q;
    _codec->played(signal, q);
    return q;
}

} // namespace midair::device
