#include "device/ArrayDevice.h"
#include "device/DeviceUri.h"
#include "device/limits/GuardedDevice.h"
#include "device/opening/MultiDevice.h"
#include "device/recording/Recording.h"
#include "device/simulation/SimulatedArray.h"
#include "device/simulation/VirtualFirmware.h"
#include "device/usb/UsbArrayDevice.h"
#include "tests/fuzz/FuzzTargets.h"
#include "tests/fuzz/Require.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

using namespace midair::device;

namespace
{

const DeviceLayout kLayout = {4, {0, 0, 0, 1}};

DriveSignal even(std::uint8_t level)
{
    DriveSignal signal;
    signal.phase.assign(4, level);
    signal.duty.assign(4, 255);
    return signal;
}

} // namespace

void fuzzProtocol(const std::uint8_t* data, std::size_t size)
{
    VirtualFirmware firmware(kLayout);
    protocol::StreamParser parser;
    protocol::Packet packet;
    double now_s = 0;
    std::size_t at = 0;
    while (at < size)
    {
        const std::size_t piece = std::min<std::size_t>(size - at, 1 + data[at] % 64);
        firmware.receive(data + at, piece, now_s);
        parser.push(data + at, piece);
        while (parser.next(packet))
        {
            std::vector<std::uint8_t> again;
            protocol::append(again, packet);
            protocol::StreamParser second;
            second.push(again.data(), again.size());
            protocol::Packet read;
            require(second.next(read) && read.type == packet.type &&
                        read.sequence == packet.sequence && read.phases == packet.phases &&
                        read.duties == packet.duties,
                    "a packet that was read and written reads the same");
        }
        at += piece;
        now_s += 1e-3;
    }
    // Whatever came before, a field gets through once the bytes that a torn packet may have
    // promised have come.
    std::vector<std::uint8_t> bytes;
    for (int i = 0; i < 100; ++i) // more bytes than any packet promises
    {
        packet = {};
        packet.type = protocol::Type::HELLO;
        protocol::append(bytes, packet);
    }
    protocol::appendField(bytes, even(9), protocol::ranges(kLayout), 1);
    firmware.receive(bytes.data(), bytes.size(), now_s);
    const DriveSignal playing = firmware.playing(now_s);
    require(playing.phase == even(9).phase && playing.duty == even(9).duty,
            "a whole field plays after any garbage");
    const auto answers = firmware.takeAnswer(1 << 20, now_s);
    protocol::StreamParser host;
    host.push(answers.data(), answers.size());
    while (host.next(packet))
    {
    }
    require(host.badPackets() == 0, "answers are packets");
}

void fuzzRecording(const std::uint8_t* data, std::size_t size)
{
    try
    {
        recording::Reader reader(data, size, "fuzz");
        if (reader.transducers() > 4096) return; // nothing new, only slow
        recording::Entry entry;
        std::uint64_t last_ns = 0;
        while (reader.next(entry) == recording::Stop::MORE)
        {
            require(entry.time_ns >= last_ns, "times ascend");
            require(entry.signal.size() == reader.transducers() &&
                        entry.signal.duty.size() == entry.signal.phase.size(),
                    "every entry is whole");
            require(reader.offset() <= size, "no more is read than there is");
            last_ns = entry.time_ns;
        }
    }
    catch (const DeviceError&)
    {
    }
}

namespace
{

bool within(double value, double low, double high)
{
    return value >= low && value <= high;
}

/// Takes what a device of that kind would, and says whether the name is understood.
template<typename Take>
bool understood(const std::string& text, Take take)
{
    try
    {
        DeviceUri uri(text);
        take(uri);
        uri.rejectUnknown();
        return true;
    }
    catch (const DeviceError& error)
    {
        require(*error.what() != '\0', "an error says something");
        return false;
    }
}

/// Only what touches no hardware and no file, and doesn't fade out for seconds.
bool mayBeOpened(const std::vector<std::string>& parts)
{
    for (const std::string& part : parts)
    {
        const std::string scheme = part.substr(0, part.find(':'));
        if ((scheme != "sim" && scheme != "null") || part.find("ramp") != std::string::npos)
            return false;
    }
    return parts.size() <= 8;
}

void play(const std::string& text)
{
    try
    {
        const std::unique_ptr<ArrayDevice> device = openDevice(text, kLayout);
        device->send(even(9));
        for (const std::complex<float>& q : device->played())
            require(std::abs(q) <= 1.001f, "no transducer plays more than full drive");
        require(device->report().sent >= 1, "a field that is sent is counted");
        require(!device->status().empty(), "a device tells its state");
        device->silence();
    }
    catch (const DeviceError&)
    {
    }
}

} // namespace

void fuzzUri(const std::uint8_t* data, std::size_t size)
{
    const std::string text(reinterpret_cast<const char*>(data), size);
    std::vector<std::string> parts;
    try
    {
        parts = splitDeviceList(text);
    }
    catch (const DeviceError&)
    {
        return; // too long
    }
    std::string joined;
    for (const std::string& part : parts)
    {
        joined += (joined.empty() ? "" : ",") + part;
        understood(part, [](DeviceUri& uri) { SimulatedArray::takeOptions(uri); });
        understood(part, [](DeviceUri& uri) { UsbArrayDevice::takeOptions(uri); });
        understood(part,
                   [](DeviceUri& uri)
                   {
                       const SafetyLimits limits = takeLimits(uri, {});
                       // A ramp that is too long is refused by the guard that holds them.
                       require(within(limits.maxAmplitude, 0, 1) && within(limits.ramp_s, 0, 1e6) &&
                                   within(limits.meanDrive, 0, 1) &&
                                   within(limits.meanDriveTime_s, 0, 1e6) &&
                                   within(limits.hold_s, 0, 1e6) &&
                                   within(limits.maxPressure_Pa, 0, 1e6),
                               "limits are within their ranges");
                   });
    }
    require(!parts.empty() && (joined == text || parts.front().empty()),
            "a list of devices is cut without losing a byte");
    if (mayBeOpened(parts)) play(text);
}
