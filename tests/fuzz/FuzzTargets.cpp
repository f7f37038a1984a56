#include "FuzzTargets.h"

#include "device/ArrayDevice.h"
#include "device/Recording.h"
#include "device/VirtualFirmware.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

using namespace midair::device;

namespace
{

void require(bool good, const char* what)
{
    if (good) return;
    std::fprintf(stderr, "broken: %s\n", what);
    std::abort();
}

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
    // Whatever came before, a field gets through once the bytes that a torn packet may have promised have come.
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
