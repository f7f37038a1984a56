// A program's driver that throws, refuses or hangs at the field that should make it quieter.
#include "device/ArrayDevice.h"
#include "engine-bridge/extending/ArrayDriver.h"
#include "engine-bridge/pipeline/HologramThread.h"
#include "engine-bridge/playing/FieldPlayer.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/Halt.h"
#include "tests/device/limits/QuieterTrial.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <osgMidair/ArrayState>

#include <algorithm>
#include <atomic>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

using namespace midair;
using device::DeviceState;
using osgMidair::ArrayState;

namespace
{

enum class Failure
{
    THROWS,
    REFUSES,
    HANGS
};

/// A driver's board: what it was told, and how it fails.
struct Board
{
    std::atomic<int> level{0};    ///< that sounds, 0 .. 255
    std::atomic<int> sum{0};      ///< of all that sound
    std::atomic<int> failures{0}; ///< so many calls of play() fail from now on
    Halt hangs;                   ///< the call of play() that hangs returns once this is false
    std::atomic<int> plays{0};
    std::atomic<int> silences{0};
    std::atomic<int> silenceTakes_ms{0};
    std::atomic<Failure> how{Failure::THROWS};
};

Board& board()
{
    static Board one;
    return one;
}

class FailingDriver : public bridge::ArrayDriver
{
public:
    bool open(const std::string&,
              const std::map<std::string, std::string>&,
              const Layout& layout,
              std::string&) override
    {
        _transducers = layout.transducers;
        return true;
    }
    bool play(const unsigned char*, const unsigned char* amplitudes) override
    {
        ++board().plays;
        if (board().failures > 0)
        {
            --board().failures;
            if (board().how == Failure::THROWS) throw std::runtime_error("the line is cut");
            if (board().how == Failure::REFUSES) return false;
            board().hangs = true;
            board().hangs.pass();
        }
        board().level = *std::max_element(amplitudes, amplitudes + _transducers);
        board().sum = std::accumulate(amplitudes, amplitudes + _transducers, 0);
        return true;
    }
    void silence() override
    {
        ++board().silences;
        if (board().how == Failure::HANGS && board().failures > 0)
        {
            board().hangs = true;
            board().hangs.pass();
        }
        letPass(1e-3 * board().silenceTakes_ms);
        board().level = board().sum = 0;
    }

private:
    int _transducers = 0;
};

class QuieterDriver : public testing::TestWithParam<Failure>
{
protected:
    QuieterDriver()
    {
        static const bool isRegistered = []
        {
            std::string error;
            return bridge::registerDriver(
                "failing", [] { return std::make_shared<FailingDriver>(); }, error);
        }();
        EXPECT_TRUE(isRegistered);
        board().level = board().sum = board().failures = board().plays = board().silences = 0;
        board().hangs = false;
        board().how = GetParam();
    }
    ~QuieterDriver() override
    {
        board().failures = 0;
        board().hangs = false;
        board().silenceTakes_ms = 0;
    }

    static std::unique_ptr<device::ArrayDevice> opened()
    {
        return device::openDevice("failing:", {4, {}, {}});
    }
    static device::DriveSignal field(int duty)
    {
        device::DriveSignal signal = device::silentSignal(4);
        signal.duty.assign(4, static_cast<std::uint8_t>(duty));
        return signal;
    }
};

std::string nameOf(const testing::TestParamInfo<Failure>& info)
{
    return info.param == Failure::THROWS    ? "Throws"
           : info.param == Failure::REFUSES ? "Refuses"
                                            : "Hangs";
}

constexpr int kForever = 1000000;

} // namespace

TEST_P(QuieterDriver, IsSilencedAndTold)
{
    const std::map<std::string, std::function<void(device::ArrayDevice&)>> ways = {
        {"cap", [](device::ArrayDevice& device) { device.setAmplitudeCap(0.1); }},
        {"field", [](device::ArrayDevice& device) { device.send(field(10)); }},
        {"silence", [](device::ArrayDevice& device) { device.send(field(0)); }},
    };
    for (const auto& [name, quieten] : ways)
    {
        SCOPED_TRACE(name);
        board().failures = 0;
        const auto device = opened();
        ASSERT_TRUE(device->send(field(255)));
        ASSERT_TRUE(eventually([] { return board().level == 255; }));
        board().failures = kForever;
        const double asked_s = base::steadySeconds();
        quieten(*device);
        if (GetParam() != Failure::HANGS)
        {
            ASSERT_TRUE(eventually([] { return board().level == 0; }));
            EXPECT_GE(base::steadySeconds() - asked_s, 0.09);
            ASSERT_TRUE(eventually([&] { return !device->report().quieted.empty(); }));
            EXPECT_EQ(device->report().unsilenced, "");
            continue;
        }
        // Nobody can silence it while play() hasn't returned: that is told, and tried again.
        ASSERT_TRUE(eventually([&] { return !device->report().unsilenced.empty(); }));
        ASSERT_TRUE(eventually([&] { return device->report().state == DeviceState::HANGING; }));
        EXPECT_GE(base::steadySeconds() - asked_s, 0.99);
        EXPECT_NE(device->report().message, "");
        EXPECT_EQ(board().level, 255);
        board().failures = 0;
        board().hangs = false;
        EXPECT_TRUE(eventually([] { return board().level == 0 && board().silences > 0; }));
        EXPECT_TRUE(eventually([&] { return device->report().state == DeviceState::READY; }));
    }
}

