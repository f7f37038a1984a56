#include "device/JointCommit.h"

#include "device/FieldCounters.h"
#include "device/limits/GuardedDevice.h"
#include "device/opening/MultiDevice.h"
#include "tests/device/Fields.h"

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <thread>

#include <gtest/gtest.h>

using namespace midair::device;

namespace
{

/// Counts what it is told.
struct Told : JointCommit::Device
{
    void commit(const JointCommit&) override { ++commits; }
    void drop(const JointCommit&) override { ++drops; }
    std::shared_ptr<JointCommit::Seat> seat = std::make_shared<JointCommit::Seat>(*this);
    int commits = 0;
    int drops = 0;
};

/// A device whose pieces arrive when the test says so.
class StagingDevice : public ArrayDevice, public JointCommit::Device
{
public:
    ~StagingDevice() override { _seat->close(); }
    bool send(const DriveSignal& signal) override { return sendTogether(signal, nullptr); }
    bool canStage() const override { return true; }
    bool sendTogether(const DriveSignal& signal, const std::shared_ptr<JointCommit>& joint) override
    {
        _counters.change([](DeviceReport& report) { ++report.sent; });
        if (refuses)
        {
            _counters.change([](DeviceReport& report) { ++report.refused; });
            if (joint != nullptr) joint->leave();
            return false;
        }
        if (joint == nullptr)
            play(signal);
        else if (joint->join(_seat))
            _staged = {joint, signal};
        return true;
    }
    void arrive()
    {
        const std::shared_ptr<JointCommit> joint = _staged.first;
        joint->ready(*_seat);
    }
    void commit(const JointCommit& joint) override
    {
        EXPECT_EQ(_staged.first.get(), &joint);
        play(_staged.second);
        ++commits;
    }
    void drop(const JointCommit&) override
    {
        _counters.change([](DeviceReport& report) { ++report.dropped; });
        _staged.first.reset();
    }
    void silence() override
    {
        if (_staged.first != nullptr) std::shared_ptr<JointCommit>(_staged.first)->giveUp();
    }
    std::string status() const override { return "staging"; }
    DeviceReport report() const override { return _counters.report(); }
    std::vector<std::complex<float>> played() const override { return {}; }

    std::vector<int> phases; ///< of the fields that sounded
    int commits = 0;
    int lastDuty = -1;
    bool refuses = false;

private:
    void play(const DriveSignal& signal)
    {
        phases.push_back(signal.phase[0]);
        lastDuty = signal.duty[0];
        _counters.change([](DeviceReport& report) { ++report.played; });
        _staged.first.reset();
    }

    std::pair<std::shared_ptr<JointCommit>, DriveSignal> _staged;
    FieldCounters _counters;
    std::shared_ptr<JointCommit::Seat> _seat = std::make_shared<JointCommit::Seat>(*this);
};

/// Two of them behind guards, as openDevice() makes it.
struct Pair
{
    Pair()
    {
        std::vector<MultiDevice::Part> parts;
        for (int i = 0; i < 2; ++i)
        {
            auto device = std::make_unique<StagingDevice>();
            each[i] = device.get();
            auto guard = std::make_unique<GuardedDevice>(std::move(device), SafetyLimits(), 4);
            guards[i] = guard.get();
            parts.push_back({std::move(guard), 0, 4});
        }
        all = std::make_unique<MultiDevice>(std::move(parts), 4);
    }
    bool send(std::uint8_t phase) { return all->send(evenField(4, phase, 255)); }

    std::array<StagingDevice*, 2> each{};
    std::array<GuardedDevice*, 2> guards{};
    std::unique_ptr<MultiDevice> all;
};

} // namespace

TEST(JointCommit, commits_when_the_last_is_ready)
{
    Told first;
    Told second;
    JointCommit joint(2);
    EXPECT_TRUE(joint.join(first.seat));
    joint.ready(*first.seat);
    joint.ready(*first.seat); // counts once
    EXPECT_EQ(first.commits, 0);
    EXPECT_TRUE(joint.join(second.seat));
    joint.ready(*second.seat);
    joint.ready(*second.seat);
    joint.giveUp(); // too late
    for (const Told* told : {&first, &second})
    {
        EXPECT_EQ(told->commits, 1);
        EXPECT_EQ(told->drops, 0);
    }
}

