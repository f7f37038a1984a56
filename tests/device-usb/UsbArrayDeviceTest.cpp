#include "device/ArrayDevice.h"
#include "device/drive/DriveEncoder.h"
#include "tests/Eventually.h"
#include "tests/device-usb/EmulatedArray.h"
#include "tests/device-usb/Host.h"
#include "tests/device/Fields.h"
#include "tests/device/TestFiles.h"

#include <atomic>
#include <cerrno>
#include <functional>
#include <thread>

#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sys/syscall.h>
#include <unistd.h>

using namespace midair::device;

namespace
{

const DeviceLayout kLayout = {8, {0, 0, 0, 0, 1, 1, 1, 1}};

DeviceLayout fullLayout()
{
    DeviceLayout layout{3984, {}};
    for (int i = 0; i < 3984; ++i)
        layout.board.push_back(i / 249);
    return layout;
}

bool isSilent(const std::vector<std::complex<float>>& q)
{
    return q == std::vector<std::complex<float>>(q.size());
}

bool isSilent(const DriveSignal& signal)
{
    return signal.duty == std::vector<std::uint8_t>(signal.duty.size(), 0);
}

std::string usbError(const DeviceLayout& layout = kLayout)
{
    return openError("usb:", layout);
}

void dropFilePrivileges()
{
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    __user_cap_data_struct data[2] = {};
    ASSERT_EQ(::syscall(SYS_capget, &header, data), 0);
    data[0].effective &= ~((1U << CAP_DAC_OVERRIDE) | (1U << CAP_DAC_READ_SEARCH));
    ASSERT_EQ(::syscall(SYS_capset, &header, data), 0);
}

// sent = played + dropped + lost + refused + pending, whatever happened.
void expectCountersAddUp(const DeviceReport& report)
{
    EXPECT_EQ(report.sent,
              report.played + report.dropped + report.lost + report.refused + report.pending);
}

} // namespace

TEST(UsbArrayDevice, plays_a_field_of_3984_transducers)
{
    EmulatedArray array(fullLayout());
    const auto device = openDevice("usb:", fullLayout());
    EXPECT_TRUE(isSilent(device->played()));
    const DriveSignal field = randomField(3984, 1);
    ASSERT_TRUE(device->send(field));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    EXPECT_EQ(array.playing(), field);
    std::vector<std::complex<float>> q;
    decode(field, q);
    EXPECT_EQ(device->played(), q);
    EXPECT_EQ(device->report().firmware, "1.0.0");
    EXPECT_EQ(device->report().faults, 0U);
}

TEST(UsbArrayDevice, is_found_by_its_serial_number)
{
    EmulatedArray array(kLayout);
    EXPECT_NE(openDevice("usb:A0001", kLayout), nullptr);
    EXPECT_EQ(openError("usb:A0002", kLayout),
              "usb: no array 1209:0001 with serial number \"A0002\" is plugged in");
    EXPECT_EQ(openError("usb:?id=1234:0001", kLayout), "usb: no array 1234:0001 is plugged in");
    EXPECT_EQ(openError("usb:?id=12:1", kLayout),
              "device \"usb:?id=12:1\": id=12:1 should be vendor and product in hexadecimal, such "
              "as 1209:0001");
}

TEST(UsbArrayDevice, sustains_a_stream_where_every_field_is_whole)
{
    EmulatedArray array(fullLayout());
    const auto device = openDevice("usb:", fullLayout());
    for (int i = 0; i < 300; ++i)
    {
        ASSERT_TRUE(device->send(evenField(3984, static_cast<std::uint8_t>(i), 255)));
        const DriveSignal playing = array.playing();
        EXPECT_EQ(playing.phase, std::vector<std::uint8_t>(3984, playing.phase[0])) << i;
        ASSERT_TRUE(i % 10 != 9 || eventually([&] { return device->report().pending == 0; }));
    }
    const DeviceReport report = device->report();
    EXPECT_EQ(report.sent, 300U);
    EXPECT_EQ(report.lost, 0U);
    expectCountersAddUp(report);
    EXPECT_EQ(array.playing().phase[0], 299 % 256); // the newest wins
    EXPECT_EQ(array.firmware().status(EmulatedArray::now_s()).incomplete, 0U);
}

