#include "tests/plugin/KitTest.h"

#include <osgMidair/DeviceDriver>
#include <osgMidair/HapticField>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <stdexcept>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// What the driver below got, and what it should do.
struct Log
{
    std::mutex mutex;
    std::string path;
    std::map<std::string, std::string> options;
    unsigned int transducers = 0;
    std::vector<unsigned char> phases;
    std::vector<unsigned char> amplitudes;
    std::atomic<int> plays{0};
    std::atomic<int> silences{0};
    std::atomic<int> closed{0};
    std::atomic<int> loudest{0}; ///< amplitude that was ever played
    std::atomic<bool> lost{false};
    std::atomic<bool> throws{false};
    std::atomic<bool> isCoarse{false}; ///< 32 phases, off or full
};

Log& drivenLog()
{
    static Log log;
    return log;
}

class LoggingDriver : public DeviceDriver
{
public:
    bool open(const std::string& path,
              const std::map<std::string, std::string>& options,
              const Layout& layout,
              std::string& error) override
    {
        Log& log = drivenLog();
        const std::lock_guard<std::mutex> lock(log.mutex);
        log.path = path;
        log.options = options;
        log.transducers = layout.transducers;
        if (path == "refuse") error = "there is no such board";
        return path != "refuse";
    }
    bool play(const unsigned char* phases, const unsigned char* amplitudes) override
    {
        Log& log = drivenLog();
        if (log.throws) throw std::runtime_error("the line is cut");
        const std::lock_guard<std::mutex> lock(log.mutex);
        log.phases.assign(phases, phases + log.transducers);
        log.amplitudes.assign(amplitudes, amplitudes + log.transducers);
        log.loudest = std::max<int>(
            log.loudest, *std::max_element(log.amplitudes.begin(), log.amplitudes.end()));
        ++log.plays;
        return true;
    }
    void silence() override { ++drivenLog().silences; }
    bool isReady() const override { return !drivenLog().lost; }
    std::string getStatus() const override { return "warm"; }
    unsigned int getPhaseLevels() const override { return drivenLog().isCoarse ? 32 : 256; }
    std::vector<float> getAmplitudes() const override
    {
        return drivenLog().isCoarse ? std::vector<float>{0.0F, 1.0F} : std::vector<float>();
    }

protected:
    ~LoggingDriver() override { ++drivenLog().closed; }
};

class DeviceDriverTest : public testing::Test
{
protected:
    void SetUp() override
    {
        std::string error;
        static const bool registered = registerDevice(
            "logging", [] { return osg::ref_ptr<DeviceDriver>(new LoggingDriver); }, error);
        ASSERT_TRUE(registered) << error;
        Log& log = drivenLog();
        log.plays = log.silences = log.closed = log.loudest = 0;
        log.lost = log.throws = log.isCoarse = false;
    }
};

} // namespace

TEST_F(DeviceDriverTest, ASchemeHasOneMeaning)
{
    const auto make = [] { return osg::ref_ptr<DeviceDriver>(new LoggingDriver); };
    std::string error;
    EXPECT_FALSE(registerDevice("logging", make, error));
    EXPECT_EQ(error, "the scheme \"logging\" is taken");
    EXPECT_FALSE(registerDevice("sim", make, error));
    EXPECT_EQ(error, "the scheme \"sim\" is taken");
    EXPECT_FALSE(registerDevice("My-board", make, error));
    EXPECT_EQ(error, "\"My-board\" is no scheme; it must have 1 to 32 small letters");
    EXPECT_FALSE(registerDevice("other", {}, error));
    EXPECT_EQ(error, "the scheme \"other\" was registered without a factory");
}

// Each of the calls that open a device may throw anything.
TEST_F(DeviceDriverTest, WhatItThrowsWhileItIsOpenedIsAMessage)
{
    struct Throwing : LoggingDriver
    {
        explicit Throwing(std::string place) : where(std::move(place)) {}
        bool open(const std::string&,
                  const std::map<std::string, std::string>&,
                  const Layout&,
                  std::string&) override
        {
            if (where == "open") throw 7;
            return true;
        }
        std::vector<float> getAmplitudes() const override { throw std::runtime_error("no levels"); }
        const std::string where;
    };
    static std::string where;
    static const bool registered = []
    {
        std::string error;
        return registerDevice(
            "throwing",
            []
            {
                if (where == "make") throw std::runtime_error("no bus");
                return osg::ref_ptr<DeviceDriver>(new Throwing(where));
            },
            error);
    }();
    ASSERT_TRUE(registered);
    for (const auto& one : {std::pair{"make", "\"no bus\""},
                            std::pair{"open", "an exception"},
                            std::pair{"levels", "\"no levels\""}})
    {
        const char* thrown = one.second;
        where = one.first;
        BoxScene box;
        box.scene->setDevice("throwing:");
        HeadlessViewer viewer(box.scene);
        EXPECT_TRUE(viewer.framesUntil(
            [&] { return says(*box.scene, std::string("its driver has thrown ") + thrown); }))
            << where;
        EXPECT_EQ(box.scene->getStatistics().state, ArrayState::CLOSED);
    }
    EXPECT_GT(drivenLog().silences, 0) << "one that was open is silenced";
}

