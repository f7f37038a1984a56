#include "device/JointCommit.h"
#include "device/usb/UsbArrayDevice.h"
#include "tests/Eventually.h"
#include "tests/device-usb/EmulatedArray.h"
#include "tests/device/Fields.h"

#include <array>
#include <mutex>
#include <vector>

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

const DeviceLayout kHalf = {8, {0, 0, 0, 0, 1, 1, 1, 1}};
const DeviceLayout kWhole = {16, {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3}};
const std::string kUri = "usb:A0001?boards=0-1,usb:A0002?boards=2-3";

/// Two halves of an array on two ports, and what came to them in which order: data and commits of
/// fields by their first phase.
struct TwoArrays : ::testing::Test
{
    enum class What
    {
        DATA,
        COMMIT,
        TAKEN_BACK
    };
    struct Event
    {
        What what;
        int array;
        int field; ///< its phase; -1 where the packet doesn't say
    };

    TwoArrays()
    {
        for (int i = 0; i < 2; ++i)
        {
            const auto log = [this, i](What what)
            {
                return [this, i, what](const std::uint8_t* bytes)
                {
                    const std::lock_guard<std::mutex> lock(_mutex);
                    const int field = what == What::COMMIT ? _last[i] : bytes[16];
                    if (what == What::DATA) _last[i] = field;
                    _events.push_back({what, i, field});
                };
            };
            half(i).onField = log(What::DATA);
            half(i).onCommit = log(What::COMMIT);
            half(i).onDiscarded = log(What::TAKEN_BACK);
        }
        device = openDevice(kUri, kWhole);
    }

    EmulatedArray& half(int i) { return i == 0 ? first : second; }

    std::vector<Event> events()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _events;
    }

    bool settles()
    {
        return eventually([&] { return device->report().pending == 0; });
    }

    // By phases, which a watchdog leaves alone.
    bool plays(int i, int field)
    {
        const std::vector<std::uint8_t> phases(8, static_cast<std::uint8_t>(field));
        return eventually([&] { return half(i).playing().phase == phases; });
    }
    bool play(int field) { return plays(0, field) && plays(1, field); }

    bool send(int field)
    {
        return device->send(evenField(16, static_cast<std::uint8_t>(field), 200));
    }

    /// Whether there were \a count faults. A host whose threads don't run for 0.1 s finds the
    /// arrays muted by their watchdogs as well.
    bool hasOnlyFaults(std::uint64_t count)
    {
        const DeviceReport report = device->report();
        const bool isMuted = report.message.find("watchdog") != std::string::npos;
        return report.faults == count || (report.faults > count && isMuted);
    }

    void expectCountersAddUp()
    {
        const DeviceReport report = device->report();
        EXPECT_EQ(report.sent,
                  report.played + report.dropped + report.lost + report.refused + report.pending);
    }

private:
    std::mutex _mutex; // with what follows before the arrays, which write there until they end
    std::vector<Event> _events;
    std::array<int, 2> _last{-1, -1};

public:
    EmulatedArray first{kHalf, {}, 1};
    EmulatedArray second{kHalf, {}, 2};
    std::unique_ptr<ArrayDevice> device;
};

} // namespace

TEST_F(TwoArrays, commit_a_field_when_both_have_it)
{
    for (int field = 1; field <= 20; ++field)
    {
        ASSERT_TRUE(send(field));
        ASSERT_TRUE(play(field));
    }
    ASSERT_TRUE(settles());
    std::array<int, 2> data{};
    std::array<int, 2> commits{};
    for (const Event& event : events())
    {
        if (event.what == What::DATA) data[event.array] = event.field;
        if (event.what != What::COMMIT) continue;
        ++commits[event.array];
        EXPECT_EQ(data[0], event.field);
        EXPECT_EQ(data[1], event.field);
    }
    EXPECT_EQ(commits, (std::array<int, 2>{20, 20}));
    EXPECT_EQ(device->report().played, 40U);
    EXPECT_TRUE(hasOnlyFaults(0));
    EXPECT_GT(device->report().worstSkew_s, 0);
}