TEST(UsbArrayDevice, is_kept_alive_while_nothing_is_sent)
{
    EmulatedArray array(kLayout);
    const auto device = openDevice("usb:", kLayout);
    ASSERT_TRUE(device->send(evenField(8, 1, 200)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    letPass(0.4); // four times the watchdog's time
    EXPECT_FALSE(isSilent(array.playing()));
    EXPECT_EQ(array.firmware().status(EmulatedArray::now_s()).watchdogs, 0U);
}

TEST(UsbArrayDevice, is_silent_after_closing)
{
    EmulatedArray array(kLayout);
    auto device = openDevice("usb:", kLayout);
    ASSERT_TRUE(device->send(evenField(8, 1, 200)));
    ASSERT_TRUE(eventually([&] { return !isSilent(array.playing()); }));
    device.reset();
    EXPECT_TRUE(isSilent(array.playing()));
    EXPECT_EQ(array.firmware().status(EmulatedArray::now_s()).watchdogs,
              0U); // it was told, not left alone
}

TEST(UsbArrayDevice, is_silent_within_100_ms_of_a_SIGKILL_of_the_host)
{
    EmulatedArray array(kLayout);
    Host host("--host");
    const bool played = eventually([&] { return !isSilent(array.playing()); });
    host.kill();
    const double dead_s = EmulatedArray::now_s(); // no packet came later
    ASSERT_TRUE(played);
    letPass(dead_s + protocol::kWatchdog_s - EmulatedArray::now_s());
    EXPECT_TRUE(isSilent(array.playing()));
    EXPECT_EQ(array.firmware().status(EmulatedArray::now_s()).watchdogs, 1U);
}

// By the order of what the array sees, not by the clock: the mute is there when silence() returns,
// and no field came before it.
TEST(UsbArrayDevice, a_mute_overtakes_fields_that_wait)
{
    EmulatedArray array(kLayout);
    std::atomic<int> fieldsBeforeMute{-1};
    array.onControl = [&](const std::uint8_t* packet)
    {
        if (packet[3] == static_cast<std::uint8_t>(protocol::Type::MUTE) && fieldsBeforeMute < 0)
            fieldsBeforeMute = array.fieldTransfers.load();
    };
    const auto device = openDevice("usb:", kLayout);
    ASSERT_TRUE(device->send(evenField(8, 1, 200)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    array.hangs = 1000; // the pipe is blocked: what is sent now waits
    for (int i = 0; i < 6; ++i)
        ASSERT_TRUE(device->send(evenField(8, 2, 200)));
    ASSERT_TRUE(eventually([&] { return array.hangs < 1000; }));
    EXPECT_EQ(fieldsBeforeMute, -1);
    std::thread([&] { device->silence(); }).join();
    EXPECT_EQ(fieldsBeforeMute, 1);
    EXPECT_TRUE(isSilent(array.playing()));
    array.hangs = 0;
    ASSERT_TRUE(device->send(evenField(8, 3, 200)));
    EXPECT_TRUE(eventually([&] { return array.playing() == evenField(8, 3, 200); }));
    ASSERT_TRUE(eventually([&] { return device->report().pending == 0; }));
    // The first and the last: none of those that waited played in between.
    EXPECT_EQ(array.firmware().status(EmulatedArray::now_s()).played, 2U);
    EXPECT_EQ(device->report().played, 2U);
    expectCountersAddUp(device->report());
}

TEST(UsbArrayDevice, survives_a_stall_and_sends_the_field_again)
{
    EmulatedArray array(kLayout);
    const auto device = openDevice("usb:", kLayout);
    array.stalls = 1;
    ASSERT_TRUE(device->send(randomField(8, 1)));
    ASSERT_TRUE(eventually([&] { return array.playing() == randomField(8, 1); }));
    EXPECT_GE(array.cleared, 1);
    ASSERT_TRUE(eventually([&] { return device->report().pending == 0; }));
    const DeviceReport report = device->report();
    EXPECT_EQ(report.played, 1U);
    EXPECT_EQ(report.faults, 1U);
    EXPECT_EQ(report.message, "stall");
    EXPECT_EQ(report.state, DeviceState::READY);
    expectCountersAddUp(report);
}

TEST(UsbArrayDevice, survives_a_timeout_and_sends_the_field_again)
{
    EmulatedArray array(kLayout);
    const auto device = openDevice("usb:", kLayout);
    array.hangs = 1;
    ASSERT_TRUE(device->send(randomField(8, 1)));
    ASSERT_TRUE(eventually([&] { return array.playing() == randomField(8, 1); }));
    ASSERT_TRUE(eventually([&] { return device->report().pending == 0; }));
    EXPECT_EQ(device->report().message, "timeout");
    EXPECT_EQ(device->report().played, 1U);
    EXPECT_GE(array.discarded, 1);
    expectCountersAddUp(device->report());
}

TEST(UsbArrayDevice, never_plays_the_half_of_a_short_transfer)
{
    EmulatedArray array(fullLayout());
    const auto device = openDevice("usb:", fullLayout());
    ASSERT_TRUE(device->send(evenField(3984, 1, 200)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    array.shorts = 1;
    ASSERT_TRUE(device->send(evenField(3984, 2, 200)));
    ASSERT_TRUE(eventually(
        [&]
        {
            const DriveSignal playing = array.playing();
            EXPECT_EQ(playing.phase, std::vector<std::uint8_t>(3984, playing.phase[0]));
            return playing.phase[0] == 2;
        }));
    ASSERT_TRUE(eventually([&] { return device->report().pending == 0; }));
    EXPECT_EQ(device->report().message, "short transfer");
    EXPECT_EQ(device->report().played, 2U);
    expectCountersAddUp(device->report());
}

class Unplugged : public ::testing::TestWithParam<int>
{
};

TEST_P(Unplugged, comes_back_by_itself_silent_until_the_next_field)
{
    EmulatedArray array(kLayout);
    const auto device = openDevice("usb:", kLayout);
    ASSERT_TRUE(device->send(evenField(8, 1, 200)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    array.hangs = 3; // so that transfers are in flight
    ASSERT_TRUE(device->send(evenField(8, 2, 200)));
    ASSERT_TRUE(eventually([&] { return array.hangs < 3; }));
    array.unplug(GetParam());
    array.hangs = 0;
    ASSERT_TRUE(eventually([&] { return device->report().state == DeviceState::LOST; }));
    EXPECT_FALSE(device->send(evenField(8, 3, 200)));
    EXPECT_TRUE(isSilent(device->played()));
    EXPECT_EQ(device->report().message, "unplugged");
    EXPECT_NE(device->status().find("not there"), std::string::npos) << device->status();

    array.plug();
    ASSERT_TRUE(eventually([&] { return device->report().state == DeviceState::READY; }));
    EXPECT_EQ(device->report().reconnects, 1U);
    EXPECT_TRUE(isSilent(array.playing()));
    ASSERT_TRUE(device->send(evenField(8, 4, 200)));
    EXPECT_TRUE(eventually([&] { return array.playing() == evenField(8, 4, 200); }));
    ASSERT_TRUE(eventually([&] { return device->report().pending == 0; }));
    expectCountersAddUp(device->report());
}

// What in-flight transfers end with on an unplug differs between controllers and from run to run.
INSTANTIATE_TEST_SUITE_P(Endings, Unplugged, ::testing::Values(ESHUTDOWN, EPROTO, EPIPE));

TEST(UsbArrayDevice, waits_for_a_device_when_asked_to)
{
    EmulatedArray array(kLayout);
    array.unplug();
    EXPECT_EQ(usbError(), "usb: no array 1209:0001 is plugged in");
    const auto device = openDevice("usb:?wait=yes", kLayout);
    EXPECT_EQ(device->report().state, DeviceState::LOST);
    EXPECT_FALSE(device->send(evenField(8, 1, 1)));
    array.plug();
    EXPECT_TRUE(eventually([&] { return device->report().state == DeviceState::READY; }));
}

TEST(UsbArrayDevice, ignores_answers_that_are_nonsense_and_gives_the_device_up)
{
    EmulatedArray array(kLayout);
    const auto device = openDevice("usb:", kLayout);
    array.nonsense = true;
    ASSERT_TRUE(eventually([&] { return device->report().state == DeviceState::LOST; }));
    EXPECT_NE(device->report().message.find("no valid answer for 1 s"), std::string::npos)
        << device->report().message;
    EXPECT_GE(device->report().faults, 2U);
    array.nonsense = false;
    EXPECT_TRUE(eventually([&] { return device->report().state == DeviceState::READY; }));
}

TEST(UsbArrayDevice, waits_for_an_answer_that_comes_late)
{
    EmulatedArray array(kLayout);
    const auto device = openDevice("usb:", kLayout);
    array.mute = true;
    ASSERT_TRUE(device->send(evenField(8, 1, 200)));
    letPass(0.7); // what a stopped host doesn't hear
    array.mute = false;
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    EXPECT_EQ(device->report().lost, 0U);
    EXPECT_EQ(device->report().state, DeviceState::READY);
}

TEST(UsbArrayDevice, names_what_keeps_it_from_opening)
{
    EmulatedArray array(kLayout);
    const std::string name = "usb:A0001 at /dev/bus/usb/001/005: ";
    EXPECT_EQ(usbError({8, {}}),
              name + "has 8 transducers on 2 boards, but the array file has 8 on 1");
    array.busyElsewhere = true;
    EXPECT_EQ(usbError(), name + "another program uses it; close that first");
    array.busyElsewhere = false;
    array.mute = true;
    EXPECT_EQ(usbError().find(name + "gives no valid answer"), 0U) << usbError();
    array.mute = false;
    EXPECT_EQ(usbError(), "no error");
}

TEST(UsbArrayDevice, is_for_one_program_at_a_time)
{
    EmulatedArray array(kLayout);
    const auto first = openDevice("usb:", kLayout);
    EXPECT_EQ(usbError(),
              "usb:A0001 at /dev/bus/usb/001/005: another program uses it; close that first");
    ASSERT_TRUE(first->send(evenField(8, 1, 200)));
    EXPECT_TRUE(eventually([&] { return first->report().played == 1; }));
}

TEST(UsbArrayDevice, names_a_wrong_protocol_version)
{
    VirtualFirmware::Options options;
    options.protocolVersion = 2;
    options.firmwareMinor = 7;
    EmulatedArray array(kLayout, options);
    EXPECT_EQ(
        usbError(),
        "usb:A0001 at /dev/bus/usb/001/005: firmware 1.7.0 speaks protocol version 2, this program "
        "speaks 1: update the program");
}

TEST(UsbArrayDevice, names_the_rule_that_gives_permission)
{
    EmulatedArray array(kLayout);
    array.denyPermission();
    std::string error;
    std::thread(
        [&]
        {
            dropFilePrivileges(); // root may open anything; of this thread alone
            error = usbError();
        })
        .join();
    EXPECT_EQ(error,
              "usb: permission denied for /dev/bus/usb/001/005: copy 70-osgmidair.rules, which "
              "osgMidair installs in "
              "lib/udev/rules.d, to /etc/udev/rules.d, run \"udevadm control --reload\" and plug "
              "the array in again");
}

TEST(UsbArrayDevice, reports_that_the_array_got_too_hot)
{
    EmulatedArray array(kLayout);
    const auto device = openDevice("usb:", kLayout);
    ASSERT_TRUE(device->send(evenField(8, 1, 200)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 1; }));
    array.firmware().setTemperature(90, EmulatedArray::now_s());
    ASSERT_TRUE(eventually([&] { return device->report().message == "muted itself: too hot"; }));
    EXPECT_TRUE(isSilent(device->played()));
    EXPECT_EQ(device->report().temperature_C, 90);
    ASSERT_TRUE(device->send(evenField(8, 1, 200)));
    ASSERT_TRUE(eventually([&] { return device->report().lost == 1; }));
    array.firmware().setTemperature(60, EmulatedArray::now_s());
    ASSERT_TRUE(device->send(evenField(8, 1, 200)));
    EXPECT_TRUE(eventually([&] { return device->report().played == 2; }));
}
