#include "device/ArrayDevice.h"
#include "device/BoardDevice.h"
#include "device/DeviceUri.h"
#include "device/FieldCounters.h"
#include "device/GuardedDevice.h"
#include "device/HeldField.h"
#include "device/RecordingDevice.h"
#include "device/SimulatedArray.h"
#include "device/UsbArrayDevice.h"

#include <atomic>

namespace midair::device
{

namespace
{

/// `null:`: takes every field and holds it in memory.
class NullDevice : public ArrayDevice
{
public:
    explicit NullDevice(int transducers) : _held(transducers) {}

    bool send(const DriveSignal& signal) override
    {
        if (_muted || signal.size() != _held.transducers() ||
            signal.duty.size() != signal.phase.size())
        {
            _counters.countRefused();
            return false;
        }
        _held.replace(signal);
        _counters.countPlayed(steadySeconds());
        return true;
    }
    void silence() override { _held.clear(); }
    void setMuted(bool muted) override
    {
        _muted = muted;
        if (muted) _held.clear();
    }
    std::string status() const override { return "null: " + countersText(report()); }
    DeviceReport report() const override { return _counters.report(); }
    std::vector<std::complex<float>> played() const override { return _held.activations(); }

private:
    HeldField _held;
    FieldCounters _counters;
    std::atomic<bool> _muted{false};
};

void checkLayout(const DeviceLayout& layout)
{
    if (layout.transducers < 1)
        throw DeviceError("device layout: " + std::to_string(layout.transducers) +
                          " transducers, should be at least 1");
    if (layout.board.empty()) return;
    if (layout.board.size() != static_cast<std::size_t>(layout.transducers))
        throw DeviceError("device layout: board numbers for " +
                          std::to_string(layout.board.size()) + " transducers, should be for all " +
                          std::to_string(layout.transducers));
    if (layout.board.front() != 0)
        throw DeviceError("device layout: the first board is " +
                          std::to_string(layout.board.front()) + ", should be 0");
    int before = 0;
    for (const int board : layout.board)
    {
        if (board < before || board > before + 1)
            throw DeviceError("device layout: board " + std::to_string(board) + " follows board " +
                              std::to_string(before) + ", should ascend from 0 without gaps");
        before = board;
    }
}

using Opener = std::unique_ptr<ArrayDevice> (*)(DeviceUri&, const DeviceLayout&);

std::unique_ptr<ArrayDevice> openSimulation(DeviceUri& uri, const DeviceLayout& layout)
{
    uri.rejectPath();
    const SimulatedArray::Options options = SimulatedArray::takeOptions(uri);
    uri.rejectUnknown();
    return std::make_unique<SimulatedArray>(layout, options);
}

std::unique_ptr<ArrayDevice> openUsb(DeviceUri& uri, const DeviceLayout& layout)
{
    const UsbArrayDevice::Options options = UsbArrayDevice::takeOptions(uri);
    uri.rejectUnknown();
    return std::make_unique<UsbArrayDevice>(layout, options);
}

std::unique_ptr<ArrayDevice> openNull(DeviceUri& uri, const DeviceLayout& layout)
{
    uri.rejectPath();
    uri.rejectUnknown();
    return std::make_unique<NullDevice>(layout.transducers);
}

std::unique_ptr<ArrayDevice> openRecording(DeviceUri& uri, const DeviceLayout& layout)
{
    uri.requirePath("a file");
    uri.rejectUnknown();
    return std::make_unique<RecordingDevice>(uri.path(), layout.transducers);
}

std::unique_ptr<ArrayDevice> openSerialBoard(DeviceUri& uri, const DeviceLayout& layout)
{
    uri.requirePath("a serial port");
    const int baud = static_cast<int>(
        uri.takeNumber("baud", uri.scheme() == "ultraino" ? 115200 : 230400, 9600, 921600));
    uri.rejectUnknown();
    const std::string port = uri.path();
    return std::make_unique<BoardDevice>(
        uri.text(),
        makeBoardCodec(uri.scheme()),
        layout.transducers,
        [port, baud](const std::vector<std::uint8_t>& lastWill)
        { return std::make_unique<SerialPort>(port, baud, lastWill); });
}

std::unique_ptr<ArrayDevice> openFifoBoard(DeviceUri& uri, const DeviceLayout& layout)
{
    uri.rejectUnknown();
    const std::string serial = uri.path();
    return std::make_unique<BoardDevice>(uri.text(),
                                         makeBoardCodec(uri.scheme()),
                                         layout.transducers,
                                         [serial](const std::vector<std::uint8_t>&)
                                         { return std::make_unique<FtdiFifo>(serial); });
}

struct Scheme
{
    const char* name;
    Opener open;
    const char* text;
};

constexpr Scheme kSchemes[] = {
    {"sim",
     openSimulation,
     "sim:                    a virtual array; ?drop=0.01&unplug_at=2s&.. rehearses faults"},
    {"usb", openUsb, "usb: or usb:SERIAL      the array over USB; ?wait=yes begins without it"},
    {"sonicsurface",
     openSerialBoard,
     "sonicsurface:TTY        an open board of 256 on a serial port"},
    {"ultraino",
     openSerialBoard,
     "ultraino:TTY            open boards of 64, chained, on a serial port"},
    {"openmpd", openFifoBoard, "openmpd:SERIAL          an open board of 256 behind an FT232H"},
    {"record", openRecording, "record:FILE             writes every field into a file"},
    {"null", openNull, "null:                   takes every field"},
};

std::unique_ptr<ArrayDevice>
openOne(const std::string& text, const DeviceLayout& layout, const SafetyLimits& limits)
{
    DeviceUri uri(text);
    const SafetyLimits strict = takeLimits(uri, limits);
    std::string known;
    for (const Scheme& scheme : kSchemes)
    {
        if (uri.scheme() == scheme.name)
            return std::make_unique<GuardedDevice>(
                scheme.open(uri, layout), strict, layout.transducers);
        known += std::string(known.empty() ? "" : ", ") + scheme.name + ":";
    }
    throw uri.error("unknown kind \"" + uri.scheme() + ":\"; known are " + known);
}

} // namespace

std::unique_ptr<ArrayDevice> openDevice(const std::string& uri, const DeviceLayout& layout)
{
    return openLimitedDevice(uri, layout, {});
}

std::unique_ptr<ArrayDevice>
openLimitedDevice(const std::string& uri, const DeviceLayout& layout, const SafetyLimits& limits)
{
    checkLayout(layout);
    return openOne(uri, layout, limits);
}

std::string deviceKinds()
{
    std::string text;
    for (const Scheme& scheme : kSchemes)
        text += std::string(scheme.text) + "\n";
    return text;
}

} // namespace midair::device
