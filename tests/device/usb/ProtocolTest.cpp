#include "device/usb/Protocol.h"

#include "device/ArrayDevice.h"
#include "tests/device/Fields.h"
#include "tests/device/TestFiles.h"

#include <map>
#include <sstream>

#include <gtest/gtest.h>

using namespace midair::device;
using protocol::Packet;
using protocol::StreamParser;
using protocol::Type;

namespace
{

// The packets at the end of PROTOCOL.md, by the comment above each.
std::map<std::string, std::vector<std::uint8_t>> documented()
{
    std::map<std::string, std::vector<std::uint8_t>> packets;
    std::ifstream file(std::string(MIDAIR_ROOT) + "/device/PROTOCOL.md");
    std::string line;
    std::string name;
    bool isBlock = false;
    while (std::getline(file, line))
    {
        if (line.rfind("```", 0) == 0)
        {
            isBlock = !isBlock;
            continue;
        }
        if (!isBlock) continue;
        if (line.rfind("# ", 0) == 0)
            name = line.substr(2);
        else if (!name.empty())
        {
            std::istringstream text(line);
            unsigned byte = 0;
            while (text >> std::hex >> byte)
                packets[name].push_back(static_cast<std::uint8_t>(byte));
        }
    }
    return packets;
}

std::vector<std::uint8_t> bytesOf(const Packet& packet)
{
    std::vector<std::uint8_t> bytes;
    protocol::append(bytes, packet);
    return bytes;
}

Packet typed(Type type, std::uint32_t sequence = 0)
{
    Packet packet;
    packet.type = type;
    packet.sequence = sequence;
    return packet;
}

std::vector<Packet> parsed(StreamParser& parser, const std::vector<std::uint8_t>& bytes)
{
    parser.push(bytes.data(), bytes.size());
    std::vector<Packet> packets;
    Packet packet;
    while (parser.next(packet))
        packets.push_back(packet);
    return packets;
}

const DeviceLayout kSmall = {4, {0, 0, 0, 1}};
const DriveSignal kSmallField = {{0, 0x40, 0x80, 0xC0}, {0xFF, 0x20, 0, 0x80}};

} // namespace

TEST(Protocol, writes_the_bytes_of_the_document)
{
    const auto packets = documented();
    ASSERT_EQ(packets.size(), 10U);

    std::vector<std::uint8_t> field;
    for (const char* part : {"DATA, board 0, transducers 0 to 2",
                             "DATA, board 1, transducer 0",
                             "COMMIT of 4 transducers"})
        field.insert(field.end(), packets.at(part).begin(), packets.at(part).end());
    std::vector<std::uint8_t> bytes;
    protocol::appendField(bytes, kSmallField, protocol::ranges(kSmall), 7);
    EXPECT_EQ(bytes, field);

    Packet hello = typed(Type::HELLO);
    hello.nonce = 0x12345678;
    EXPECT_EQ(bytesOf(hello), packets.at("HELLO, nonce 0x12345678, watchdog 100 ms"));
    EXPECT_EQ(bytesOf(typed(Type::MUTE, 8)), packets.at("MUTE"));
    EXPECT_EQ(bytesOf(typed(Type::KEEPALIVE)), packets.at("KEEPALIVE"));
    EXPECT_EQ(bytesOf(typed(Type::GET_STATUS)), packets.at("GET_STATUS"));
    Packet identify = typed(Type::IDENTIFY);
    identify.board = 1;
    identify.light = true;
    EXPECT_EQ(bytesOf(identify), packets.at("IDENTIFY, lamp of board 1 on"));
}

TEST(Protocol, reads_the_bytes_of_the_document)
{
    const auto packets = documented();
    StreamParser parser;
    const auto info =
        parsed(parser, packets.at("INFO: firmware 1.2.3, 2 boards, 4 transducers, 1000 fields/s"));
    ASSERT_EQ(info.size(), 1U);
    EXPECT_EQ(info[0].info.firmware(), "1.2.3");
    EXPECT_EQ(info[0].info.boards, 2);
    EXPECT_EQ(info[0].info.transducers, 4U);
    EXPECT_EQ(info[0].info.fieldsPerSecond, 1000);
    EXPECT_EQ(info[0].info.nonce, 0x12345678U);
    EXPECT_EQ(bytesOf(info[0]),
              packets.at("INFO: firmware 1.2.3, 2 boards, 4 transducers, 1000 fields/s"));

    const auto status =
        parsed(parser, packets.at("STATUS: field 7 plays, 36.5 C, 1 field played since power-on"));
    ASSERT_EQ(status.size(), 1U);
    EXPECT_EQ(status[0].sequence, 7U);
    EXPECT_EQ(status[0].status.lastPlayed, 7U);
    EXPECT_EQ(status[0].status.flags, protocol::PLAYING);
    EXPECT_EQ(status[0].status.temperature_dC, 365);
    EXPECT_EQ(status[0].status.played, 1U);
    EXPECT_EQ(bytesOf(status[0]),
              packets.at("STATUS: field 7 plays, 36.5 C, 1 field played since power-on"));
    EXPECT_EQ(parser.badPackets(), 0U);
}

