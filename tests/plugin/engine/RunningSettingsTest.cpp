// Settings that change while a scene plays.
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticCallback>
#include <osgMidair/HapticStatistics>

#include <osgDB/ReadFile>

#include <atomic>
#include <filesystem>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace osgMidair;

namespace
{

/// A file that is gone with the test.
struct RecordingFile
{
    std::filesystem::path path = std::filesystem::temp_directory_path() /
                                 ("osgMidair-running-" + std::to_string(getpid()) + ".midair");
    ~RecordingFile() { std::filesystem::remove(path); }
    std::string uri() const { return "record:" + path.string(); }
    std::uintmax_t size() const { return std::filesystem::file_size(path); }
};

struct Running : testing::Test
{
    Running() : viewer(box.scene) {}

    bool plays(std::uint64_t more = 1)
    {
        const std::uint64_t before = box.scene->getStatistics().fields.played;
        return viewer.framesUntil(
            [&] { return box.scene->getStatistics().fields.played >= before + more; });
    }

    float loudest() const
    {
        const auto result = box.result(); // without fields while nothing is open
        const bool isPlayed = result && result->played().size() > 0;
        return isPlayed ? result->played().cwiseAbs().maxCoeff() : 0.0f;
    }

    BoxScene box;
    HeadlessViewer viewer;
};

class Changes : public DeviceCallback
{
public:
    void changed(const DeviceChange& change) override { all.push_back(change); }
    bool has(ArrayState state) const
    {
        return std::any_of(
            all.begin(), all.end(), [&](const DeviceChange& c) { return c.now == state; });
    }
    std::vector<DeviceChange> all;
};

} // namespace

TEST_F(Running, SettingsLeaveTheDeviceOpen)
{
    RecordingFile file;
    box.scene->setDevice(file.uri());
    ASSERT_TRUE(plays());
    HapticScene& scene = *box.scene;
    const std::vector<std::pair<const char*, std::function<void()>>> changes = {
        {"loudness", [&] { scene.setLoudness(0.5); }},
        {"maxAmplitude", [&] { scene.setMaxAmplitude(0.4); }},
        {"maxPressure", [&] { scene.setMaxPressure(900.0); }},
        {"rmsTolerance", [&] { scene.setRmsTolerance(0.01); }},
        {"motionTolerance", [&] { scene.setMotionTolerance(0.001); }},
        {"calibration", [&] { scene.setCalibration(osg::Matrixd::translate(0.002, 0.0, 0.0)); }},
        {"temperature", [&] { scene.setTemperature(25.0); }},
        {"humidity", [&] { scene.setHumidity(0.4); }},
        {"airPressure", [&] { scene.setAirPressure(99000.0); }},
        {"solver", [&] { scene.setSolver("gs"); }},
        {"cycle", [&] { scene.setCycle(2); }},
        {"cycle back", [&] { scene.setCycle(1); }},
        {"monitor", [&] { scene.setMonitorInterval(0.1); }},
        {"phaseOnly", [&] { scene.setPhaseOnly(false); }},
        {"maxPoints", [&] { scene.setMaxPoints(20); }},
    };
    std::uint64_t solves = scene.getStatistics().solves;
    for (const auto& [name, change] : changes)
    {
        const std::uintmax_t size = file.size();
        change();
        ASSERT_TRUE(plays()) << name;
        EXPECT_GT(file.size(), size) << name;
        EXPECT_TRUE(viewer.framesUntil([&] { return scene.getStatistics().solves > solves; }))
            << name;
        solves = scene.getStatistics().solves;
    }
    const std::uint64_t played = scene.getStatistics().fields.played;
    scene.setEnabled(false);
    ASSERT_TRUE(viewer.framesUntil([&] { return loudest() == 0.0f; }));
    scene.setEnabled(true);
    ASSERT_TRUE(plays());
    EXPECT_GT(scene.getStatistics().fields.played, played);
}

