// A driver whose calls don't return holds nobody up.
#include "tests/Eventually.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/DeviceCallback>
#include <osgMidair/DeviceDriver>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// Holds the driver below up in one of its calls, and counts them; a driver that is left behind may
/// outlive the test. Opens by itself after a minute, so that a test fails rather than hangs.
class Gate
{
public:
    explicit Gate(std::string call) : _call(std::move(call)) {}

    void pass(const std::string& call)
    {
        std::unique_lock<std::mutex> lock(_mutex);
        if (call != _call) return;
        _holds = true;
        _wake.notify_all();
        _gaveUp = !_wake.wait_for(lock, std::chrono::minutes(1), [this] { return _isOpen; });
    }
    void open()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        _isOpen = true;
        _wake.notify_all();
    }
    bool holds() const
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _holds && !_isOpen && !_gaveUp;
    }

    std::atomic<int> plays{0};
    std::atomic<int> silences{0};
    std::atomic<int> closed{0};

private:
    const std::string _call;
    mutable std::mutex _mutex;
    std::condition_variable _wake;
    bool _holds = false;
    bool _isOpen = false;
    bool _gaveUp = false;
};

class GatedDriver : public DeviceDriver
{
public:
    explicit GatedDriver(std::shared_ptr<Gate> gate) : _gate(std::move(gate)) {}
    bool open(const std::string&,
              const std::map<std::string, std::string>&,
              const Layout&,
              std::string&) override
    {
        _gate->pass("open");
        return true;
    }
    bool play(const unsigned char*, const unsigned char*) override
    {
        ++_gate->plays;
        _gate->pass("play");
        return true;
    }
    void silence() override { ++_gate->silences; }

protected:
    ~GatedDriver() override { ++_gate->closed; }

private:
    const std::shared_ptr<Gate> _gate;
};

/// The gate of the driver that is opened next.
std::shared_ptr<Gate>& nextGate()
{
    static std::shared_ptr<Gate> gate;
    return gate;
}

/// A scene whose driver is held up in \a call.
struct GatedScene : BoxScene
{
    explicit GatedScene(const std::string& call, const std::string& path) :
        gate(std::make_shared<Gate>(call))
    {
        static const bool registered = []
        {
            std::string error;
            return registerDevice(
                "gated",
                [] { return osg::ref_ptr<DeviceDriver>(new GatedDriver(nextGate())); },
                error);
        }();
        EXPECT_TRUE(registered);
        nextGate() = gate;
        scene->setDevice("gated:" + path);
    }
    ~GatedScene() { gate->open(); }
    GatedScene(const GatedScene&) = delete;
    GatedScene& operator=(const GatedScene&) = delete;

    bool tells(const std::string& code, const std::string& part) const
    {
        const auto told = scene->getStatistics().told;
        return std::any_of(told.begin(),
                           told.end(),
                           [&](const HapticMessage& one) {
                               return one.code == code && one.text.find(part) != std::string::npos;
                           });
    }
    ArrayState state() const { return scene->getStatistics().state; }

    const std::shared_ptr<Gate> gate;
};

} // namespace

TEST(HangingDriver, NobodyWaitsForItAndItIsTold)
{
    GatedScene box("play", "nobody-waits");
    Gate& gate = *box.gate;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return gate.holds(); }));
    box.scene->setMuted(true);
    box.scene->setMuted(false);
    for (int k = 1; k <= 5; ++k)
    {
        box.move(1e-3 * k);
        viewer.frame();
    }
    EXPECT_EQ(box.scene->getStatistics().fields.played, 0u);
    EXPECT_TRUE(gate.holds()) << "all that while play() had not returned";
    EXPECT_TRUE(viewer.framesUntil([&] { return box.state() == ArrayState::FAULT; }));
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return box.tells("device.hangs", "the driver's play() hasn't returned for "); }));
    EXPECT_TRUE(gate.holds());
    gate.open();
    EXPECT_TRUE(viewer.framesUntil([&] { return box.state() == ArrayState::PLAYING; }));
    const ArrayFields fields = box.scene->getStatistics().fields;
    EXPECT_EQ(fields.sent,
              fields.played + fields.dropped + fields.lost + fields.refused + fields.waiting);
    EXPECT_GT(fields.played, 0u);
}

