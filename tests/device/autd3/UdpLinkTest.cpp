#include "device/autd3/UdpLink.h"

#include "haptics/base/threads/SteadyClock.h"

#include <thread>

#include <gtest/gtest.h>

using namespace midair::device::autd3;
using midair::base::steadySeconds;

TEST(Autd3UdpLink, addresses_are_read_and_written)
{
    Endpoint endpoint;
    ASSERT_TRUE(parseEndpoint("[::1]:44336", endpoint));
    EXPECT_EQ(endpoint.port, 44336);
    EXPECT_EQ(endpoint.address.back(), 1);
    EXPECT_EQ(endpointText(endpoint), "[::1]:44336");
    for (const char* text : {"",
                             "::1:44336",
                             "[::1]",
                             "[::1]:",
                             "[::1]:0",
                             "[::1]:65536",
                             "[::1]:-1",
                             "[1.2.3.4]:5",
                             "[::1%nothing]:5",
                             "[::g]:5",
                             "[]:5"})
        EXPECT_FALSE(parseEndpoint(text, endpoint)) << text;
    EXPECT_EQ(endpoint.port, 44336); // unchanged
}

TEST(Autd3UdpLink, waits_for_its_time_and_is_woken)
{
    Endpoint group;
    ASSERT_TRUE(parseEndpoint("[::1]:9", group));
    UdpLink link(group);
    Endpoint from;
    std::vector<std::uint8_t> bytes;
    const double before_s = steadySeconds();
    EXPECT_FALSE(link.receive(before_s + 0.02, from, bytes));
    EXPECT_GE(steadySeconds(), before_s + 0.019);
    link.wake();
    EXPECT_FALSE(link.receive(steadySeconds() + 600, from, bytes)); // returns at once
    std::thread other([&] { link.wake(); });
    EXPECT_FALSE(link.receive(steadySeconds() + 600, from, bytes));
    other.join();
}