TEST_F(Running, AnotherArrayOrDeviceIsOpened)
{
    RecordingFile file;
    box.scene->setDevice(file.uri());
    ASSERT_TRUE(plays());
    box.scene->setArray("octagon");
    ASSERT_TRUE(
        viewer.framesUntil([&] { return box.result() && box.result()->played().size() == 3984; }));
    EXPECT_LE(box.scene->getStatistics().fields.sent, 2u) << "of the new device";
    box.scene->setDevice("null:");
    ASSERT_TRUE(viewer.framesUntil(
        [&] { return box.scene->getStatistics().device.rfind("null:", 0) == 0; }));
}

TEST_F(Running, ASliderPlaysAFieldInNearlyEveryFrame)
{
    box.scene->setMaxPoints(10); // so that a solve takes less than a frame
    ASSERT_TRUE(plays());
    // What the device plays is told before what the solver counted.
    ASSERT_TRUE(viewer.framesUntil([&] { return box.scene->getStatistics().rowsBuilt > 0; }));
    const HapticStatistics before = box.scene->getStatistics();
    constexpr int kFrames = 60;
    for (int i = 0; i < kFrames; ++i)
    {
        box.scene->setLoudness(0.5 + 0.005 * i);
        const std::uint64_t results = box.scene->getStatistics().solves;
        viewer.frame();
        ASSERT_TRUE(eventually([&] { return box.scene->getStatistics().solves > results; }));
    }
    const HapticStatistics after = box.scene->getStatistics();
    EXPECT_GE(after.fields.played, before.fields.played + kFrames);
    EXPECT_EQ(after.rowsBuilt, before.rowsBuilt) << "none of them began anew";
}

TEST_F(Running, AStricterCapHoldsFromTheNextFieldOn)
{
    ASSERT_TRUE(viewer.framesUntil([&] { return loudest() > 0.9f; }));
    for (const double cap : {0.5, 0.25, 0.1})
    {
        box.scene->setMaxAmplitude(cap);
        const auto before = box.result();
        ASSERT_TRUE(viewer.framesUntil([&] { return box.result() != before; }));
        EXPECT_LE(loudest(), cap + 1e-6);
        EXPECT_GT(loudest(), 0.8 * cap);
    }
    // A scene inside lowers it in the same way.
    osg::ref_ptr<HapticScene> inner = new HapticScene;
    inner->setMaxAmplitude(0.05);
    box.scene->addChild(inner);
    ASSERT_TRUE(viewer.framesUntil([&] { return loudest() <= 0.05f; }));
    ASSERT_TRUE(plays(0));
    EXPECT_EQ(box.scene->getStatistics().state, ArrayState::PLAYING);
    EXPECT_EQ(box.scene->getStatistics().fields.reconnects, 0u);
}

// What was handed over in the first frame is not what the second one compares with.
TEST(RunningAnew, WhatForbidsPlayingDoesSoInEachOfTheFirstFrames)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<std::pair<const char*, std::function<void(HapticScene&)>>> forbidding = {
        {"enabled", [](HapticScene& scene) { scene.setEnabled(false); }},
        {"calibration",
         [](HapticScene& scene) { scene.setCalibration(osg::Matrixd::scale(2.0, 2.0, 2.0)); }},
        {"maxPressure", [&](HapticScene& scene) { scene.setMaxPressure(nan); }},
        {"maxAmplitude", [](HapticScene& scene) { scene.setMaxAmplitude(7.0); }},
        {"metresPerUnit", [](HapticScene& scene) { scene.setMetresPerUnit(0.0); }}};
    for (const auto& [name, forbid] : forbidding)
        for (const int frames : {1, 2, 3})
        {
            SCOPED_TRACE(std::string(name) + " after " + std::to_string(frames) + " frames");
            BoxScene other;
            HeadlessViewer view(other.scene);
            view.frames(frames);
            const auto sounds = [&]
            {
                const auto result = other.result();
                return result && result->played().size() > 0 &&
                       result->played().cwiseAbs().maxCoeff() > 0.0f;
            };
            ASSERT_TRUE(eventually(sounds));
            forbid(*other.scene);
            EXPECT_TRUE(view.framesUntil([&] { return !sounds(); }));
        }
}

