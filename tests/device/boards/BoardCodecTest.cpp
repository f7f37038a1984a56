#include "device/boards/BoardKind.h"
#include "device/simulation/VirtualBoard.h"
#include "tests/device/Fields.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

std::vector<std::uint8_t> fieldBytes(const std::string& board, const DriveSignal& signal)
{
    std::vector<std::uint8_t> bytes;
    makeBoardCodec(board)->appendField(bytes, signal);
    return bytes;
}

// What the board plays, by the decoder written from its firmware's behaviour.
std::vector<std::complex<float>> playedByBoard(const std::string& name, const DriveSignal& signal)
{
    const auto codec = makeBoardCodec(name);
    const auto board = makeVirtualBoard(name, signal.size());
    std::vector<std::uint8_t> bytes;
    codec->appendOpening(bytes);
    codec->appendField(bytes, signal);
    board->receive(bytes.data(), bytes.size());
    return board->playing();
}

struct Board
{
    const char* name;
    int transducers;
    int phaseLevels;
};

const Board kBoards[] = {
    {"sonicsurface", 256, 32}, {"ultraino", 64, 10}, {"ultraino", 192, 10}, {"openmpd", 256, 128}};

} // namespace

TEST(SonicSurface, frame_is_254_phases_253)
{
    DriveSignal signal = evenField(256, 0, 255);
    signal.phase[1] = 64;  // a quarter of a turn earlier is 24 of 32 steps later
    signal.phase[2] = 192; // a quarter later: 8
    signal.phase[3] = 252; // half a step later, rounded up: 1
    signal.phase[4] = 253; // less than half a step: 0
    signal.phase[5] = 128;
    signal.duty[6] = 84; // amplitude under one half is off
    signal.duty[7] = 85; // one half is on
    std::vector<std::uint8_t> expected(258, 0);
    expected[0] = 254;
    expected[1 + 1] = 24;
    expected[1 + 2] = 8;
    expected[1 + 3] = 1;
    expected[1 + 4] = 0;
    expected[1 + 5] = 16;
    expected[1 + 6] = 32;
    expected[257] = 253;
    EXPECT_EQ(fieldBytes("sonicsurface", signal), expected);
}

TEST(SonicSurface, never_sends_a_command_as_a_phase)
{
    for (unsigned seed = 0; seed < 50; ++seed)
    {
        const auto bytes = fieldBytes("sonicsurface", randomField(256, seed));
        for (std::size_t i = 1; i < 257; ++i)
            EXPECT_LE(bytes[i], 32);
    }
}

TEST(Ultraino, frame_is_a_bitmap_of_ten_steps_in_nibbles)
{
    DriveSignal signal = evenField(64, 0, 0);
    signal.duty[63] = 255; // channel 63 is bit 0 of the first port, steps 0 to 4
    signal.duty[0] = 102;  // channel 0 is bit 3 of the seventh port (pin 51): 2 steps, from step 2
                           // to keep the centre
    std::vector<std::uint8_t> bits(100, 0);
    for (int step = 0; step < 5; ++step)
        bits[static_cast<std::size_t>(10 * step)] = 1;
    for (int step = 2; step < 4; ++step)
        bits[static_cast<std::size_t>(10 * step) + 6] = 8;
    std::vector<std::uint8_t> expected;
    for (const std::uint8_t byte : bits)
    {
        expected.push_back(static_cast<std::uint8_t>((byte & 0xF0) | 1));
        expected.push_back(static_cast<std::uint8_t>((byte << 4) | 1));
    }
    expected.push_back(0);
    EXPECT_EQ(fieldBytes("ultraino", signal), expected);
}

TEST(Ultraino, chained_boards_have_their_numbers_in_the_low_nibble)
{
    const auto bytes = fieldBytes("ultraino", randomField(192, 1));
    ASSERT_EQ(bytes.size(), 3U * 200 + 1);
    for (std::size_t i = 0; i < 600; ++i)
        EXPECT_EQ(bytes[i] & 0x0F, i / 200 + 1);
    EXPECT_EQ(bytes[600], 0);
}

TEST(Ultraino, opens_with_one_pattern_for_ever)
{
    std::vector<std::uint8_t> bytes;
    makeBoardCodec("ultraino")->appendOpening(bytes);
    EXPECT_EQ(bytes,
              (std::vector<std::uint8_t>{0x30, 0x30, 0x30, 0x70, 0x30, 0x30, 0x30, 0x30, 0x10}));
}

