#include "device/simulation/VirtualFirmware.h"

#include "tests/device/Fields.h"

#include <gtest/gtest.h>

using namespace midair::device;
using protocol::Packet;
using protocol::Type;

namespace
{

const DeviceLayout kLayout = {4, {0, 0, 0, 1}};

// A host in a few lines; time is what the test says.
class Host
{
public:
    explicit Host(const VirtualFirmware::Options& options = {}) : firmware(kLayout, options)
    {
        send(Type::HELLO, 0);
    }

    void field(std::uint32_t sequence, std::uint8_t phase, std::uint8_t duty)
    {
        bytes.clear();
        protocol::appendField(
            bytes, evenField(4, phase, duty), protocol::ranges(kLayout), sequence);
        firmware.receive(bytes.data(), bytes.size(), now_s);
    }
    void send(Type type, std::uint32_t sequence)
    {
        Packet packet;
        packet.type = type;
        packet.sequence = sequence;
        bytes.clear();
        protocol::append(bytes, packet);
        firmware.receive(bytes.data(), bytes.size(), now_s);
    }
    std::vector<Packet> answers()
    {
        const auto answer = firmware.takeAnswer(4096, now_s);
        protocol::StreamParser parser;
        parser.push(answer.data(), answer.size());
        std::vector<Packet> packets;
        Packet packet;
        while (parser.next(packet))
            packets.push_back(packet);
        return packets;
    }
    bool silent() { return firmware.playing(now_s).duty == std::vector<std::uint8_t>(4, 0); }
    int phase() { return firmware.playing(now_s).phase[0]; }
    protocol::Status status() { return firmware.status(now_s); }

    VirtualFirmware firmware;
    double now_s = 0;
    std::vector<std::uint8_t> bytes;
};

} // namespace

TEST(VirtualFirmware, greets_and_plays_a_whole_field)
{
    Host host;
    const auto greeting = host.answers();
    ASSERT_EQ(greeting.size(), 1U);
    EXPECT_EQ(greeting[0].type, Type::INFO);
    EXPECT_EQ(greeting[0].info.transducers, 4U);
    EXPECT_EQ(greeting[0].info.boards, 2);
    EXPECT_EQ(greeting[0].info.watchdog_ms, 100);
    EXPECT_TRUE(host.silent());
    host.field(1, 9, 200);
    EXPECT_EQ(host.firmware.playing(0), evenField(4, 9, 200));
    const auto answer = host.answers();
    ASSERT_EQ(answer.size(), 1U);
    EXPECT_EQ(answer[0].sequence, 1U);
    EXPECT_EQ(answer[0].status.lastPlayed, 1U);
    EXPECT_EQ(answer[0].status.flags, protocol::PLAYING);
}

TEST(VirtualFirmware, keeps_the_old_field_when_a_packet_of_the_new_one_is_lost)
{
    Host host;
    host.field(1, 9, 200);
    std::vector<std::uint8_t> bytes;
    protocol::appendField(bytes, evenField(4, 50, 100), protocol::ranges(kLayout), 2);
    const std::size_t first = 12 + 4 + 6 + 4;
    host.firmware.receive(bytes.data() + first, bytes.size() - first, 0.01); // board 0 is missing
    EXPECT_EQ(host.firmware.playing(0.01), evenField(4, 9, 200));
    EXPECT_EQ(host.status().incomplete, 1U);
    // The late first part does not complete a field that was refused, but a new commit of all of it
    // does.
    host.firmware.receive(bytes.data(), bytes.size(), 0.02);
    EXPECT_EQ(host.firmware.playing(0.02), evenField(4, 50, 100));
}

TEST(VirtualFirmware, drops_what_is_stale)
{
    Host host;
    host.field(5, 1, 200);
    host.field(4, 2, 200);
    host.field(5, 3, 200);
    EXPECT_EQ(host.phase(), 1);
    EXPECT_EQ(host.status().stale, 2U);
    EXPECT_EQ(host.status().played, 1U);
}

TEST(VirtualFirmware, mutes_at_once_and_for_fields_on_their_way)
{
    Host host;
    host.field(1, 1, 200);
    host.send(Type::MUTE, 4);
    EXPECT_TRUE(host.silent());
    EXPECT_EQ(host.status().flags, protocol::MUTED);
    host.field(2, 2, 200);
    host.field(3, 3, 200);
    EXPECT_TRUE(host.silent());
    EXPECT_EQ(host.status().stale, 2U);
    host.field(5, 5, 200);
    EXPECT_EQ(host.phase(), 5);
    host.send(Type::MUTE, 4); // late
    EXPECT_FALSE(host.silent());
    host.send(Type::MUTE, 0); // always
    EXPECT_TRUE(host.silent());
}

