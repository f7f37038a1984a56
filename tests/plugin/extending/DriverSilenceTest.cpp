// A driver whose silence() throws, whose other calls do, and one that is lost: what the kit says of
// them, and how often it calls them.
#include "engine-bridge/extending/DriverDevice.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/DeviceCallback>
#include <osgMidair/DeviceDriver>

#include <algorithm>
#include <atomic>
#include <stdexcept>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// What the driver below should do, and what became of it.
struct Board
{
    std::atomic<int> failures{0}; ///< so many times silence() throws
    std::atomic<bool> lost{false};
    std::atomic<bool> readyThrows{false};
    std::atomic<bool> statusThrows{false};
    std::atomic<bool> sounds{false};
    std::atomic<int> plays{0};
    std::atomic<int> silences{0};
    std::atomic<bool> isBack{false};     ///< after a loss, and neither silenced nor played since
    std::atomic<int> unsilencedPlays{0}; ///< first fields after a loss without a silence() before
};

constexpr int kForever = 1000000;

class StubbornDriver : public DeviceDriver
{
public:
    explicit StubbornDriver(Board& board) : _board(board) {}
    bool open(const std::string&,
              const std::map<std::string, std::string>&,
              const Layout&,
              std::string&) override
    {
        return true;
    }
    bool play(const unsigned char*, const unsigned char*) override
    {
        ++_board.plays;
        _board.sounds = true;
        if (_board.isBack.exchange(false)) ++_board.unsilencedPlays;
        return true;
    }
    void silence() override
    {
        ++_board.silences;
        if (_board.failures > 0)
        {
            --_board.failures;
            throw std::runtime_error("the line is cut");
        }
        _board.sounds = false;
        _board.isBack = false;
    }
    bool isReady() const override
    {
        if (_board.readyThrows) throw std::runtime_error("no answer");
        if (_wasLost.exchange(_board.lost) && !_wasLost) _board.isBack = true;
        return !_wasLost;
    }
    std::string getStatus() const override
    {
        if (_board.statusThrows) throw std::runtime_error("no thermometer");
        return "board fine";
    }

private:
    Board& _board;
    mutable std::atomic<bool> _wasLost{false};
};

/// The last change of the array's state.
struct LastChange : DeviceCallback
{
    void changed(const DeviceChange& change) override { last = change; }
    DeviceChange last;
};

class DeviceDriverSilence : public testing::Test
{
public:
    DeviceDriverSilence()
    {
        static const bool registered = []
        {
            std::string error;
            return registerDevice(
                "stubborn",
                [] { return osg::ref_ptr<DeviceDriver>(new StubbornDriver(*driven())); },
                error);
        }();
        EXPECT_TRUE(registered);
        driven() = &board;
        box->scene->setDevice("stubborn:desk");
        box->scene->setDeviceCallback(change);
        viewer = std::make_unique<HeadlessViewer>(box->scene);
    }
    ~DeviceDriverSilence() override
    {
        board.failures = 0;
        end();
    }

    static Board*& driven()
    {
        static Board* board = nullptr;
        return board;
    }

    void end()
    {
        viewer = nullptr;
        box = nullptr;
    }
    HapticStatistics now() const { return box->scene->getStatistics(); }
    bool comesTo(ArrayState state)
    {
        return viewer->framesUntil([&] { return now().state == state; });
    }
    /// The driver has its field: the scene plays as soon as it is on its way there.
    bool comesToSound()
    {
        return comesTo(ArrayState::PLAYING) &&
               viewer->framesUntil([&] { return board.sounds.load(); });
    }
    /// How often a message with \a code and \a part in it was said.
    std::uint64_t told(const std::string& code, const std::string& part) const
    {
        std::uint64_t count = 0;
        for (const HapticMessage& one : now().told)
            if (one.code == code && one.text.find(part) != std::string::npos) count += one.count;
        return count;
    }

    Board board; // outlives the scene and its driver
    const osg::ref_ptr<LastChange> change = new LastChange;
    std::unique_ptr<BoxScene> box = std::make_unique<BoxScene>();
    std::unique_ptr<HeadlessViewer> viewer;
};

