// Devices that a scene would drive, what the user grants it, and who owns a device.
#include "plugin/engine/HapticEngine.h"
#include "plugin/engine/SceneAccess.h"
#include "tests/hostile/Hostile.h"

#include <osgMidair/HapticDevice>

#include <osg/Group>

#include <algorithm>

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <termios.h>

using namespace osgMidair;

namespace
{

class HostileDevices : public Hostile
{
};

/// A serial port that nobody has opened yet, as a board has one.
class Terminal
{
public:
    Terminal() : _master(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK))
    {
        EXPECT_EQ(grantpt(_master), 0);
        EXPECT_EQ(unlockpt(_master), 0);
        char name[64];
        EXPECT_EQ(ptsname_r(_master, name, sizeof name), 0);
        _name = name;
    }
    ~Terminal() { close(_master); }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;

    const std::string& name() const { return _name; }

    /// Whether the other end was opened at any time: it hangs up when it is closed, and sends when
    /// it plays.
    bool touched() const
    {
        pollfd state{_master, POLLIN, 0};
        poll(&state, 1, 0);
        return state.revents != 0;
    }

private:
    int _master;
    std::string _name;
};

float strongest(const HapticScene& scene)
{
    return SceneAccess::latestResult(scene)->played().cwiseAbs().maxCoeff();
}

} // namespace

TEST_P(HostileDevices, NoneOfTheUsersIsDriven)
{
    const Terminal terminal;
    for (const std::string& uri : {"ultraino:" + terminal.name(),
                                   "sonicsurface:" + terminal.name(),
                                   "sim:,sonicsurface:" + terminal.name(),
                                   std::string("usb:"),
                                   std::string("openmpd:"),
                                   std::string("desk")})
    {
        const auto scene = fromFile([&](HapticScene& s) { s.setDevice(uri); });
        const auto viewer = view(*scene);
        EXPECT_TRUE(simulates(*scene)) << uri << ": " << scene->getStatistics().device;
        EXPECT_TRUE(says(*scene, "asks for the device \"" + uri + "\"")) << messages(*scene);
        EXPECT_TRUE(says(*scene, "OSG_MIDAIR_DEVICE")) << "how to grant it";
        EXPECT_GT(SceneAccess::latestResult(*scene)->achieved_Pa.maxCoeff(), 0.0f);
    }
    EXPECT_FALSE(terminal.touched());
}

TEST_P(HostileDevices, WhatIsSimulatedIsNoWish)
{
    for (const char* uri : {"sim:", "null:", "sim:?latency=1ms", "null:,sim:"})
    {
        const auto scene = fromFile([&](HapticScene& s) { s.setDevice(uri); });
        const auto viewer = view(*scene);
        EXPECT_FALSE(says(*scene, "asks for")) << messages(*scene);
    }
}

TEST_P(HostileDevices, TheUserGrants)
{
    const auto wish = [](HapticScene& s) { s.setDevice("usb:"); };
    {
        const auto scene = fromFile(wish, "device=null:");
        const auto viewer = view(*scene);
        EXPECT_EQ(scene->getStatistics().device.rfind("null:", 0), 0u) << "an option";
    }
    {
        const Variable device("OSG_MIDAIR_DEVICE", "null:");
        const auto scene = fromFile(wish);
        const auto viewer = view(*scene);
        EXPECT_EQ(scene->getStatistics().device.rfind("null:", 0), 0u) << "the environment";
    }
    const auto scene = fromFile(wish);
    const std::string file = _place.outside("by-the-program");
    scene->setDevice("record:" + file);
    const auto viewer = view(*scene);
    EXPECT_TRUE(std::filesystem::exists(file)) << messages(*scene);
}

TEST_P(HostileDevices, ANameThatTheUserGrantedIsUsedWithItsLimits)
{
    Workplace::write(_place.outside("grants"),
                     "# mine\n desk = null:?max-amplitude=0.25&hold=10s  # the array\n\nlab=" +
                         _place.outside("lab.json") + "\n");
    midair::haptics::TransducerArray::singleBoard().save(_place.outside("lab.json"));
    const auto scene = fromFile(
        [](HapticScene& s)
        {
            s.setDevice("desk");
            s.setArray("lab");
        });
    const auto viewer = view(*scene);
    EXPECT_EQ(scene->getStatistics().device.rfind("null:", 0), 0u) << messages(*scene);
    EXPECT_FALSE(says(*scene, "asks for")) << messages(*scene);
    EXPECT_LE(strongest(*scene), 0.2501f);
    EXPECT_GT(strongest(*scene), 0.2f);
    EXPECT_NE(SceneAccess::engine(*scene).array(), nullptr);
}

