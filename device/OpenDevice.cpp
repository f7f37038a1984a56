#include "device/ArrayDevice.h"
#include "device/DeviceUri.h"
#include "device/HeldField.h"
#include "device/RecordingDevice.h"

#include <algorithm>

namespace midair::device
{

namespace
{

/// `null:` takes every field and `sim:` gives back what it plays; both hold it in memory.
class MemoryDevice : public ArrayDevice
{
public:
    MemoryDevice(std::string name, int transducers) : _name(std::move(name)), _held(transducers) {}

    bool send(const DriveSignal& signal) override
    {
        if (signal.size() != _held.transducers() || signal.duty.size() != signal.phase.size())
            return false;
        _held.replace(signal);
        return true;
    }
    void silence() override { _held.clear(); }
    std::string status() const override
    {
        return _name + ": " + std::to_string(_held.transducers()) + " transducers, " +
               (_held.silent() ? "silent" : "playing");
    }
    std::vector<std::complex<float>> played() const override { return _held.activations(); }

private:
    const std::string _name;
    HeldField _held;
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

struct Scheme
{
    const char* name;
    std::unique_ptr<ArrayDevice> (*open)(DeviceUri&, const DeviceLayout&);
};

std::unique_ptr<ArrayDevice> openMemory(DeviceUri& uri, const DeviceLayout& layout)
{
    uri.rejectPath();
    uri.rejectUnknown();
    return std::make_unique<MemoryDevice>(uri.text(), layout.transducers);
}

std::unique_ptr<ArrayDevice> openRecording(DeviceUri& uri, const DeviceLayout& layout)
{
    uri.requirePath("a file");
    uri.rejectUnknown();
    return std::make_unique<RecordingDevice>(uri.path(), layout.transducers);
}

constexpr Scheme kSchemes[] = {
    {"sim", openMemory}, {"record", openRecording}, {"null", openMemory}};

} // namespace

std::unique_ptr<ArrayDevice> openDevice(const std::string& text, const DeviceLayout& layout)
{
    checkLayout(layout);
    DeviceUri uri(text);
    std::string known;
    for (const Scheme& scheme : kSchemes)
    {
        if (uri.scheme() == scheme.name) return scheme.open(uri, layout);
        known += std::string(known.empty() ? "" : ", ") + scheme.name + ":";
    }
    throw uri.error("unknown kind \"" + uri.scheme() + ":\"; known are " + known);
}

} // namespace midair::device