TEST(OpenMpd, frame_is_phases_then_duties)
{
    DriveSignal signal = evenField(256, 0, 255);
    signal.phase[1] = 64; // a quarter earlier: 96 of 128 later
    signal.duty[2] = 85;  // amplitude 1/2: trunc(128 asin(1/2)/pi) = 21, starts (64 - 21)/2 later
    signal.duty[3] = 0;
    std::vector<std::uint8_t> expected(512, 0);
    std::fill(expected.begin() + 256, expected.end(), std::uint8_t(64));
    expected[0] = 0x80; // start of frame
    expected[1] = 96;
    expected[2] = 21;
    expected[256 + 2] = 21;
    expected[3] = 32;
    expected[256 + 3] = 0;
    EXPECT_EQ(fieldBytes("openmpd", signal), expected);
}

TEST(BoardCodec, knows_its_boards_by_name)
{
    EXPECT_EQ(makeBoardCodec("arduino"), nullptr);
    EXPECT_EQ(makeVirtualBoard("arduino", 64), nullptr);
    EXPECT_TRUE(makeBoardCodec("ultraino")->takes(128));
    EXPECT_FALSE(makeBoardCodec("ultraino")->takes(100));
    EXPECT_FALSE(makeBoardCodec("ultraino")->takes(15 * 64)); // numbers are 1 to 14
    EXPECT_FALSE(makeBoardCodec("openmpd")->takes(512));
}

TEST(BoardCodec, agrees_with_the_board_on_what_is_played)
{
    for (const Board& board : kBoards)
        for (unsigned seed = 0; seed < 10; ++seed)
        {
            const DriveSignal signal = randomField(board.transducers, seed);
            std::vector<std::complex<float>> told;
            makeBoardCodec(board.name)->played(signal, told);
            const auto played = playedByBoard(board.name, signal);
            ASSERT_EQ(told.size(), played.size());
            for (std::size_t i = 0; i < told.size(); ++i)
                EXPECT_LT(std::abs(told[i] - played[i]), 1e-6)
                    << board.name << " " << i; // single precision
        }
}

TEST(BoardCodec, plays_the_phase_that_was_asked_for_to_half_a_step)
{
    for (const Board& board : kBoards)
        for (int phase = 0; phase < 256; ++phase)
        {
            const auto played = playedByBoard(
                board.name, evenField(board.transducers, static_cast<std::uint8_t>(phase), 255));
            const std::complex<double> wanted = std::polar(1.0, 2 * M_PI * phase / 256);
            for (const std::complex<float> q : {played.front(), played.back()})
            {
                EXPECT_NEAR(std::abs(q), 1, 1e-6);
                EXPECT_LE(std::abs(std::arg(std::complex<double>(q) / wanted)),
                          M_PI / board.phaseLevels + 1e-6)
                    << board.name << " " << phase;
            }
        }
}

TEST(BoardCodec, keeps_the_phase_at_partial_amplitude)
{
    // A pulse's start is a whole step, so its centre is off by up to a whole one where the width is
    // odd.
    for (const Board& board : kBoards)
        for (int duty = 0; duty < 256; ++duty)
        {
            const auto q = std::complex<double>(
                playedByBoard(board.name,
                              evenField(board.transducers, 0, static_cast<std::uint8_t>(duty)))
                    .front());
            const double off = std::abs(q) > 0 ? std::abs(std::arg(q)) : 0;
            EXPECT_LE(off, 2 * M_PI / board.phaseLevels + 1e-6) << board.name << " " << duty;
        }
}

TEST(BoardCodec, plays_only_the_amplitudes_that_it_names)
{
    for (const Board& board : kBoards)
    {
        const std::vector<float> levels = makeBoardCodec(board.name)->amplitudes();
        EXPECT_EQ(levels.front(), 0);
        EXPECT_FLOAT_EQ(levels.back(), 1);
        EXPECT_EQ(makeBoardCodec(board.name)->phaseLevels(), board.phaseLevels);
        for (int duty = 0; duty < 256; ++duty)
        {
            const auto q = playedByBoard(
                board.name, evenField(board.transducers, 0, static_cast<std::uint8_t>(duty)));
            double nearest = 1;
            for (const float level : levels)
                nearest = std::min(nearest, std::abs(double(level) - std::abs(q[0])));
            EXPECT_LT(nearest, 1e-6) << board.name << " " << duty;
        }
    }
}