TEST_P(HostileDevices, AFileOfGrantsThatOthersCanWriteGrantsNothing)
{
    const std::string file = _place.outside("grants");
    const auto wish = [](HapticScene& s) { s.setDevice("desk"); };
    for (const std::string& text : {std::string("desk = null:\n"),
                                    std::string("desk = null:\nnonsense\n"),
                                    std::string("desk = null:\ndesk = usb:\n"),
                                    "desk = null:\n" + std::string(100000, '#')})
    {
        Workplace::write(file, text);
        const bool whole = text.size() == 13;
        if (whole) chmod(file.c_str(), 0666);
        const auto scene = fromFile(wish);
        const auto viewer = view(*scene);
        EXPECT_TRUE(simulates(*scene)) << text.substr(0, 40);
        EXPECT_TRUE(says(*scene, "nothing of it is granted")) << messages(*scene);
        chmod(file.c_str(), 0644);
    }
    Workplace::write(file, "desk = null:\n");
    if (chown(file.c_str(), 12345, 12345) != 0) GTEST_SKIP() << "only root gives files away";
    const auto scene = fromFile(wish);
    const auto viewer = view(*scene);
    EXPECT_TRUE(simulates(*scene));
    EXPECT_TRUE(says(*scene, "belongs to another user")) << messages(*scene);
}

TEST_P(HostileDevices, TrustIsSaidAndOpensWhatSceneNames)
{
    const Terminal terminal;
    const Variable trust("OSG_MIDAIR_TRUST", "scene");
    const auto scene = fromFile(
        [&](HapticScene& s)
        {
            s.setArray("sonicsurface");
            s.setDevice("sonicsurface:" + terminal.name());
        });
    const auto viewer = view(*scene);
    EXPECT_TRUE(says(*scene, "OSG_MIDAIR_TRUST=scene")) << messages(*scene);
    EXPECT_TRUE(terminal.touched());
}

TEST_P(HostileDevices, HandsCanBeTakenAway)
{
    for (const char* value : {"none", ""})
    {
        const Variable trust("OSG_MIDAIR_TRUST", "scene");
        const Variable hands("OSG_MIDAIR_HANDS", value);
        const auto scene = fromFile([](HapticScene& s) { s.setHands("openxr:"); });
        const auto viewer = view(*scene);
        EXPECT_EQ(SceneAccess::engine(*scene).hands().active(), nullptr) << "\"" << value << "\"";
        EXPECT_FALSE(says(*scene, "asks for the hands")) << messages(*scene);
    }
}

TEST_P(HostileDevices, AnAmplitudeThatTheUserSetIsNotExceeded)
{
    const auto loud = [](HapticScene& s) { s.setMaxAmplitude(0.6); };
    const auto amplitude = [&](const char* user)
    {
        const Variable cap("OSG_MIDAIR_MAX_AMPLITUDE", user);
        const auto scene = fromFile(loud);
        const auto viewer = view(*scene);
        return strongest(*scene);
    };
    EXPECT_NEAR(amplitude("0.2"), 0.2, 0.01);
    EXPECT_NEAR(amplitude("0.9"), 0.6, 0.01) << "the stricter one counts";
    EXPECT_EQ(amplitude("0"), 0.0f);
}