TEST_F(Running, MutedIsSilentAtOnceAndKeepsTheDevice)
{
    osg::ref_ptr<Changes> changes = new Changes;
    box.scene->setDeviceCallback(changes);
    ASSERT_TRUE(plays());
    // What the device plays is told before the field's result is there.
    ASSERT_TRUE(viewer.framesUntil(
        [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; }));
    const std::uint64_t sent = box.scene->getStatistics().fields.sent;
    std::thread([&] { box.scene->setMuted(true); }).join();
    EXPECT_EQ(box.scene->getStatistics().state, ArrayState::MUTED);
    EXPECT_TRUE(box.scene->getMuted());
    EXPECT_NE(box.scene->getStatistics().device.find("; muted"), std::string::npos);
    box.move(0.01);
    const auto before = box.result();
    ASSERT_TRUE(viewer.framesUntil([&] { return box.result() != before; }));
    EXPECT_GT(box.points(), 0) << "overlays go on";
    EXPECT_EQ(box.scene->getStatistics().fields.sent, sent);
    EXPECT_TRUE(viewer.framesUntil([&] { return changes->has(ArrayState::MUTED); }));
    const std::uint64_t played = box.scene->getStatistics().fields.played;
    box.scene->setMuted(false);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return box.scene->getStatistics().fields.played > played; }));
    EXPECT_TRUE(viewer.framesUntil([&] { return changes->all.back().now == ArrayState::PLAYING; }));
    EXPECT_TRUE(box.scene->getStatistics().messages.empty()) << "as it was asked for";
}

TEST_F(Running, AMutedSceneInsideIsNotFelt)
{
    osg::ref_ptr<HapticScene> inner = new HapticScene;
    box.scene->removeChild(box.transform);
    inner->addChild(box.transform);
    box.scene->addChild(inner);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    inner->setMuted(true);
    EXPECT_TRUE(viewer.framesUntil([&] { return box.points() == 0; }));
}

TEST_F(Running, ALossAndAReturnAreToldByStateCallbackAndNotice)
{
    osg::ref_ptr<Changes> changes = new Changes;
    box.scene->setDeviceCallback(changes);
    box.scene->setDevice("sim:?unplug_at=1200ms&replug_at=2400ms");
    Notices notices;
    ASSERT_TRUE(viewer.framesUntil([&] { return changes->has(ArrayState::PLAYING); }));
    ASSERT_TRUE(viewer.framesUntil([&] { return changes->has(ArrayState::LOST); }));
    EXPECT_EQ(box.scene->getStatistics().state, ArrayState::LOST);
    ASSERT_TRUE(viewer.framesUntil([&] { return changes->all.back().now == ArrayState::PLAYING; }));
    EXPECT_NE(notices.text().find("osgMidair: sim: unplugged; silent until it is plugged in"),
              std::string::npos)
        << notices.text();
    EXPECT_NE(notices.text().find("osgMidair: the array is lost (it was playing)"),
              std::string::npos)
        << notices.text();
    const HapticStatistics statistics = box.scene->getStatistics();
    ASSERT_EQ(statistics.told.size(), 1u);
    EXPECT_EQ(statistics.told[0].code, "device.lost");
    EXPECT_EQ(statistics.told[0].severity, HapticMessage::FAULT);
    EXPECT_EQ(statistics.told[0].count, 1u);
    EXPECT_EQ(statistics.messages, std::vector<std::string>{"device: lost: unplugged"});
    EXPECT_EQ(statistics.fields.reconnects, 1u);
    EXPECT_EQ(statistics.device.find("; unplugged"), std::string::npos) << statistics.device;
}

