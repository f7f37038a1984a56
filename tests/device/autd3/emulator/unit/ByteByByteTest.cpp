// One session with unit 0 of two, as the wire format's description gives it, byte by byte.

#include "tests/device/autd3/emulator/UnitBench.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace midair::device::emulation
{
namespace
{

struct Line
{
    int to;
    const char* sent;
    const char* answer; ///< "TT*8" is the unit's time; ".." all that any answer to a frame has
    double wait_ms = 0; ///< before
};

std::string widths()
{
    std::string text;
    for (int duty = 0; duty < 256; ++duty)
    {
        const int width = (512 * duty + 255) / 510;
        text += fmt::format(" {:02X} {:02X}", width & 255, width >> 8);
    }
    return text;
}

// The answer as it should be, with the time that really is in it.
Bytes expected(const std::string& text, const Bytes& answer)
{
    std::string whole = text;
    if (whole.size() == 5) // a number and a result
        whole = fmt::format("02 00 {:02X} {:02X} {} 3F 00 TT", answer.at(2), answer.at(3), text);
    const std::size_t time = whole.find("TT");
    if (time == std::string::npos) return hex(whole);
    Bytes bytes = hex(whole.substr(0, time));
    for (std::size_t i = 0; i < 8; ++i)
        bytes.push_back(answer.size() > bytes.size() ? answer[bytes.size()] : 0);
    const Bytes rest = hex(whole.substr(time + 2));
    bytes.insert(bytes.end(), rest.begin(), rest.end());
    return bytes;
}

constexpr const char* kConfig = "02 00 05 00 03 05 40 42 0F 00 40 42 0F 00 00 94 35 77 90 D0 03 00 "
                                "64 00 08 00 03 00 06 00 E8 03 "
                                "40 00 10 27 00 00 64 00 00 00 32 00 00 00 01 00 00 00 20 A1 07 00 "
                                "64 00 20 00 05 00 30 00 40 00 "
                                "08 00 00 00 03 00";

const Line kOpening[] = {
    {kGroup, "03 03 34 12", "02 03 34 12 01"},
    {kGroup, "02 02 01 00", "02 02 01 00 00"},
    {kGroup, "02 03 02 00", "02 03 02 00 00", 100},
    {kNoId, "02 04 03 00 00 01", "02 04 03 00 00"},
    {0, "02 05 04 00", "02 05 04 00 00 01"},
    {0, "02 06 05 00 00*8", "02 06 05 00 00"},
    {0, "02 01 06 00", "02 01 06 00 00 00 3F 00 00 00 0A 00 00 TT 00*4"},
    {0, "02 07 07 00", "02 07 07 00 FF 00 3F 00 TT", 50},
    {0, "02 00 01 00 00 00", "02 00 01 00 FF 00 3F 00 TT"},
    {0, "02 00 02 00 00 EB", "02 00 02 00 00 00 3F 00 TT 00 0A 00 00 0A 00 8C 01"},
    {0, "02 00 03 00 01 03", "02 00 03 00 01 00 3F 00 TT"},
    {0, "02 00 04 00 02 01", "02 00"},
    {0, kConfig, "03 00"},
    {0, "02 00 06 00 04 30 00 00 00 01 00 01 0A 00 28 00", "04 00"},
};

const Line kPlaying[] = {
    {0, "02 00 08 00 06 41 FF FF FD FF*28 01", "06 00"},
    {0, "02 00 09 00 07 11 00 01 01 00 02 00 00 00 00 00 00 00 00 00", "07 00"},
    {0, "02 00 0A 00 08 11 01 01 01 00 02 00 00 00 00 00 00 00 00 00", "08 00"},
    {0, "02 00 0B 00 09 15 01 02 00 00 00..F8 FF*249 00..F8 FF*249", "09 00"},
    {0, "02 00 0C 00 0A 12 01 01 00 E1 F5 05 00 00 00 00", "0A 00"},
    {0, "02 00 0C 00 0A 12 01 01 00 E1 F5 05 00 00 00 00", "0A 00"},
    {0, "02 00 0D 00 0B 12 01 01 01 00*7", "0B 06"},
    {0, "02 00 0E 00 0D 04", "0B 06"},
    {0, "02 00 0F 00 0C E7", "02 00 0F 00 0C 00 3F 00 TT 40"},
    {0, "02 07 40 00", "02 07 40 00 0C 00 3F 00 TT 40"},
    {0, "02 00 0F 00 0C E7", "02 00 0F 00 0C 00 3F 00 TT 40"},
    {0, "02 00 41 00 0E 04", "02 00 41 00 0C 00 3F 00 TT 40"},
    {0, "02 00 10 00 0D E7", "02 00 10 00 0D 00 3F 00 TT 14", 60},
    {0, "02 00 11 00 0E 11 00 01 28 00 64 00 00 00 00 00 00 00 FF FF", "0E 00"},
    {0, "02 00 12 00 0F 13 00 08 02 FF 62 00 80*249 40*249", "0F 00"},
    {0, "02 00 13 00 10 13 00 04 01 FF 61 00 10*125", "10 00"},
    {0, "02 00 14 00 11 12 00 FF 00*8", "11 00"},
    {0, "02 00 15 00 12 20 01 00 00 00 00 00 00 80 FF 80", "12 00"},
    {0, "02 00 16 00 13 21 01 00 32 00 04 00 00 00 FF FF", "13 00"},
    {0, "02 00 17 00 14 22 01 FF 00*8", "14 00"},
    {0, "02 00 18 00 15 40 10*249", "15 00"},
    {0, "02 00 19 00 16 41 00*32", "16 00"},
    {0, "02 00 1A 00 17 60 01", "17 00"},
    {0, "02 00 1B 00 18 12 00 FF 00*7", "18 02"},
    {0, "02 00 1C 00 19 14", "19 01"},
    {0, "02 00 1D 00 1A E7", "02 00 1D 00 1A 00 3F 00 TT 82", 110},
    {0, "02 00 1E 00 1B 06", "1B 00"},
    {0,
     "02 00 1F 00 1C E8",
     "02 00 1F 00 1C 00 3F 00 TT 00*4 02 00*3 02 00*3 03 00*3 1B 00*3 01 00*3 00*16"},
    {0,
     "02 07 42 00",
     "02 07 42 00 1C 00 3F 00 TT 00*4 02 00*3 02 00*3 03 00*3 1B 00*3 01 00*3 00*16"},
    {0, "02 00 43 00 63 00", "02 00 43 00 FF 00 3F 00 TT"},
    {0, "02 07 44 00", "02 07 44 00 FF 00 3F 00 TT"},
};

void replay(UnitBench& bench, const Line& line)
{
    bench.pass(line.wait_ms);
    const std::vector<Bytes> answers = bench.ask(line.to, hex(line.sent));
    // Once the way is open the second unit hears the group, too; the first one answers first.
    ASSERT_GE(answers.size(), 1U) << line.sent;
    ASSERT_LE(answers.size(), line.to == kGroup ? 2U : 1U) << line.sent;
    EXPECT_EQ(hexText(answers[0]), hexText(expected(line.answer, answers[0]))) << line.sent;
    if (line.to != kGroup)
    {
        EXPECT_EQ(bench.lastFrom, 0) << line.sent;
    }
}

TEST(EmulatedUnitBytes, one_session_is_answered_byte_by_byte)
{
    ChainOptions options;
    options.units = 2;
    UnitBench bench(options);
    for (const Line& line : kOpening)
        replay(bench, line);
    replay(bench, {0, ("02 00 07 00 05 42" + widths()).c_str(), "05 00"});
    for (const Line& line : kPlaying)
        replay(bench, line);
    EXPECT_TRUE(bench.chain.unit(0).cpu().fan());
    EXPECT_EQ(bench.report().writesIntoBanks, 0U);
}

} // namespace
} // namespace midair::device::emulation