TEST(JointCommit, waits_for_nobody_who_left)
{
    Told stays;
    Told leaves;
    JointCommit joint(3);
    joint.join(stays.seat);
    joint.join(leaves.seat);
    joint.ready(*stays.seat);
    joint.leave(leaves.seat.get());
    joint.leave(leaves.seat.get()); // counts once
    EXPECT_EQ(stays.commits, 0);
    joint.leave(); // one that never came
    EXPECT_EQ(stays.commits, 1);
    EXPECT_EQ(leaves.commits + leaves.drops, 0);
}

TEST(JointCommit, does_not_count_twice_who_leaves_when_ready)
{
    Told waits;
    Told leaves;
    JointCommit joint(2);
    joint.join(waits.seat);
    joint.join(leaves.seat);
    joint.ready(*leaves.seat);
    joint.leave(leaves.seat.get());
    EXPECT_EQ(waits.commits, 0);
    joint.ready(*waits.seat);
    EXPECT_EQ(waits.commits, 1);
    EXPECT_EQ(leaves.commits, 0);
}

TEST(JointCommit, drops_with_all_what_one_gives_up)
{
    Told ready;
    Told waits;
    Told late;
    JointCommit joint(3);
    joint.join(ready.seat);
    joint.join(waits.seat);
    joint.ready(*ready.seat);
    joint.giveUp();
    joint.giveUp();
    EXPECT_FALSE(joint.join(late.seat));
    joint.ready(*waits.seat);
    joint.leave();
    for (const Told* told : {&ready, &waits})
    {
        EXPECT_EQ(told->commits, 0);
        EXPECT_EQ(told->drops, 1);
    }
    EXPECT_EQ(late.drops, 0);
}

TEST(JointCommit, measures_how_far_apart_all_of_its_devices_committed)
{
    const auto meter = std::make_shared<SkewMeter>();
    JointCommit wide(3, meter);
    wide.handedOver(12);
    wide.handedOver(10);
    EXPECT_EQ(meter->read().last_s, 0); // the third is still to come
    wide.handedOver(11);
    EXPECT_EQ(meter->read().last_s, 2);
    JointCommit narrow(2, meter);
    narrow.handedOver(20);
    narrow.handedOver(20.5);
    EXPECT_EQ(meter->read().last_s, 0.5);
    EXPECT_EQ(meter->read().worst_s, 2);
    JointCommit left(2, meter);
    left.leave();
    left.handedOver(30);
    EXPECT_EQ(meter->read().last_s, 0.5);
}

TEST(JointCommit, tells_nothing_to_a_device_that_is_gone)
{
    Told stays;
    JointCommit joint(2);
    joint.join(stays.seat);
    {
        auto gone = std::make_unique<Told>();
        const auto seat = gone->seat;
        joint.join(seat);
        joint.ready(*seat);
        seat->close();
        gone.reset();
    }
    joint.ready(*stays.seat);
    EXPECT_EQ(stays.commits, 1);
}

// Four threads, one for each device, go through the same joints; what they do in each is random.
// All who stay are told the same.
TEST(JointCommit, ends_alike_for_all_on_several_threads)
{
    constexpr int kDevices = 4;
    constexpr int kJoints = 2000;
    enum Ending
    {
        NONE,
        COMMITTED,
        DROPPED,
        LEFT
    };
    struct Device : JointCommit::Device
    {
        void commit(const JointCommit& joint) override { tell(joint, COMMITTED); }
        void drop(const JointCommit& joint) override { tell(joint, DROPPED); }
        void tell(const JointCommit& joint, Ending ending)
        {
            const std::lock_guard<std::mutex> lock(mutex);
            endings[&joint].push_back(ending);
        }
        std::mutex mutex;
        std::map<const JointCommit*, std::vector<Ending>> endings;
        std::shared_ptr<JointCommit::Seat> seat = std::make_shared<JointCommit::Seat>(*this);
    };
    std::vector<std::unique_ptr<JointCommit>> joints;
    for (int i = 0; i < kJoints; ++i)
        joints.push_back(std::make_unique<JointCommit>(kDevices));
    std::array<Device, kDevices> devices;
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < kDevices; ++i)
        threads.emplace_back(
            [&, i]
            {
                std::minstd_rand random(i + 1);
                for (const auto& joint : joints)
                {
                    const unsigned what = random() % 16;
                    if (!joint->join(devices[i].seat))
                        devices[i].tell(*joint, DROPPED);
                    else if (what == 0)
                        joint->giveUp();
                    else if (what < 3)
                    {
                        devices[i].tell(*joint, LEFT);
                        joint->leave(devices[i].seat.get());
                    }
                    else
                        joint->ready(*devices[i].seat);
                }
            });
    for (std::thread& thread : threads)
        thread.join();
    std::array<int, 4> count{};
    for (const auto& joint : joints)
    {
        std::array<int, 4> ended{};
        for (Device& device : devices)
        {
            const std::vector<Ending>& endings = device.endings[joint.get()];
            ASSERT_FALSE(endings.empty());
            // Another may give up just before one leaves.
            const auto lefts = std::count(endings.begin(), endings.end(), LEFT);
            ASSERT_LE(static_cast<long>(endings.size()) - lefts, 1);
            for (const Ending ending : endings)
                ++ended[ending];
        }
        EXPECT_TRUE(ended[COMMITTED] == 0 || ended[DROPPED] == 0);
        for (std::size_t k = 0; k < count.size(); ++k)
            count[k] += ended[k];
    }
    EXPECT_GT(count[COMMITTED], kJoints);
    EXPECT_GT(count[DROPPED], 0);
}

