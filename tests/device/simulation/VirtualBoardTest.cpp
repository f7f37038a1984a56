#include "device/simulation/VirtualBoard.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

using namespace midair::device;

// What the published firmware does, also with what our encoders never send.

namespace
{

void feed(VirtualBoard& board, const std::vector<std::uint8_t>& bytes)
{
    board.receive(bytes.data(), bytes.size());
}

std::vector<std::uint8_t> sonicField(std::uint8_t delay)
{
    std::vector<std::uint8_t> bytes(258, delay);
    bytes.front() = 254;
    bytes.back() = 253;
    return bytes;
}

std::vector<std::uint8_t> mpdField(std::uint8_t delay, std::uint8_t width)
{
    std::vector<std::uint8_t> bytes(512, width);
    std::fill_n(bytes.begin(), 256, delay);
    bytes[0] |= 0x80;
    return bytes;
}

/// The smallest and the largest amplitude.
std::pair<float, float> amplitudes(const VirtualBoard& board)
{
    const auto q = board.playing();
    const auto quieter = [](std::complex<float> a, std::complex<float> b)
    { return std::abs(a) < std::abs(b); };
    return {std::abs(*std::min_element(q.begin(), q.end(), quieter)),
            std::abs(*std::max_element(q.begin(), q.end(), quieter))};
}

void expectAll(const VirtualBoard& board, float amplitude)
{
    EXPECT_NEAR(amplitudes(board).first, amplitude, 1e-6);
    EXPECT_NEAR(amplitudes(board).second, amplitude, 1e-6);
}

} // namespace

TEST(VirtualSonicSurface, starts_with_full_drive_in_both_buffers)
{
    const auto board = makeVirtualBoard("sonicsurface", 256);
    expectAll(*board, 1);
    feed(*board, {253});
    expectAll(*board, 1);
    feed(*board, sonicField(32));
    expectAll(*board, 0);
    feed(*board, {253});
    expectAll(*board, 1);
}

TEST(VirtualSonicSurface, swap_exchanges_two_buffers)
{
    const auto board = makeVirtualBoard("sonicsurface", 256);
    feed(*board, sonicField(8));
    feed(*board, sonicField(32));
    expectAll(*board, 0);
    feed(*board, {253});
    EXPECT_NEAR(std::arg(board->playing()[0]), -M_PI / 2, 1e-6);
    feed(*board, {253});
    expectAll(*board, 0);
}

TEST(VirtualSonicSurface, takes_all_but_its_commands_for_delays)
{
    for (const int byte : {0, 31, 33, 63, 149, 152, 191, 194, 251, 252, 255})
    {
        const auto board = makeVirtualBoard("sonicsurface", 256);
        feed(*board, sonicField(static_cast<std::uint8_t>(byte)));
        expectAll(*board, 1);
        const double delay = 2 * M_PI * (byte % 32) / 32;
        EXPECT_NEAR(std::abs(std::complex<double>(board->playing()[100]) - std::polar(1.0, -delay)),
                    0,
                    1e-6)
            << byte;
    }
}

TEST(VirtualSonicSurface, switches_its_clocks_off_and_on)
{
    const auto board = makeVirtualBoard("sonicsurface", 256);
    feed(*board, {150});
    expectAll(*board, 0);
    feed(*board, {151});
    expectAll(*board, 1);
}

TEST(VirtualSonicSurface, two_on_a_line_are_addressed_but_swap_together)
{
    const auto stack = makeVirtualBoard("sonicsurface", 512);
    feed(*stack, sonicField(32)); // at first both take it
    expectAll(*stack, 0);
    feed(*stack, sonicField(32));
    feed(*stack, {193});
    feed(*stack, sonicField(0));
    EXPECT_EQ(std::abs(stack->playing().front()), 0);
    EXPECT_NEAR(std::abs(stack->playing().back()), 1, 1e-6);
    feed(*stack, {192, 253}); // the second's other buffer is silent
    expectAll(*stack, 0);
}