TEST_P(HostileDevices, ALimitThatIsNotUnderstoodSilences)
{
    for (const auto& [name, value] :
         {std::pair<const char*, const char*>{"OSG_MIDAIR_MAX_AMPLITUDE", "a little"},
          {"OSG_MIDAIR_MAX_AMPLITUDE", "nan"},
          {"OSG_MIDAIR_MAX_AMPLITUDE", "1,5"},
          {"OSG_MIDAIR_MAX_AMPLITUDE", "-1"},
          {"OSG_MIDAIR_MAX_PRESSURE", "eight hundred"},
          {"OSG_MIDAIR_MAX_PRESSURE", "1e99"},
          {"OSG_MIDAIR_ENABLED", "perhaps"}})
    {
        const Variable limit(name, value);
        const auto scene = fromFile([](HapticScene&) {});
        viewBriefly(*scene);
        EXPECT_EQ(SceneAccess::latestResult(*scene), nullptr) << name << "=" << value;
        EXPECT_TRUE(says(*scene, "nothing is played")) << messages(*scene);
    }
    const auto scene = fromFile([](HapticScene& s) { s.setMaxPressure(-5.0); });
    viewBriefly(*scene);
    EXPECT_EQ(SceneAccess::latestResult(*scene), nullptr);
    EXPECT_TRUE(says(*scene, "nothing is played")) << messages(*scene);
}

TEST_P(HostileDevices, ASceneInsideAnotherIsFeltButNotObeyed)
{
    const auto inner = fromFile([](HapticScene& s) { s.setMaxAmplitude(0.3); });
    osg::ref_ptr<HapticScene> outer = new HapticScene;
    outer->setName("outer");
    outer->setArray("board");
    outer->addChild(inner);
    HeadlessViewer viewer(outer);
    EXPECT_TRUE(viewer.framesUntil(
        [&]
        {
            return SceneAccess::latestResult(*outer) &&
                   SceneAccess::latestResult(*outer)->points.size() > 0;
        }));
    EXPECT_LE(strongest(*outer), 0.31f) << "its own caps count";
    EXPECT_EQ(SceneAccess::latestResult(*inner), nullptr);
    EXPECT_TRUE(says(*inner, "is inside the HapticScene \"outer\"")) << messages(*inner);

    inner->setEnabled(false);
    EXPECT_TRUE(
        viewer.framesUntil([&] { return SceneAccess::latestResult(*outer)->points.size() == 0; }))
        << "and so does that it is disabled";
}

TEST_P(HostileDevices, ASecondOwnerIsRefusedByName)
{
    const std::string file = _place.outside("fields");
    BoxScene one;
    BoxScene two;
    one.scene->setName("one");
    two.scene->setName("two");
    one.scene->setDevice("record:" + file);
    two.scene->setDevice("record:" + _place.outside("./fields"));
    const osg::ref_ptr<osg::Group> both = new osg::Group;
    both->addChild(one.scene);
    HeadlessViewer viewer(both);
    ASSERT_TRUE(viewer.framesUntil([&] { return one.points() > 0; }));
    both->addChild(two.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return two.points() > 0; }));
    EXPECT_TRUE(says(*two.scene, "is driven by the HapticScene \"one\"")) << messages(*two.scene);
    EXPECT_EQ(two.scene->getStatistics().device.rfind("not open", 0), 0u);
}

TEST_P(HostileDevices, NumbersThatNameNoChoiceAreTold)
{
    // In binary a choice is a number, and nobody checks it on the way in.
    if (std::string(GetParam()) != "osgb") GTEST_SKIP() << "text formats write names";
    BoxScene box;
    box.surface->setSampling(static_cast<HapticProperty::Sampling>(77));
    box.surface->setSide(static_cast<HapticProperty::Side>(-5));
    box.surface->setPressureUnit(static_cast<HapticProperty::PressureUnit>(1 << 30));
    box.surface->setIntensity(static_cast<HapticProperty::Intensity>(99));
    box.surface->setIntensityChannel(static_cast<HapticProperty::Channel>(-1));
    const std::string file = _place.beside("enums.osgb");
    ASSERT_TRUE(osgDB::writeNodeFile(*box.scene, file));
    const osg::ref_ptr<osg::Node> node = osgDB::readRefNodeFile(file);
    auto* scene = dynamic_cast<HapticScene*>(node.get());
    ASSERT_NE(scene, nullptr);
    const auto viewer = view(*scene);
    for (const char* what : {"sampling is number 77, should be one of surface, edges, vertices",
                             "side is number -5",
                             "unit is number 1073741824",
                             "intensity is number 99",
                             "intensityChannel is number -1"})
        EXPECT_TRUE(says(*scene, what)) << what << "\n" << messages(*scene);
    EXPECT_GT(SceneAccess::latestResult(*scene)->points.size(), 0);
}

INSTANTIATE_TEST_SUITE_P(Formats, HostileDevices, testing::Values("osgt", "osgb", "osgx"));