TEST_F(TwoArrays, play_the_same_fields_of_a_stream)
{
    constexpr int kFields = 200;
    for (int field = 1; field <= kFields; ++field)
    {
        ASSERT_TRUE(send(field));
        ASSERT_TRUE(field % 10 != 0 || settles());
    }
    ASSERT_TRUE(settles());
    ASSERT_TRUE(play(kFields)); // the newest wins
    std::array<std::vector<int>, 2> played;
    for (const Event& event : events())
        if (event.what == What::COMMIT) played[event.array].push_back(event.field);
    EXPECT_EQ(played[0], played[1]);
    EXPECT_GT(played[0].size(), 1U);
    const DeviceReport report = device->report();
    EXPECT_EQ(report.sent, 2U * kFields);
    EXPECT_EQ(report.lost, 0U);
    EXPECT_EQ(report.played, 2 * played[0].size());
    expectCountersAddUp();
    for (int i = 0; i < 2; ++i)
        EXPECT_EQ(half(i).firmware().status(EmulatedArray::now_s()).incomplete, 0U);
}

TEST_F(TwoArrays, wait_for_the_slower_of_them)
{
    ASSERT_TRUE(send(1));
    ASSERT_TRUE(play(1));
    second.hangs = 1;
    ASSERT_TRUE(send(2));
    ASSERT_TRUE(eventually([&] { return first.fieldTransfers == 2 && second.hangs == 0; }));
    ASSERT_TRUE(send(3)); // wait for the commit of 2
    ASSERT_TRUE(send(4));
    second.letGo();
    ASSERT_TRUE(play(4));
    ASSERT_TRUE(settles());
    // 2 sounds when the slow one has it or the host has lost patience with that, never before; 3
    // was overtaken.
    std::vector<int> played;
    bool has = false;
    for (const Event& event : events())
    {
        has = has || (event.array == 1 && event.field == 2 && event.what != What::COMMIT);
        if (event.what != What::COMMIT || event.array != 0) continue;
        EXPECT_TRUE(has || event.field != 2);
        played.push_back(event.field);
    }
    if (device->report().faults == 0) // the host had patience
    {
        EXPECT_EQ(played, (std::vector<int>{1, 2, 4}));
        EXPECT_EQ(device->report().dropped, 2U);
        EXPECT_EQ(device->report().played, 6U);
    }
    expectCountersAddUp();
}

TEST_F(TwoArrays, drop_a_field_that_waits_when_silenced)
{
    second.hangs = 1;
    ASSERT_TRUE(send(1));
    ASSERT_TRUE(eventually([&] { return first.fieldTransfers == 1 && second.hangs == 0; }));
    device->silence();
    ASSERT_TRUE(settles());
    ASSERT_TRUE(send(2));
    ASSERT_TRUE(play(2));
    ASSERT_TRUE(settles());
    if (device->report().faults == 0) // 1 was still held back
    {
        EXPECT_EQ(device->report().dropped, 2U);
        EXPECT_EQ(first.firmware().status(EmulatedArray::now_s()).played, 1U);
        EXPECT_EQ(second.firmware().status(EmulatedArray::now_s()).played, 1U);
    }
    expectCountersAddUp();
}

TEST_F(TwoArrays, play_on_when_one_stalls)
{
    second.stalls = 1;
    ASSERT_TRUE(send(1));
    ASSERT_TRUE(play(1)); // the second one as sent again
    second.stalledCommits = 1;
    ASSERT_TRUE(send(2));
    ASSERT_TRUE(play(2));
    ASSERT_TRUE(settles());
    EXPECT_EQ(device->report().played, 4U);
    EXPECT_TRUE(hasOnlyFaults(2));
    EXPECT_GE(second.cleared, 2);
    expectCountersAddUp();
}