TEST(Protocol, gives_back_a_field_however_the_bytes_are_cut)
{
    DeviceLayout layout{3984, {}};
    for (int i = 0; i < 3984; ++i)
        layout.board.push_back(i / 249);
    const DriveSignal field = randomField(3984, 3);
    std::vector<std::uint8_t> bytes;
    protocol::appendField(bytes, field, protocol::ranges(layout), 99);
    EXPECT_EQ(bytes.size(), 16U * (12 + 4 + 2 * 249 + 4) + 20);
    for (const std::size_t piece :
         {std::size_t(1), std::size_t(13), std::size_t(512), bytes.size()})
    {
        StreamParser parser;
        DriveSignal read = evenField(3984, 0, 0);
        int commits = 0;
        Packet packet;
        for (std::size_t at = 0; at < bytes.size(); at += piece)
        {
            parser.push(bytes.data() + at, std::min(piece, bytes.size() - at));
            while (parser.next(packet))
            {
                EXPECT_EQ(packet.sequence, 99U);
                commits += packet.type == Type::COMMIT ? 1 : 0;
                const std::size_t begin = 249U * packet.board + packet.first;
                if (packet.type == Type::DATA)
                {
                    std::copy(packet.phases.begin(),
                              packet.phases.end(),
                              read.phase.begin() + static_cast<std::ptrdiff_t>(begin));
                    std::copy(packet.duties.begin(),
                              packet.duties.end(),
                              read.duty.begin() + static_cast<std::ptrdiff_t>(begin));
                }
            }
        }
        EXPECT_EQ(read, field);
        EXPECT_EQ(commits, 1);
        EXPECT_EQ(parser.badPackets(), 0U);
    }
}

TEST(Protocol, cuts_large_boards_into_ranges)
{
    const auto ranges = protocol::ranges({2500, {}});
    ASSERT_EQ(ranges.size(), 3U);
    EXPECT_EQ(ranges[2].board, 0);
    EXPECT_EQ(ranges[2].first, 2048);
    EXPECT_EQ(ranges[2].count, 452);
    EXPECT_EQ(ranges[2].offset, 2048);
    const auto boards = protocol::ranges(kSmall);
    ASSERT_EQ(boards.size(), 2U);
    EXPECT_EQ(boards[1].board, 1);
    EXPECT_EQ(boards[1].first, 0);
    EXPECT_EQ(boards[1].offset, 3);
}

TEST(Protocol, finds_the_next_packet_behind_garbage)
{
    const std::vector<std::uint8_t> good = bytesOf(typed(Type::MUTE, 5));
    for (const std::vector<std::uint8_t>& garbage :
         {std::vector<std::uint8_t>{1, 2, 3},
          std::vector<std::uint8_t>{0x4D},
          std::vector<std::uint8_t>{0x4D, 0x48},
          std::vector<std::uint8_t>{0x4D, 0x48, 1, 4, 0, 0},
          std::vector<std::uint8_t>{0x4D, 0x4D, 0x48, 1, 99, 0, 0, 0}})
    {
        std::vector<std::uint8_t> bytes = garbage;
        bytes.insert(bytes.end(), good.begin(), good.end());
        bytes.insert(bytes.end(), good.begin(), good.end());
        StreamParser parser;
        const auto packets = parsed(parser, bytes);
        ASSERT_GE(packets.size(), 1U);
        EXPECT_EQ(packets.back().sequence, 5U);
        EXPECT_EQ(parser.badPackets(), 1U);
    }
}

TEST(Protocol, survives_the_loss_of_any_part_of_a_stream)
{
    std::vector<std::uint8_t> field;
    protocol::appendField(field, kSmallField, protocol::ranges(kSmall), 1);
    std::vector<std::uint8_t> next;
    protocol::appendField(next, kSmallField, protocol::ranges(kSmall), 2);
    for (std::size_t kept = 0; kept <= field.size(); ++kept)
    {
        StreamParser parser;
        std::vector<std::uint8_t> bytes(field.begin(),
                                        field.begin() + static_cast<std::ptrdiff_t>(kept));
        // A torn packet may swallow what its length promises; two more fields are enough to get
        // through.
        for (int i = 0; i < 2; ++i)
            bytes.insert(bytes.end(), next.begin(), next.end());
        int whole = 0;
        for (const Packet& packet : parsed(parser, bytes))
            whole += packet.sequence == 2 ? 1 : 0;
        EXPECT_EQ(whole, 6) << kept; // and what was swallowed is looked at again
    }
}

TEST(Protocol, notices_every_flipped_bit)
{
    std::vector<std::uint8_t> data;
    protocol::appendField(data, kSmallField, protocol::ranges(kSmall), 1);
    data.resize(26); // the first packet
    StreamParser whole;
    ASSERT_EQ(parsed(whole, data).size(), 1U);
    for (std::size_t bit = 0; bit < 8 * data.size(); ++bit)
    {
        std::vector<std::uint8_t> bad = data;
        bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
        StreamParser parser;
        EXPECT_TRUE(parsed(parser, bad).empty()) << bit;
    }
}

TEST(Protocol, takes_only_greetings_of_another_version)
{
    for (const Type type : {Type::HELLO, Type::INFO, Type::MUTE, Type::STATUS})
    {
        Packet packet = typed(type);
        packet.version = 9;
        StreamParser parser;
        const auto packets = parsed(parser, bytesOf(packet));
        ASSERT_EQ(packets.size(), type == Type::HELLO || type == Type::INFO ? 1U : 0U);
        for (const Packet& read : packets)
            EXPECT_EQ(read.version, 9);
    }
}

TEST(Protocol, compares_numbers_that_wrap_around)
{
    EXPECT_TRUE(protocol::newer(2, 1));
    EXPECT_FALSE(protocol::newer(1, 1));
    EXPECT_FALSE(protocol::newer(1, 2));
    EXPECT_TRUE(protocol::newer(1, 0xFFFFFFFF));
    EXPECT_FALSE(protocol::newer(0xFFFFFFFF, 1));
}