TEST(VirtualUltraino, starts_with_full_drive_in_one_buffer)
{
    const auto board = makeVirtualBoard("ultraino", 128);
    expectAll(*board, 1);
    std::vector<std::uint8_t> silence(200, 1);
    silence.insert(silence.end(), 200, 2);
    silence.push_back(0);
    feed(*board, silence);
    expectAll(*board, 0);
    feed(*board, {0});
    expectAll(*board, 1); // one silent field isn't enough
    board->powerUp();
    feed(*board, silence);
    feed(*board, silence);
    feed(*board, {0});
    expectAll(*board, 0);
}

TEST(VirtualUltraino, plays_all_patterns_that_have_a_duration)
{
    const auto board = makeVirtualBoard("ultraino", 64);
    std::vector<std::uint8_t> fields(200, 1); // a silent pattern ..
    fields.insert(fields.end(), 100, 0xF1);   // .. and one that is on for half of the period
    fields.insert(fields.end(), 100, 1);
    fields.push_back(0);
    feed(*board, fields);
    expectAll(*board, 0); // by default there is one
    for (const int duration : {1, 1, 0})
        feed(*board, {0x30, 0x30, 0x30, static_cast<std::uint8_t>(duration == 1 ? 0x70 : 0x30)});
    expectAll(*board, 0);
    feed(*board, {0x10});
    expectAll(*board, 1);
}

TEST(VirtualUltraino, sends_back_what_is_for_the_next_board)
{
    const auto board = makeVirtualBoard("ultraino", 64);
    feed(*board,
         {0x11, 0x72, 0x70, 0x10, 0x00}); // its own bytes it keeps, the others' it counts down
    EXPECT_EQ(board->takeAnswer(), (std::vector<std::uint8_t>{0x71, 0x70, 0x10, 0x00}));
    EXPECT_TRUE(board->takeAnswer().empty());
}

TEST(VirtualOpenMpd, is_silent_until_a_whole_field_has_come)
{
    const auto board = makeVirtualBoard("openmpd", 256);
    expectAll(*board, 0);
    const auto field = mpdField(0, 64);
    board->receive(field.data(), 511);
    expectAll(*board, 0);
    board->receive(field.data() + 511, 1);
    expectAll(*board, 1);
    feed(*board, mpdField(0, 0));
    expectAll(*board, 0);
}

TEST(VirtualOpenMpd, waits_for_the_bit_that_starts_a_field)
{
    const auto board = makeVirtualBoard("openmpd", 256);
    feed(*board, std::vector<std::uint8_t>(512, 64));
    expectAll(*board, 0);
    EXPECT_EQ(board->swaps(), 0U);
    feed(*board, mpdField(0, 64));
    EXPECT_EQ(board->swaps(), 1U);
}

TEST(VirtualOpenMpd, pulses_wider_than_half_a_period_are_not_cut)
{
    const auto board = makeVirtualBoard("openmpd", 256);
    feed(*board, mpdField(100, 96));
    EXPECT_NEAR(amplitudes(*board).second, std::sin(M_PI * 96 / 128), 1e-6);
    feed(*board, mpdField(0, 128)); // 7 bits of it
    expectAll(*board, 0);
}

TEST(VirtualOpenMpd, sets_its_rate_by_the_top_bits_of_nine_delays)
{
    const auto board = makeVirtualBoard("openmpd", 256);
    EXPECT_EQ(board->mostFieldsPerSecond(), 10000);
    auto field = mpdField(0, 0);
    field[26] |= 0x80;
    field[29] |= 0x80; // 1 + 8
    feed(*board, field);
    EXPECT_EQ(board->mostFieldsPerSecond(), 10000); // not applied
    field[34] |= 0x80;
    feed(*board, field);
    EXPECT_NEAR(board->mostFieldsPerSecond(), 40000.0 / 9, 1e-9);
}

TEST(VirtualOpenMpd, plays_late_after_a_lost_byte_until_a_second_without_any)
{
    const auto board = makeVirtualBoard("openmpd", 256);
    const auto field = mpdField(0, 64);
    const auto silence = mpdField(0, 0);
    board->receive(field.data() + 1, 511);
    feed(*board, silence);
    feed(*board, field);
    expectAll(*board, 0);
    feed(*board, silence);
    expectAll(*board, 1); // the field before
    board->rest(1);
    feed(*board, silence);
    feed(*board, silence);
    expectAll(*board, 0);
}