constexpr const char* kMayPlayOn =
    "device: the driver couldn't silence the array (the driver's silence() has thrown \"the line "
    "is cut\"); it may play on";

} // namespace

TEST_F(DeviceDriverSilence, AMuteThatFailsIsAFaultUntilItIsWritten)
{
    ASSERT_TRUE(comesToSound());
    board.failures = kForever;
    box->scene->setMuted(true);
    EXPECT_TRUE(comesTo(ArrayState::FAULT));
    EXPECT_TRUE(viewer->framesUntil([&] { return change->last.now == ArrayState::FAULT; }));
    EXPECT_NE(change->last.status.find("stubborn:desk: not silenced: "), std::string::npos)
        << change->last.status;
    EXPECT_TRUE(viewer->framesUntil([&] { return told("device.fault", kMayPlayOn) > 0; }));
    const int silences = board.silences;
    EXPECT_TRUE(viewer->framesUntil([&] { return board.silences >= silences + 3; }));
    EXPECT_EQ(told("device.fault", ""), 1u) << "once, however often it is tried";
    EXPECT_EQ(now().state, ArrayState::FAULT);
    EXPECT_TRUE(board.sounds);
    board.failures = 0;
    EXPECT_TRUE(comesTo(ArrayState::MUTED));
    EXPECT_FALSE(board.sounds);
    EXPECT_TRUE(viewer->framesUntil([&] { return change->last.now == ArrayState::MUTED; }));
    EXPECT_EQ(now().fields.faults, 1u);
}

TEST_F(DeviceDriverSilence, ADisabledSceneThatStillSoundsIsAFault)
{
    ASSERT_TRUE(comesToSound());
    board.failures = kForever;
    box->scene->setEnabled(false);
    EXPECT_TRUE(comesTo(ArrayState::FAULT));
    EXPECT_TRUE(viewer->framesUntil([&] { return told("device.fault", kMayPlayOn) == 1; }));
    board.failures = 0;
    EXPECT_TRUE(comesTo(ArrayState::SILENT));
    EXPECT_FALSE(board.sounds);
}

TEST_F(DeviceDriverSilence, NoFieldIsPlayedBeforeItIsWritten)
{
    ASSERT_TRUE(comesToSound());
    board.failures = kForever;
    box->scene->setMuted(true);
    ASSERT_TRUE(comesTo(ArrayState::FAULT));
    const int plays = board.plays;
    box->scene->setMuted(false);
    const int silences = board.silences;
    for (int k = 1; board.silences < silences + 4; ++k) // else ctest ends it
    {
        box->move(1e-4 * (k % 100));
        viewer->frame();
    }
    EXPECT_EQ(board.plays, plays);
    EXPECT_EQ(now().state, ArrayState::FAULT);
    board.failures = 0;
    EXPECT_TRUE(viewer->framesUntil([&] { return board.plays > plays; }));
    EXPECT_TRUE(comesTo(ArrayState::PLAYING));
}

TEST_F(DeviceDriverSilence, OneThatFailsAtTheEndIsTold)
{
    ASSERT_TRUE(comesToSound());
    board.failures = kForever;
    const int silences = board.silences;
    Notices notices;
    end();
    EXPECT_GE(board.silences, silences + midair::bridge::DueSilence::kLastTries);
    EXPECT_NE(notices.text().find("stubborn:desk: the driver couldn't silence the array (the "
                                  "driver's silence() has thrown \"the line is cut\"); it may play "
                                  "on; it is closed anyway"),
              std::string::npos)
        << notices.text();
}

TEST_F(DeviceDriverSilence, OneThatFailsAtTheEndIsTriedAgain)
{
    ASSERT_TRUE(comesToSound());
    board.failures = 3;
    Notices notices;
    end();
    EXPECT_EQ(board.failures, 0);
    EXPECT_FALSE(board.sounds);
    EXPECT_EQ(notices.text().find("it is closed anyway"), std::string::npos) << notices.text();
}

