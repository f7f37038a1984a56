#include "device/autd3/emulator/EmulatedLink.h"

#include "device/autd3/emulator/RehearsedAutd3.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/device/autd3/emulator/UnitBench.h"

#include <thread>

#include <gtest/gtest.h>

namespace midair::device::emulation
{
namespace
{

TEST(EmulatedUnitLink, answers_come_from_the_address_of_the_id)
{
    EmulatedLink link(std::make_shared<EmulatedUnits>(ChainOptions()));
    autd3::Endpoint from;
    Bytes bytes;
    EXPECT_FALSE(link.receive(0, from, bytes)); // a time that is past doesn't wait
    ASSERT_TRUE(link.sendToGroup(hex("02 03 01 00")));
    ASSERT_TRUE(link.receive(base::steadySeconds() + 5, from, bytes));
    EXPECT_EQ(bytes, hex("02 03 01 00 00"));
    EXPECT_EQ(from, EmulatedLink::addressOf(kNoId));
    ASSERT_TRUE(link.send(from, hex("02 04 02 00 07 01")));
    ASSERT_TRUE(link.receive(base::steadySeconds() + 5, from, bytes));
    EXPECT_EQ(from.address.back(), 7);
    EXPECT_TRUE(link.send(EmulatedLink::addressOf(-1), hex("02 03 01 00"))); // nobody's
    EXPECT_FALSE(link.receive(0, from, bytes));
}

TEST(EmulatedUnitLink, answers_that_take_time_and_wake_end_a_wait)
{
    ChainOptions options;
    options.faults.latency_ns = 20 * kMillisecond_ns;
    EmulatedLink link(std::make_shared<EmulatedUnits>(options));
    autd3::Endpoint from;
    Bytes bytes;
    const double began_s = base::steadySeconds();
    link.sendToGroup(hex("02 03 01 00"));
    EXPECT_TRUE(link.receive(began_s + 10, from, bytes));
    EXPECT_GE(base::steadySeconds() - began_s, 0.04); // there and back
    std::thread other([&] { link.wake(); });
    EXPECT_FALSE(link.receive(began_s + 600, from, bytes));
    other.join();
}

TEST(EmulatedUnitLink, a_full_cable_refuses_until_there_is_room)
{
    ChainOptions options;
    options.wirePerByte_ns = 8'000; // a hundredth of the real rate
    EmulatedLink link(std::make_shared<EmulatedUnits>(options));
    const Bytes bytes(1000, 0);
    int sent = 0;
    while (sent < 1000 && link.send(EmulatedLink::addressOf(3), bytes))
        ++sent;
    EXPECT_LT(sent, 1000);
    autd3::Endpoint from;
    Bytes answer;
    EXPECT_FALSE(link.receive(base::steadySeconds() + 600, from, answer));
    EXPECT_TRUE(link.send(EmulatedLink::addressOf(3), bytes));
}

TEST(RehearsedAutd3, are_in_the_program_that_registers_them_alone)
{
    const DeviceLayout layout{kUnitTransducers, {}};
    try
    {
        openDevice("sim:?board=autd3&units=1", layout);
        FAIL() << "there are no units yet";
    }
    catch (const DeviceError& error)
    {
        const std::string said = error.what();
        for (const char* part : {"midair-device emulate autd3 --units 1 --port 44336",
                                 "autd3:?units=1&group=[::1]:44336"})
            EXPECT_NE(said.find(part), std::string::npos) << said;
    }
    registerRehearsedAutd3();
    const auto device = openDevice("sim:?board=autd3&units=1", layout);
    EXPECT_EQ(device->status().find("sim: "), 0U) << device->status();
}

} // namespace
} // namespace midair::device::emulation