TEST_F(Running, AWrongArrayIsOneMessageAndClosed)
{
    box.scene->setArray("no such array");
    ASSERT_TRUE(viewer.framesUntil([&] { return !box.scene->getStatistics().messages.empty(); }));
    viewer.framesUntil([&] { return box.scene->getStatistics().frames > 50; });
    EXPECT_EQ(box.scene->getStatistics().messages.size(), 1u);
    EXPECT_EQ(box.scene->getStatistics().state, ArrayState::CLOSED);
    box.scene->setArray("board");
    EXPECT_TRUE(plays());
    // A solver that isn't known silences, and another one plays again.
    box.scene->setSolver("nonsense");
    ASSERT_TRUE(viewer.framesUntil([&] { return loudest() == 0.0f; }));
    box.scene->setSolver("");
    EXPECT_TRUE(plays());
}

TEST_F(Running, AnInvalidCalibrationOrCapPlaysNothing)
{
    ASSERT_TRUE(plays());
    osg::Matrixd squeezed = osg::Matrixd::scale(1.0, 1.0, 0.5);
    osg::Matrixd notANumber;
    notANumber(3, 0) = std::numeric_limits<double>::quiet_NaN();
    for (const osg::Matrixd& wrong : {squeezed, notANumber, osg::Matrixd::scale(0.0, 0.0, 0.0)})
    {
        box.scene->setCalibration(wrong);
        ASSERT_TRUE(viewer.framesUntil([&] { return loudest() == 0.0f; }));
        EXPECT_NE(box.scene->getStatistics().messages.back().find("nothing is played"),
                  std::string::npos);
        box.scene->setCalibration(osg::Matrixd());
        ASSERT_TRUE(viewer.framesUntil([&] { return loudest() > 0.0f; }));
    }
    box.scene->setMaxPressure(std::numeric_limits<double>::quiet_NaN());
    ASSERT_TRUE(viewer.framesUntil([&] { return loudest() == 0.0f; }));
    box.scene->setMaxPressure(0.0);
    ASSERT_TRUE(viewer.framesUntil([&] { return loudest() > 0.0f; }));
    for (const char* name : {"calibration", "maxPressure"})
    {
        HapticSettings settings = box.scene->getSettings();
        std::string error;
        EXPECT_FALSE(settings.set(name, "1 2 three", error)) << name;
        box.scene->setSettings(settings);
        EXPECT_TRUE(viewer.framesUntil([&] { return loudest() == 0.0f; })) << name;
        box.scene->setSettings(HapticSettings());
        box.scene->setArray("board");
        EXPECT_TRUE(viewer.framesUntil([&] { return loudest() > 0.0f; })) << name;
    }
}

TEST_F(Running, AHandSourceThatThrowsIsAMessage)
{
    struct Throws : HandSource
    {
        bool getHands(double, std::vector<Hand>&) override
        {
            throw std::runtime_error("no camera");
        }
        std::string getStatus() const override { return "broken"; }
    };
    box.scene->setHandSource(new Throws);
    ASSERT_TRUE(plays());
    viewer.frames(5);
    EXPECT_EQ(box.scene->getStatistics().messages,
              std::vector<std::string>{"the application's hand source has thrown \"no camera\": "
                                       "there are no hands while it does"});
}

TEST(HapticCallback, StatisticsAndMuteAreForAnyThread)
{
    osg::ref_ptr<HapticSurface> surface = new HapticSurface(BoxScene::box());
    osg::ref_ptr<osg::MatrixTransform> root =
        new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.15));
    root->addChild(surface);
    HapticSettings settings;
    settings.array = "board";
    osg::ref_ptr<HapticCallback> callback = new HapticCallback(settings);
    osg::ref_ptr<osg::Group> top = new osg::Group;
    top->addChild(root);
    top->addEventCallback(callback);
    HeadlessViewer viewer(top);
    std::atomic<bool> end{false};
    std::thread reader(
        [&]
        {
            while (!end)
            {
                callback->getStatistics();
                callback->setMuted(true);
                callback->setMuted(false);
            }
        });
    viewer.framesUntil([&] { return callback->getStatistics().fields.played > 0; });
    end = true;
    reader.join();
    callback->setMuted(true);
    EXPECT_EQ(callback->getStatistics().state, ArrayState::MUTED);
}