// The matrix of QuieterMatrixTest.
TEST_P(QuieterDriver, AloneAndInAListKeepsThePromiseOfAllDevices)
{
    const bool hangs = GetParam() == Failure::HANGS;
    for (const char* uri : {"failing:", "null:,failing:"})
        for (const quieter::Way way : quieter::allWays())
        {
            SCOPED_TRACE(fmt::format("{} {}", uri, quieter::nameOf(way)));
            quieter::FarSide far;
            far.transducers = 4;
            far.device = device::openDevice(uri, {4, {}, {}});
            const auto handed = [&device = *far.device]
            { return static_cast<int>(device.report().silences); };
            far.loudness = [] { return board().sum.load(); };
            far.silences = [hangs, handed] { return hangs ? handed() : board().silences.load(); };
            far.fail = [] { board().failures = kForever; };
            far.recover = []
            {
                board().failures = 0;
                board().hangs = false;
            };
            // Its driver's silence() works where it doesn't hang, and then nothing has failed.
            far.quiet_s = hangs ? 0.0 : quieter::kConfirm_s;
            far.staysFaulty = hangs;
            far.tries = 1; // it can be called once it has returned
            far.isTold = hangs || way == quieter::Way::CAP || way == quieter::Way::FIELD;
            EXPECT_EQ(quieter::trial(way, std::move(far)), "");
        }
}

// Its silence() takes longer than the time after which it is asked for it again.
TEST_P(QuieterDriver, ThatIsSlowToFallSilentIsKnownToBeSilent)
{
    if (GetParam() == Failure::HANGS) return;
    const auto device = opened();
    ASSERT_TRUE(device->send(field(255)));
    ASSERT_TRUE(eventually([] { return board().level == 255; }));
    board().failures = kForever;
    board().silenceTakes_ms = 180;
    ASSERT_TRUE(device->send(field(10)));
    ASSERT_TRUE(eventually([] { return board().level == 0; }));
    for (int frame = 0; frame < 20; ++frame) // whoever leads goes on
    {
        device->send(field(10));
        letPass(0.016);
    }
    board().failures = 0;
    const auto isWell = [&]
    {
        device->send(field(10));
        const device::DeviceReport report = device->report();
        return board().level == 10 && report.state == DeviceState::READY &&
               report.unsilenced.empty() && report.quieted.empty();
    };
    EXPECT_TRUE(eventually(isWell)) << device->status();
}

TEST_P(QuieterDriver, OfFieldsInTurnIsSilenced)
{
    const auto device = opened();
    bridge::FieldPlayer player(*device);
    player.play({field(255), field(254)});
    ASSERT_TRUE(eventually([] { return board().level >= 254 && board().plays > 20; }));
    board().failures = kForever;
    device->setAmplitudeCap(0.1);
    if (GetParam() == Failure::HANGS)
    {
        ASSERT_TRUE(eventually([&] { return device->report().state == DeviceState::HANGING; }));
        board().failures = 0;
        board().hangs = false;
        EXPECT_TRUE(eventually([] { return board().level > 0 && board().level < 30; }))
            << "it goes on, under the cap";
        return;
    }
    EXPECT_TRUE(eventually([] { return board().level == 0; }));
    board().failures = 0;
    EXPECT_TRUE(eventually([] { return board().level > 0 && board().level < 30; }));
    EXPECT_TRUE(eventually([&] { return device->report().quieted.empty(); }));
}

// The scene's amplitude is lowered, and its driver fails twice: at the same field with a lower
// gain, and at the next one.
TEST_P(QuieterDriver, OfASceneIsSilencedToldAndPlaysAgain)
{
    bridge::HologramOptions options;
    options.array = haptics::TransducerArray::octagonalPrism();
    options.array.positions = options.array.positions.leftCols(249).eval();
    options.array.normals = options.array.normals.leftCols(249).eval();
    options.array.board.assign(249, 0);
    options.deviceUri = "failing:";
    bridge::HologramThread thread(options);
    auto snapshot = squareSnapshot();
    thread.submit(snapshot);
    ASSERT_TRUE(eventually([] { return board().level == 255; }));
    ASSERT_TRUE(eventually([&] { return thread.state() == ArrayState::PLAYING; }));
    board().failures = GetParam() == Failure::HANGS ? 1 : 2;
    options.maxAmplitude = 0.1;
    const double asked_s = base::steadySeconds();
    thread.setOptions(options, {});
    snapshot = squareSnapshot();
    thread.submit(snapshot);
    double loud_s = asked_s; // when it was heard last
    bool isFault = false;
    double look_s = asked_s;
    double gap_s = 0.0; // the longest that nobody looked
    EXPECT_TRUE(eventually(
        [&]
        {
            const double now_s = base::steadySeconds();
            gap_s = std::max(gap_s, now_s - look_s);
            look_s = now_s;
            if (board().level > 30) loud_s = now_s;
            isFault = thread.reading().state == ArrayState::FAULT || isFault;
            return now_s - asked_s >= 2.0;
        }));
    if (GetParam() == Failure::HANGS)
    {
        EXPECT_TRUE(isFault);
        board().hangs = false;
    }
    else
        EXPECT_LT(loud_s - asked_s, 0.4 + gap_s) << "100 ms, on a busy machine";
    ASSERT_TRUE(eventually([] { return board().level > 0 && board().level <= 30; }))
        << "it is tried again";
    ASSERT_TRUE(eventually([&] { return thread.state() == ArrayState::PLAYING; }));
}

INSTANTIATE_TEST_SUITE_P(All,
                         QuieterDriver,
                         testing::Values(Failure::THROWS, Failure::REFUSES, Failure::HANGS),
                         nameOf);
