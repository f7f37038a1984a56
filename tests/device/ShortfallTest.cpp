#include "device/ArrayDevice.h"
#include "device/FieldCounters.h"
#include "device/boards/BoardCodec.h"
#include "tests/device/Fields.h"

#include <gtest/gtest.h>

using namespace midair::device;

TEST(Shortfall, is_told_where_less_than_half_is_played)
{
    DeviceReport report;
    EXPECT_EQ(shortfallOf(report), "");
    report.sent = 1000;
    report.lost = 1000;
    EXPECT_EQ(shortfallOf(report), "0 of 1000 fields were played");
    report.played = 500;
    report.lost = 500;
    EXPECT_EQ(shortfallOf(report), "");
    report.played = 499;
    report.lost = 501;
    EXPECT_EQ(shortfallOf(report), "499 of 1000 fields were played");
    // What newer fields overtake is as it should be on a slow line.
    report.dropped = 900;
    report.played = 100;
    report.lost = 0;
    EXPECT_EQ(shortfallOf(report), "");
    report.sent = report.pending = 1;
    report.dropped = report.played = 0;
    EXPECT_EQ(shortfallOf(report), "");
}

// Sixteen boards are sixteen packets and a commit, each of which arrives whole with 0.8 x 0.8: a
// field in 2,000.
TEST(Shortfall, of_a_simulation_with_faults_is_in_report_and_status)
{
    DeviceLayout layout{64, {}};
    for (int i = 0; i < 64; ++i)
        layout.board.push_back(i / 4);
    const auto device = openDevice("sim:?drop=0.2&corrupt=0.2,null:", layout);
    for (unsigned i = 0; i < 200; ++i)
        device->send(randomField(64, i));
    const DeviceReport report = device->report();
    EXPECT_NE(report.shortfall.find(" of 200 fields were played"), std::string::npos)
        << report.shortfall;
    EXPECT_NE(device->status().find(report.shortfall), std::string::npos) << device->status();
    EXPECT_NE(report.message.find("not played"), std::string::npos) << report.message;
}

TEST(Shortfall, is_none_of_a_mute)
{
    const auto device = openDevice("sim:", {4, {}});
    device->setMuted(true);
    for (int i = 0; i < 10; ++i)
        device->send(evenField(4, 1, 255));
    device->setMuted(false);
    EXPECT_EQ(device->report().shortfall, "");
}

TEST(FieldsPerSecond, are_what_the_line_of_a_board_carries)
{
    const auto carried = [](const std::string& uri, int transducers) {
        return openDevice(uri, {transducers, {}})->ability().fieldsPerSecond;
    };
    EXPECT_EQ(carried("sim:", 64), 0);
    EXPECT_EQ(carried("sim:?fps=400&max-amplitude=0.5", 64), 400);
    EXPECT_NEAR(
        carried("sim:?board=sonicsurface", 256), 88, 4); // 258 bytes at 227.6 to 230.4 kbaud
    EXPECT_NEAR(carried("sim:?board=ultraino", 64), 57, 4);
    EXPECT_NEAR(carried("sim:?board=ultraino", 128), 28, 3);
    EXPECT_GT(carried("sim:?board=openmpd", 256), 10000);
}