TEST_F(TwoArrays, play_on_when_one_times_out)
{
    second.hangs = 1;
    ASSERT_TRUE(send(1));
    ASSERT_TRUE(play(1));
    ASSERT_TRUE(settles());
    EXPECT_EQ(device->report().played, 2U);
    EXPECT_EQ(device->report().message, "timeout");
    expectCountersAddUp();
}

TEST_F(TwoArrays, play_on_when_one_is_unplugged)
{
    second.hangs = 1;
    ASSERT_TRUE(send(1));
    ASSERT_TRUE(eventually([&] { return first.fieldTransfers == 1 && second.hangs == 0; }));
    second.unplug();
    ASSERT_TRUE(plays(0, 1));
    ASSERT_TRUE(eventually([&] { return device->report().state == DeviceState::LOST; }));
    EXPECT_FALSE(send(2)); // not by all of them
    ASSERT_TRUE(plays(0, 2));
    second.plug();
    ASSERT_TRUE(eventually([&] { return device->report().state == DeviceState::READY; }));
    ASSERT_TRUE(send(3));
    ASSERT_TRUE(play(3));
    ASSERT_TRUE(settles());
    EXPECT_EQ(device->report().refused, 1U);
    expectCountersAddUp();
}

TEST_F(TwoArrays, play_on_when_one_does_not_answer)
{
    second.mute = true;
    for (int field = 1; field <= 12; ++field) // more than may be unconfirmed
    {
        send(field);
        ASSERT_TRUE(plays(0, field));
    }
    EXPECT_EQ(device->report().state, DeviceState::READY); // long before it is given up
    second.mute = false;
    ASSERT_TRUE(settles());
    expectCountersAddUp();
}

// Each guard sends its half again and again, with more of it each time; these fields wait for
// nobody, but overtake none either.
TEST_F(TwoArrays, play_together_while_their_guards_ramp)
{
    device.reset();
    device = openDevice("usb:A0001?boards=0-1&ramp=200ms,usb:A0002?boards=2-3&ramp=200ms", kWhole);
    for (int field = 1; field <= 20; ++field)
    {
        second.hangs = 1;
        ASSERT_TRUE(send(field));
        ASSERT_TRUE(eventually([&] { return second.hangs == 0; }));
        ASSERT_TRUE(send(100 + field));
        second.letGo();
        ASSERT_TRUE(play(100 + field)) << device->status();
    }
    ASSERT_TRUE(settles());
    expectCountersAddUp();
}

TEST_F(TwoArrays, are_silent_after_closing_while_a_field_waits)
{
    ASSERT_TRUE(send(1));
    ASSERT_TRUE(play(1));
    second.hangs = 1;
    ASSERT_TRUE(send(2));
    device.reset();
    const std::vector<std::uint8_t> off(8, 0);
    EXPECT_EQ(first.playing().duty, off);
    EXPECT_EQ(second.playing().duty, off);
}

/// Both by themselves, without what holds them together.
struct TwoDevices : ::testing::Test
{
    using Joint = std::shared_ptr<JointCommit>;

    static UsbArrayDevice::Options options(const std::string& serial)
    {
        UsbArrayDevice::Options options;
        options.address.serial = serial;
        return options;
    }
    static DriveSignal field(std::uint8_t phase) { return evenField(8, phase, 200); }
    static bool plays(EmulatedArray& array, std::uint8_t phase)
    {
        return eventually([&] { return array.playing().phase == field(phase).phase; });
    }
    static bool settles(const UsbArrayDevice& device)
    {
        return eventually([&] { return device.report().pending == 0; });
    }
    /// Sends a field that waits for the test, and lets the thread of its device take it up.
    static void
    hold(UsbArrayDevice& device, EmulatedArray& array, std::uint8_t phase, const Joint& held)
    {
        const int before = array.fieldTransfers;
        ASSERT_TRUE(device.sendTogether(field(phase), held));
        ASSERT_TRUE(eventually([&] { return array.fieldTransfers == before + 1; }));
    }