// A device closes its seat while another's thread commits: what it is told, it is told before that.
TEST(JointCommit, lets_a_device_end_at_any_time)
{
    for (int round = 0; round < 200; ++round)
    {
        Told stays;
        auto ends = std::make_unique<Told>();
        auto joint = std::make_shared<JointCommit>(2);
        joint->join(stays.seat);
        joint->join(ends->seat);
        joint->ready(*ends->seat);
        std::thread other([joint, &stays] { joint->ready(*stays.seat); });
        ends->seat->close();
        ends.reset();
        other.join();
        EXPECT_EQ(stays.commits, 1);
    }
}

TEST(MultiDeviceTogether, plays_when_all_have_their_piece)
{
    Pair pair;
    ASSERT_TRUE(pair.send(1));
    pair.each[1]->arrive();
    EXPECT_TRUE(pair.each[1]->phases.empty());
    pair.each[0]->arrive();
    for (const StagingDevice* device : pair.each)
    {
        EXPECT_EQ(device->phases, std::vector<int>{1});
        EXPECT_EQ(device->commits, 1);
    }
}

TEST(MultiDeviceTogether, does_not_stage_for_one_alone)
{
    auto device = std::make_unique<StagingDevice>();
    const StagingDevice& inner = *device;
    std::vector<MultiDevice::Part> parts;
    parts.push_back({std::move(device), 0, 4});
    parts.push_back({openDevice("null:", {4, {}}), 0, 4});
    MultiDevice all(std::move(parts), 4);
    ASSERT_TRUE(all.send(evenField(4, 1, 255)));
    EXPECT_EQ(inner.phases, std::vector<int>{1});
    EXPECT_EQ(inner.commits, 0);
}

TEST(MultiDeviceTogether, does_not_wait_for_one_that_refuses)
{
    Pair pair;
    pair.each[0]->refuses = true;
    EXPECT_FALSE(pair.send(1));
    pair.each[1]->arrive();
    EXPECT_EQ(pair.each[1]->phases, std::vector<int>{1});
    pair.each[0]->refuses = false;
    pair.guards[0]->setMuted(true);
    EXPECT_FALSE(pair.send(2));
    pair.each[1]->arrive();
    EXPECT_EQ(pair.each[1]->phases, (std::vector<int>{1, 2}));
    EXPECT_TRUE(pair.each[0]->phases.empty());
    const DeviceReport report = pair.all->report();
    EXPECT_EQ(report.refused, 2U);
    EXPECT_EQ(report.sent, report.played + report.refused);
}

TEST(MultiDeviceTogether, silences_what_is_staged)
{
    Pair pair;
    ASSERT_TRUE(pair.send(1));
    pair.each[0]->arrive();
    pair.all->silence();
    ASSERT_TRUE(pair.send(2));
    pair.each[0]->arrive();
    pair.each[1]->arrive();
    for (const StagingDevice* device : pair.each)
        EXPECT_EQ(device->phases, std::vector<int>{2});
    EXPECT_EQ(pair.all->report().dropped, 2U);
}

TEST(GuardedDevice, limits_what_is_staged)
{
    auto device = std::make_unique<StagingDevice>();
    StagingDevice& inner = *device;
    SafetyLimits limits;
    limits.maxAmplitude = 0;
    GuardedDevice guard(std::move(device), limits, 4);
    EXPECT_TRUE(guard.canStage());
    const auto joint = std::make_shared<JointCommit>(1);
    ASSERT_TRUE(guard.sendTogether(evenField(4, 3, 255), joint));
    EXPECT_TRUE(inner.phases.empty());
    inner.arrive();
    EXPECT_EQ(inner.phases, std::vector<int>{3});
    EXPECT_EQ(inner.commits, 1);
    EXPECT_EQ(inner.lastDuty, 0);
}