TEST(BoardCodec, opens_before_the_start_of_a_field)
{
    // SonicSurface's design for tactile modulation takes these for delays, which 254 then lets be
    // overwritten.
    std::vector<std::uint8_t> bytes;
    makeBoardCodec("sonicsurface")->appendSilence(bytes, 256);
    ASSERT_EQ(bytes.size(), 2U + 2 * 258);
    EXPECT_EQ(bytes[0], 151);
    EXPECT_EQ(bytes[1], 192);
    EXPECT_EQ(bytes[2], 254);
}

TEST(BoardCodec, silence_is_silent)
{
    for (const Board& board : kBoards)
    {
        const auto codec = makeBoardCodec(board.name);
        const auto peer = makeVirtualBoard(board.name, board.transducers);
        std::vector<std::uint8_t> bytes;
        codec->appendOpening(bytes);
        codec->appendField(bytes, randomField(board.transducers, 1));
        codec->appendSilence(bytes, board.transducers);
        peer->receive(bytes.data(), bytes.size());
        EXPECT_EQ(peer->swaps(), 1U + static_cast<unsigned>(codec->silentFields()));
        for (const std::complex<float> q : peer->playing())
            EXPECT_EQ(std::abs(q), 0) << board.name;
    }
}

// Both boards of two buffers start with full drive, and a swap exchanges them: 253 and 0x00 may be
// what noise makes of another byte.
TEST(BoardCodec, silence_leaves_nothing_that_a_swap_brings_back)
{
    for (const Board& board : kBoards)
    {
        const std::string name = board.name;
        if (name == "openmpd") continue; // it swaps by itself, after a whole field
        const auto codec = makeBoardCodec(name);
        const auto peer = makeVirtualBoard(name, board.transducers);
        std::vector<std::uint8_t> bytes;
        codec->appendOpening(bytes);
        codec->appendField(bytes, randomField(board.transducers, 1));
        codec->appendSilence(bytes, board.transducers);
        bytes.push_back(name == "ultraino" ? 0x00 : 253);
        peer->receive(bytes.data(), bytes.size());
        for (const std::complex<float> q : peer->playing())
            EXPECT_EQ(std::abs(q), 0) << name;
    }
}

TEST(BoardCodec, silences_a_board_whose_field_was_cut_off_anywhere)
{
    for (const Board& board : kBoards)
    {
        const auto codec = makeBoardCodec(board.name);
        std::vector<std::uint8_t> field;
        codec->appendField(field, randomField(board.transducers, 1));
        for (std::size_t cut = 0; cut < field.size(); cut += 7)
        {
            const auto peer = makeVirtualBoard(board.name, board.transducers);
            peer->receive(field.data(), cut);
            std::vector<std::uint8_t> bytes;
            codec->appendReset(bytes, board.transducers);
            peer->receive(bytes.data(), bytes.size());
            const std::uint8_t swap = std::string(board.name) == "ultraino" ? 0x00 : 253;
            for (int swaps = 0; swaps < 2; ++swaps)
            {
                for (const std::complex<float> q : peer->playing())
                    EXPECT_EQ(std::abs(q), 0) << board.name << ", cut after " << cut;
                peer->receive(&swap, 1);
            }
        }
    }
}

TEST(BoardCodec, reset_silences_both_boards_of_a_stack)
{
    const auto codec = makeBoardCodec("sonicsurface");
    const auto stack = makeVirtualBoard("sonicsurface", 512); // both start with full drive
    std::vector<std::uint8_t> bytes = {193, 150};             // what another program may have left
    codec->appendReset(bytes, 256);
    stack->receive(bytes.data(), bytes.size());
    for (const std::complex<float> q : stack->playing())
        EXPECT_EQ(std::abs(q), 0);
    const std::size_t before = bytes.size();
    codec->appendField(bytes, evenField(256, 0, 255)); // for the first
    stack->receive(bytes.data() + before, bytes.size() - before);
    EXPECT_NEAR(std::abs(stack->playing().front()), 1, 1e-6);
    EXPECT_EQ(std::abs(stack->playing().back()), 0);
}