    EmulatedArray first{kHalf, {}, 1};
    EmulatedArray second{kHalf, {}, 2};
    UsbArrayDevice one{kHalf, options("A0001")};
    UsbArrayDevice other{kHalf, options("A0002")};
};

TEST_F(TwoDevices, drop_what_is_staged_in_one_and_overtaken_in_the_other)
{
    const auto held = std::make_shared<JointCommit>(2); // the test is the second in it
    hold(other, second, 1, held);
    const auto overtaken = std::make_shared<JointCommit>(2);
    ASSERT_TRUE(one.sendTogether(field(2), overtaken));   // under way
    ASSERT_TRUE(other.sendTogether(field(2), overtaken)); // waits behind 1
    ASSERT_TRUE(eventually([&] { return first.fieldTransfers == 1; }));
    const auto newest = std::make_shared<JointCommit>(2);
    ASSERT_TRUE(other.sendTogether(field(3), newest));
    EXPECT_EQ(one.report().dropped, 1U);
    EXPECT_EQ(one.report().pending, 0U);
    ASSERT_TRUE(one.sendTogether(field(3), newest));
    ASSERT_TRUE(eventually([&] { return first.fieldTransfers == 2; }));
    EXPECT_EQ(first.firmware().status(EmulatedArray::now_s()).played, 0U);
    held->leave();
    ASSERT_TRUE(plays(first, 3));
    ASSERT_TRUE(plays(second, 3));
    ASSERT_TRUE(settles(one));
    ASSERT_TRUE(settles(other));
    EXPECT_EQ(one.report().played, 1U);
    EXPECT_EQ(other.report().played, 2U);
    EXPECT_EQ(other.report().dropped, 1U);
}

TEST_F(TwoDevices, let_a_field_sent_again_take_the_place_of_the_first)
{
    const auto held = std::make_shared<JointCommit>(2);
    hold(one, first, 1, held);
    const auto next = std::make_shared<JointCommit>(2);
    ASSERT_TRUE(one.sendTogether(field(2), next));
    ASSERT_TRUE(one.send(field(3))); // as a guard does, with another gain
    ASSERT_TRUE(other.sendTogether(field(2), next));
    ASSERT_TRUE(eventually([&] { return second.fieldTransfers == 1; }));
    EXPECT_EQ(second.firmware().status(EmulatedArray::now_s()).played, 0U);
    held->leave();
    ASSERT_TRUE(plays(first, 3));
    ASSERT_TRUE(plays(second, 2));
    ASSERT_TRUE(settles(one));
    EXPECT_EQ(one.report().played, 2U);
    EXPECT_EQ(one.report().dropped, 1U);
}

TEST_F(TwoDevices, drop_a_field_that_was_given_up_before)
{
    const auto joint = std::make_shared<JointCommit>(2);
    joint->giveUp();
    ASSERT_TRUE(one.sendTogether(field(1), joint));
    EXPECT_EQ(one.report().dropped, 1U);
    EXPECT_EQ(one.report().pending, 0U);
    EXPECT_EQ(first.fieldTransfers, 0);
}

TEST(TwoArraysAlone, one_that_can_wait_for_no_other_gets_a_field_in_one_transfer)
{
    EmulatedArray array(kHalf);
    std::atomic<int> commits{0};
    array.onCommit = [&](const std::uint8_t*) { ++commits; };
    const auto device = openDevice("usb:,null:", kHalf);
    ASSERT_TRUE(device->send(evenField(8, 1, 200)));
    ASSERT_TRUE(eventually([&] { return device->report().played == 2; }));
    EXPECT_EQ(commits, 0);
    EXPECT_EQ(array.fieldTransfers, 1);
}