TEST(VirtualFirmware, mutes_100_ms_after_the_last_packet)
{
    Host host;
    host.field(1, 1, 200);
    host.now_s = 0.05;
    host.send(Type::KEEPALIVE, 0);
    host.now_s = 0.1499;
    EXPECT_FALSE(host.silent());
    host.answers();
    host.now_s = 0.1501;
    EXPECT_TRUE(host.silent());
    const auto unasked = host.answers();
    ASSERT_EQ(unasked.size(), 1U);
    EXPECT_EQ(unasked[0].sequence, 0U);
    EXPECT_EQ(unasked[0].status.flags, protocol::WATCHDOG_FIRED);
    EXPECT_EQ(unasked[0].status.watchdogs, 1U);
    host.now_s = 3;
    EXPECT_EQ(host.status().watchdogs, 1U); // once
    host.field(2, 2, 200);
    EXPECT_EQ(host.phase(), 2);
    EXPECT_FALSE(host.silent());
}

TEST(VirtualFirmware, does_not_count_damaged_packets_as_talk)
{
    Host host;
    host.field(1, 1, 200);
    host.now_s = 0.09;
    const std::vector<std::uint8_t> noise(100, 0x77);
    host.firmware.receive(noise.data(), noise.size(), host.now_s);
    host.now_s = 0.11;
    EXPECT_TRUE(host.silent());
    EXPECT_EQ(host.status().badPackets, 1U);
}

TEST(VirtualFirmware, plays_after_its_latency_and_mutes_before_it)
{
    VirtualFirmware::Options options;
    options.latency_s = 0.01;
    Host host(options);
    host.field(1, 1, 200);
    EXPECT_TRUE(host.silent());
    host.now_s = 0.011;
    EXPECT_FALSE(host.silent());
    host.field(2, 2, 200);
    host.now_s = 0.012;
    host.send(Type::MUTE, 3);
    host.now_s = 0.03;
    EXPECT_TRUE(host.silent());
}

TEST(VirtualFirmware, plays_no_more_fields_than_it_can_and_the_newest_of_them)
{
    VirtualFirmware::Options options;
    options.fieldsPerSecond = 100;
    Host host(options);
    for (std::uint32_t i = 1; i <= 10; ++i)
    {
        host.now_s = 0.001 * i;
        host.field(i, static_cast<std::uint8_t>(i), 200);
        EXPECT_EQ(host.phase(), 1) << i;
    }
    host.now_s = 0.012;
    EXPECT_EQ(host.phase(), 10);
    EXPECT_EQ(host.status().played, 2U);
    EXPECT_EQ(host.status().stale, 8U);
}

TEST(VirtualFirmware, mutes_when_hot_and_plays_again_when_cool)
{
    Host host;
    host.field(1, 1, 200);
    host.firmware.setTemperature(81, 0);
    EXPECT_TRUE(host.silent());
    host.field(2, 2, 200);
    EXPECT_TRUE(host.silent());
    host.firmware.setTemperature(78, 0);
    host.field(3, 3, 200);
    EXPECT_TRUE(host.silent()); // not before it is 5 degrees under the limit
    host.firmware.setTemperature(74, 0);
    host.field(4, 4, 200);
    EXPECT_FALSE(host.silent());
}

TEST(VirtualFirmware, ignores_ranges_and_boards_that_do_not_exist)
{
    Host host;
    Packet packet;
    packet.type = Type::DATA;
    packet.sequence = 1;
    packet.phases = packet.duties = {1, 2, 3, 4};
    for (const std::uint16_t board : {0, 1, 2, 0xFFFF})
        for (const std::uint16_t first : {0, 3, 0xFFFF})
        {
            packet.board = board;
            packet.first = first;
            std::vector<std::uint8_t> bytes;
            protocol::append(bytes, packet);
            host.firmware.receive(bytes.data(), bytes.size(), 0);
        }
    host.field(2, 9, 200);
    EXPECT_EQ(host.firmware.playing(0), evenField(4, 9, 200));
}

TEST(VirtualFirmware, lights_the_lamp_of_one_board_or_of_all)
{
    Host host;
    Packet packet;
    packet.type = Type::IDENTIFY;
    packet.board = 1;
    packet.light = true;
    std::vector<std::uint8_t> bytes;
    protocol::append(bytes, packet);
    host.firmware.receive(bytes.data(), bytes.size(), 0);
    EXPECT_FALSE(host.firmware.light(0));
    EXPECT_TRUE(host.firmware.light(1));
}

TEST(VirtualFirmware, forgets_the_session_at_a_hello)
{
    Host host;
    host.field(100, 1, 200);
    host.send(Type::HELLO, 0);
    EXPECT_TRUE(host.silent());
    host.field(1, 2, 200);
    EXPECT_EQ(host.phase(), 2);
    EXPECT_FALSE(host.silent());
}
