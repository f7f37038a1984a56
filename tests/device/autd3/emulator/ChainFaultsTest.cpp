#include "device/DeviceUri.h"
#include "tests/device/autd3/emulator/UnitBench.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace midair::device::emulation
{
namespace
{

ChainOptions parsed(const std::string& parameters)
{
    DeviceUri uri("sim:?" + parameters);
    ChainOptions defaults;
    const ChainOptions options = takeChainOptions(uri, defaults);
    uri.rejectUnknown();
    return options;
}

std::string errorOf(const std::string& parameters)
{
    try
    {
        parsed(parameters);
    }
    catch (const DeviceError& error)
    {
        return error.what();
    }
    return "none";
}

TEST(EmulatedChainFaults, are_read_from_parameters)
{
    const ChainOptions options =
        parsed("units=3&drop=0.25&latency=5ms&version=7&firmware=1.2.3&reboot_at=2s&reboot_unit=2&"
               "unplug_at=1s&error=0.5&error_result=18");
    EXPECT_EQ(options.units, 3);
    EXPECT_EQ(options.protocolVersion, 7);
    EXPECT_EQ(options.firmware[1], 2);
    EXPECT_EQ(options.faults.drop, 0.25);
    EXPECT_EQ(options.faults.latency_ns, 5'000'000);
    EXPECT_EQ(options.faults.errorResult, 18);
    ASSERT_EQ(options.faults.events.size(), 2U);
    EXPECT_EQ(options.faults.events[0].unit, 2);
    EXPECT_EQ(options.faults.events[1].kind, ChainFaults::Kind::UNPLUG);
}

TEST(EmulatedChainFaults, are_refused_by_name)
{
    EXPECT_NE(errorOf("units=65").find("units=65"), std::string::npos) << errorOf("units=65");
    EXPECT_NE(errorOf("firmware=0.10").find("firmware=0.10 should be a version"),
              std::string::npos);
    EXPECT_NE(errorOf("gateware=0.10.256").find("gateware"), std::string::npos);
    EXPECT_NE(errorOf("units=2&reboot_unit=2&reboot_at=1s").find("reboot_unit=2"),
              std::string::npos);
    EXPECT_NE(errorOf("drip=1").find("drip"), std::string::npos);
}

int answersOf(const std::string& parameters, int questions)
{
    UnitBench bench(parsed(parameters));
    int answers = 0;
    for (int i = 0; i < questions; ++i)
    {
        answers += static_cast<int>(bench.ask(kNoId, hex("02 01 01 00")).size());
        bench.pass(1);
    }
    bench.pass(100);
    return answers + static_cast<int>(bench.answers().size());
}

TEST(EmulatedChainFaults, drop_and_duplicate_as_often_as_they_say)
{
    EXPECT_EQ(answersOf("units=1", 1000), 1000);
    EXPECT_EQ(answersOf("units=1&drop=1", 1000), 0);
    EXPECT_NEAR(answersOf("units=1&drop=0.1", 2000), 2000 * 0.81, 5 * 17.5); // both ways; 5 sigma
    EXPECT_EQ(answersOf("units=1&duplicate=1", 1000), 4000);
    EXPECT_EQ(answersOf("units=1&jitter=10ms&reorder=0.5&latency=3ms", 500), 500);
    EXPECT_GT(answersOf("units=1&garbage=1", 500), 900);
}

TEST(EmulatedChainFaults, reordered_datagrams_are_overtaken)
{
    ChainOptions options;
    options.faults.reorder = 0.5;
    options.faults.seed = 2;
    UnitBench bench(options);
    for (int i = 0; i < 64; ++i)
        bench.ask(kNoId, hex(fmt::format("02 01 {:02X} 00", i)));
    bench.pass(10);
    const std::vector<Bytes> answers = bench.answers();
    bool overtaken = false;
    for (std::size_t i = 1; i < answers.size(); ++i)
        overtaken = overtaken || answers[i][2] < answers[i - 1][2];
    EXPECT_TRUE(overtaken);
}

TEST(EmulatedChainFaults, the_answer_to_AssignId_is_lost_but_the_id_taken)
{
    UnitBench bench(parsed("units=1&lost_assignments=1"));
    EXPECT_TRUE(bench.ask(kNoId, hex("02 04 01 00 00 01")).empty());
    EXPECT_TRUE(bench.ask(kNoId, hex("02 04 01 00 00 01")).empty()); // moved
    EXPECT_EQ(bench.askOne(0, "02 01 01 00").at(5), 0);
}

TEST(EmulatedChainFaults, come_at_their_times)
{
    UnitBench bench(
        parsed("units=2&reboot_at=3s&reboot_unit=1&unplug_at=4s&replug_at=5s&hang_at=6s"));
    bench.open();
    EXPECT_EQ(bench.ask(1, hex("02 07 01 00")).size(), 1U);
    bench.pass(3100 - double(bench.now_ns) / 1e6);
    EXPECT_TRUE(bench.ask(1, hex("02 07 01 00")).empty());
    bench.pass(1000);
    EXPECT_TRUE(bench.ask(0, hex("02 07 01 00")).empty());
    bench.pass(1000);
    EXPECT_EQ(bench.ask(0, hex("02 07 01 00")).size(), 1U);
    bench.pass(1000);
    EXPECT_TRUE(bench.ask(0, hex("02 07 01 00")).empty());
}

// A datagram takes (payload + 86) 80 ns on a cable of 100 Mbit/s, and each unit passes it on whole.
TEST(EmulatedChainFaults, the_cable_takes_its_time)
{
    ChainOptions options;
    options.units = 2;
    options.wirePerByte_ns = 80;
    UnitBench bench(options);
    bench.open(); // which waits for nothing, so that its answers come later
    bench.pass(1000);
    bench.answers();
    EXPECT_TRUE(bench.ask(0, hex("02 07 01 00")).empty());
    bench.pass(((4 + 86) + (16 + 86)) * 80e-6 - 1e-5);
    EXPECT_TRUE(bench.answers().empty());
    bench.pass(2e-5);
    EXPECT_EQ(bench.answers().size(), 1U);
}

TEST(EmulatedChainFaults, under_a_flood_memory_is_bounded_and_told)
{
    ChainOptions options;
    options.faults.latency_ns = 10'000 * kMillisecond_ns;
    UnitBench bench(options);
    for (int i = 0; i < 70'000; ++i)
        bench.ask(kNoId, hex("02 01 01 00"));
    EXPECT_EQ(bench.report().tooMany, 70'000U - 65'536U);
}

} // namespace
} // namespace midair::device::emulation