TEST_F(DeviceDriverSilence, WhatGetStatusThrowsIsToldOnceAndThePlayGoesOn)
{
    box->scene->setEven(0); // the field is held as it is
    ASSERT_TRUE(comesToSound());
    const int plays = board.plays;
    board.statusThrows = true;
    EXPECT_TRUE(viewer->framesUntil(
        [&]
        {
            return told("callback.threw",
                        "device: the driver's getStatus() has thrown \"no thermometer\"") > 0;
        }));
    const double end_s = midair::base::steadySeconds() + 1.0; // in which it is asked five times
    viewer->framesUntil([&] { return midair::base::steadySeconds() > end_s; });
    EXPECT_EQ(told("callback.threw", ""), 1u);
    EXPECT_EQ(now().state, ArrayState::PLAYING);
    EXPECT_EQ(now().fields.faults, 1u);
    EXPECT_LE(board.plays, plays + 2) << "the field that is held isn't sent for each";
}

TEST_F(DeviceDriverSilence, WhatIsReadyThrowsIsToldAlsoOfASilentArray)
{
    ASSERT_TRUE(comesToSound());
    box->scene->setEnabled(false);
    ASSERT_TRUE(comesTo(ArrayState::SILENT));
    board.readyThrows = true;
    EXPECT_TRUE(comesTo(ArrayState::LOST));
    EXPECT_TRUE(viewer->framesUntil(
        [&]
        {
            return told("device.lost",
                        "device: lost: the driver's isReady() has thrown \"no answer\"") == 1;
        }));
    const double end_s = midair::base::steadySeconds() + 1.0;
    viewer->framesUntil([&] { return midair::base::steadySeconds() > end_s; });
    EXPECT_EQ(told("device.lost", ""), 1u);
    EXPECT_EQ(now().fields.faults, 1u) << "one loss is one fault";
}

TEST_F(DeviceDriverSilence, OfALostDriverIsAskedForSeldomAndBeforeTheFirstField)
{
    ASSERT_TRUE(comesToSound());
    const int before = board.silences;
    const double lost_s = midair::base::steadySeconds();
    board.lost = true;
    ASSERT_TRUE(comesTo(ArrayState::LOST));
    int moves = 0;
    EXPECT_TRUE(viewer->framesUntil(
        [&]
        {
            box->move(1e-4 * (++moves % 100));
            return midair::base::steadySeconds() - lost_s >= 2.5;
        }));
    const int silences = board.silences - before;
    EXPECT_GE(silences, 1) << "at the loss";
    EXPECT_LE(silences, 2 + static_cast<int>(midair::base::steadySeconds() - lost_s));
    const int plays = board.plays;
    board.lost = false;
    EXPECT_TRUE(comesTo(ArrayState::PLAYING));
    EXPECT_TRUE(viewer->framesUntil([&] { return board.plays > plays; }));
    EXPECT_EQ(board.unsilencedPlays, 0) << "nobody knows what it plays when it is back";
}

TEST_F(DeviceDriverSilence, OfALostDriverThatFailsIsTold)
{
    ASSERT_TRUE(comesToSound());
    board.failures = kForever;
    board.lost = true;
    EXPECT_TRUE(comesTo(ArrayState::LOST));
    EXPECT_TRUE(viewer->framesUntil([&] { return told("device.fault", kMayPlayOn) == 1; }));
    const int plays = board.plays;
    board.lost = false;
    EXPECT_TRUE(comesTo(ArrayState::FAULT)) << "back, and not silenced";
    EXPECT_EQ(board.plays, plays);
    board.failures = 0;
    EXPECT_TRUE(comesTo(ArrayState::PLAYING));
}

TEST_F(DeviceDriverSilence, TheStatusOfALossIsTheLoss)
{
    ASSERT_TRUE(comesToSound());
    EXPECT_TRUE(
        viewer->framesUntil([&] { return now().device.find("board fine") != std::string::npos; }));
    board.lost = true;
    ASSERT_TRUE(viewer->framesUntil([&] { return change->last.now == ArrayState::LOST; }));
    EXPECT_EQ(change->last.status.find("stubborn:desk: lost: "), 0u) << change->last.status;
    EXPECT_NE(change->last.status.find("; the driver is not ready"), std::string::npos)
        << change->last.status;
    EXPECT_EQ(change->last.status.find("board fine"), std::string::npos) << change->last.status;
}