TEST_F(DeviceDriverTest, PlaysAScene)
{
    Log& log = drivenLog();
    {
        BoxScene box;
        box.scene->setDevice("logging:desk?gain=2&max-amplitude=0.5");
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0 && log.plays > 0; }));
        const auto field = box.scene->getField();
        ASSERT_TRUE(field);
        EXPECT_TRUE(field->isPlaying());
        // Not under the log's lock: the kit calls the driver, which takes it, under locks of its
        // own.
        const std::string status = box.scene->getStatistics().device;
        EXPECT_EQ(status.find("logging:desk: warm: "), 0u) << status;
        const std::lock_guard<std::mutex> lock(log.mutex);
        EXPECT_EQ(log.path, "desk");
        EXPECT_EQ(log.options, (std::map<std::string, std::string>{{"gain", "2"}}))
            << "the limit is the kit's";
        EXPECT_EQ(log.transducers, 249u);
        EXPECT_LE(log.loudest, 85) << "sin(pi 85/510) is a half";
        EXPECT_GT(log.loudest, 80);
        const auto q = field->getActivations();
        for (std::size_t i = 0; i < q.size(); ++i)
            EXPECT_LT(
                std::abs(q[i] -
                         std::polar(static_cast<float>(std::sin(M_PI * log.amplitudes[i] / 510.0)),
                                    static_cast<float>(2 * M_PI / 256 * log.phases[i]))),
                1e-5F);
    }
    EXPECT_GT(log.silences, 0);
    EXPECT_EQ(log.closed, 1);
}

TEST_F(DeviceDriverTest, GetsItsOwnLevels)
{
    Log& log = drivenLog();
    log.isCoarse = true;
    BoxScene box;
    box.scene->setDevice("logging:");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0 && log.plays > 0; }));
    const auto q = box.scene->getField()->getActivations();
    const std::lock_guard<std::mutex> lock(log.mutex);
    EXPECT_LT(*std::max_element(log.phases.begin(), log.phases.end()), 32);
    EXPECT_EQ(log.loudest, 1);
    for (std::size_t i = 0; i < q.size(); ++i)
        EXPECT_LT(std::abs(q[i] - std::polar(1.0F * log.amplitudes[i],
                                             static_cast<float>(2 * M_PI / 32 * log.phases[i]))),
                  1e-5F);
}

TEST_F(DeviceDriverTest, SaysWhyItIsNotOpen)
{
    BoxScene box;
    box.scene->setDevice("logging:refuse");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil(
        [&] { return says(*box.scene, "device \"logging:refuse\": there is no such board"); }));
    EXPECT_EQ(drivenLog().plays, 0);
}

// A file's wish is none of the program's: the user grants devices of any kind.
TEST_F(DeviceDriverTest, AFileOpensItOnlyWithAGrant)
{
    BoxScene box;
    HapticSettings settings = box.scene->getSettings();
    settings.device = "logging:desk";
    settings.wishes.asked["device"] = "logging:desk";
    box.scene->setSettings(settings);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_TRUE(says(*box.scene, "asks for the device \"logging:desk\""));
    EXPECT_EQ(drivenLog().plays, 0);
}

TEST_F(DeviceDriverTest, IsPlayedOnceItIsBack)
{
    Log& log = drivenLog();
    log.lost = true;
    BoxScene box;
    box.scene->setDevice("logging:");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_EQ(log.plays, 0);
    EXPECT_FALSE(box.scene->getField()->isPlaying());
    log.lost = false;
    ASSERT_TRUE(viewer.framesUntil([&] { return log.plays > 0; }));
    ASSERT_TRUE(viewer.framesUntil([&] { return box.scene->getField()->isPlaying(); }));
}

TEST_F(DeviceDriverTest, WhatItThrowsIsAMessage)
{
    drivenLog().throws = true;
    BoxScene box;
    box.scene->setDevice("logging:");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil(
        [&] { return says(*box.scene, "the driver's play() has thrown \"the line is cut\""); }));
    EXPECT_FALSE(box.scene->getField()->isPlaying());
}