TEST(HangingDriver, AMuteHoldsFromTheNextFieldOn)
{
    GatedScene box("play", "mute");
    Gate& gate = *box.gate;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return gate.holds(); }));
    box.move(5e-3);
    viewer.frames(3); // so that perhaps another field waits
    const int silences = gate.silences;
    box.scene->setMuted(true);
    ASSERT_TRUE(gate.holds());
    gate.open();
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return gate.silences > silences && box.state() == ArrayState::MUTED; }));
    box.move(7e-3);
    viewer.frames(20);
    EXPECT_EQ(gate.plays, 1) << "the call that was under way";
}

// The array may still sound, so nobody is told that it is muted.
TEST(HangingDriver, AMuteThatItHasNotHeardIsAFault)
{
    struct LastState : DeviceCallback
    {
        void changed(const DeviceChange& change) override { now = change.now; }
        ArrayState now = ArrayState::CLOSED;
    };
    GatedScene box("play", "deaf");
    const osg::ref_ptr<LastState> told = new LastState;
    box.scene->setDeviceCallback(told);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.gate->holds(); }));
    box.scene->setMuted(true);
    EXPECT_TRUE(viewer.framesUntil([&] { return told->now == ArrayState::FAULT; }));
    EXPECT_EQ(box.state(), ArrayState::FAULT);
    box.gate->open();
    EXPECT_TRUE(viewer.framesUntil([&] { return told->now == ArrayState::MUTED; }));
    EXPECT_EQ(box.state(), ArrayState::MUTED);
}

TEST(HangingDriver, IsLeftBehindWhenItsSceneEnds)
{
    auto box = std::make_unique<GatedScene>("play", "left");
    const std::shared_ptr<Gate> gate = box->gate;
    Notices notices;
    {
        HeadlessViewer viewer(box->scene);
        ASSERT_TRUE(viewer.framesUntil([&] { return gate->holds(); }));
    }
    box->transform = nullptr;
    box->surface = nullptr;
    box->scene = nullptr;
    EXPECT_TRUE(gate->holds()) << "the scene has ended before the call";
    EXPECT_EQ(gate->closed, 0);
    EXPECT_NE(notices.text().find("gated:left: its driver hasn't returned for 3 s"),
              std::string::npos)
        << notices.text();
    {
        GatedScene again("nothing", "left");
        HeadlessViewer viewer(again.scene);
        EXPECT_TRUE(
            viewer.framesUntil([&] { return again.tells("device.open", "hasn't returned yet"); }));
        const int silences = gate->silences;
        gate->open();
        EXPECT_TRUE(viewer.framesUntil([&] { return gate->closed == 1; }));
        EXPECT_GT(gate->silences, silences) << "silenced before it is let go";
        EXPECT_TRUE(viewer.framesUntil([&] { return again.state() == ArrayState::PLAYING; }));
    }
}

TEST(HangingDriver, ASlowOpenIsToldAndPlayedInTheEnd)
{
    GatedScene box("open", "slow");
    HeadlessViewer viewer(box.scene);
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return box.tells("device.open", "opening it takes longer than 3 s"); }));
    EXPECT_TRUE(box.gate->holds());
    EXPECT_EQ(box.state(), ArrayState::OPENING);
    EXPECT_GT(box.points(), 0) << "fields are solved for";
    box.gate->open();
    EXPECT_TRUE(viewer.framesUntil([&] { return box.state() == ArrayState::PLAYING; }));
}

TEST(HangingDriver, AnOpenThatHangsHoldsNoDestructorUp)
{
    auto box = std::make_unique<GatedScene>("open", "hangs");
    const std::shared_ptr<Gate> gate = box->gate;
    {
        HeadlessViewer viewer(box->scene);
        ASSERT_TRUE(viewer.framesUntil([&] { return gate->holds(); }));
    }
    box->transform = nullptr;
    box->surface = nullptr;
    box->scene = nullptr;
    EXPECT_TRUE(gate->holds()) << "the scene has ended before the call";
    {
        GatedScene again("nothing", "hangs");
        HeadlessViewer viewer(again.scene);
        EXPECT_TRUE(viewer.framesUntil(
            [&] { return again.tells("device.open", "and its driver still hangs"); }))
            << "no scene drives it any more";
        EXPECT_FALSE(again.tells("device.open", "is driven by"));
    }
    gate->open();
    EXPECT_TRUE(eventually([&] { return gate->closed > 0; }));
    EXPECT_GT(gate->silences, 0) << "what opened after all is silenced";
}
