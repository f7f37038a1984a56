// Mistakes that are made and mended: each message is active while it holds, and no longer.
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticPoints>

#include <cstdlib>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

std::set<std::string> activeCodes(const HapticScene& scene)
{
    std::set<std::string> codes;
    for (const HapticMessage& message : scene.getActiveMessages())
        codes.insert(message.code);
    return codes;
}

struct Mistake
{
    const char* name;
    std::string code; ///< of its message
    std::function<void(BoxScene&)> make;
    std::function<void(BoxScene&)> mend;
};

std::ostream& operator<<(std::ostream& out, const Mistake& mistake)
{
    return out << mistake.name;
}

std::vector<Mistake> mistakesOfSettings()
{
    static const osg::Matrixd kStretched = osg::Matrixd::scale(2.0, 1.0, 1.0);
    return {
        {"solver",
         "solver.unknown",
         [](BoxScene& box) { box.scene->setSolver("nosuch"); },
         [](BoxScene& box) { box.scene->setSolver("gauss-newton"); }},
        {"pressure",
         "property.silenced",
         [](BoxScene& box) { box.surface->setPressure(-5.0); },
         [](BoxScene& box) { box.surface->setPressure(1.0); }},
        {"spacing",
         "property.invalid",
         [](BoxScene& box) { box.surface->setSpacing(-1.0); },
         [](BoxScene& box) { box.surface->setSpacing(0.0); }},
        {"amplitude",
         "settings.silenced",
         [](BoxScene& box) { box.scene->setMaxAmplitude(2.0); },
         [](BoxScene& box) { box.scene->setMaxAmplitude(1.0); }},
        {"unit",
         "settings.silenced",
         [](BoxScene& box) { box.scene->setMetresPerUnit(0.0); },
         [](BoxScene& box) { box.scene->setMetresPerUnit(1.0); }},
        {"calibration",
         "settings.calibration",
         [](BoxScene& box) { box.scene->setCalibration(kStretched); },
         [](BoxScene& box) { box.scene->setCalibration(osg::Matrixd()); }},
        {"number",
         "settings.invalid",
         [](BoxScene& box) { box.scene->setCycle(-3); },
         [](BoxScene& box) { box.scene->setCycle(1); }},
        {"array",
         "array.invalid",
         [](BoxScene& box) { box.scene->setArray("/nonexistent/array.json"); },
         [](BoxScene& box) { box.scene->setArray("board"); }},
        {"device",
         "device.open",
         [](BoxScene& box) { box.scene->setDevice("nosuch:"); },
         [](BoxScene& box) { box.scene->setDevice("sim:"); }},
        {"hands",
         "hands.open",
         [](BoxScene& box) { box.scene->setHands("nosuch:"); },
         [](BoxScene& box) { box.scene->setHands(""); }},
        {"variable",
         "settings.silenced",
         [](BoxScene&) { setenv("OSG_MIDAIR_MAX_PRESSURE", "loud", 1); },
         [](BoxScene&) { unsetenv("OSG_MIDAIR_MAX_PRESSURE"); }},
    };
}

std::vector<Mistake> mistakesOfWhatIsFelt()
{
    return {
        {"far",
         "object.unreachable",
         [](BoxScene& box) { box.move(40.0); },
         [](BoxScene& box) { box.move(0.0); }},
        {"hidden",
         "object.hidden",
         [](BoxScene& box) { box.surface->setNodeMask(0); },
         [](BoxScene& box) { box.surface->setNodeMask(~0U); }},
        {"cap",
         "cap.pressure",
         [](BoxScene& box) { box.scene->setMaxPressure(200.0); },
         [](BoxScene& box) { box.scene->setMaxPressure(0.0); }},
        {"silenced",
         "field.silenced",
         [](BoxScene& box) { box.scene->setMaxAmplitude(0.0); },
         [](BoxScene& box) { box.scene->setMaxAmplitude(1.0); }},
    };
}

std::vector<Mistake> mistakes()
{
    std::vector<Mistake> all = mistakesOfSettings();
    for (Mistake& mistake : mistakesOfWhatIsFelt())
        all.push_back(std::move(mistake));
    return all;
}

/// Keeps what it is told: the newest state of each code.
struct Listener : MessageCallback
{
    void told(const HapticMessage& message) override
    {
        ++calls[message.code];
        active[message.code] = message.isActive;
    }
    std::map<std::string, int> calls;
    std::map<std::string, bool> active;
};

class MessagesOfMistakes : public testing::TestWithParam<Mistake>
{
};

} // namespace

INSTANTIATE_TEST_SUITE_P(Made,
                         MessagesOfMistakes,
                         testing::ValuesIn(mistakes()),
                         [](const testing::TestParamInfo<Mistake>& info)
                         { return std::string(info.param.name); });

TEST_P(MessagesOfMistakes, AreActiveUntilTheyAreMended)
{
    const Mistake& mistake = GetParam();
    BoxScene box;
    const osg::ref_ptr<Listener> listener = new Listener;
    box.scene->setMessageCallback(listener);
    HeadlessViewer viewer(box.scene);
    const auto plays = [&] { return box.scene->getStatistics().state == ArrayState::PLAYING; };
    const auto says = [&] { return activeCodes(*box.scene).count(mistake.code) > 0; };
    ASSERT_TRUE(viewer.framesUntil(plays));
    EXPECT_EQ(activeCodes(*box.scene), std::set<std::string>());

    for (int time = 1; time <= 2; ++time)
    {
        mistake.make(box);
        EXPECT_TRUE(viewer.framesUntil(says));
        viewer.frame();
        EXPECT_TRUE(listener->active[mistake.code]);
        EXPECT_EQ(activeCodes(*box.scene), std::set<std::string>{mistake.code})
            << "one mistake is one message";
        mistake.mend(box);
        EXPECT_TRUE(viewer.framesUntil([&] { return plays() && !says(); }));
        viewer.frame();
        EXPECT_FALSE(listener->active[mistake.code]);
        EXPECT_EQ(activeCodes(*box.scene), std::set<std::string>());
    }
    const auto told = box.scene->getStatistics().told;
    const auto found =
        std::find_if(told.begin(),
                     told.end(),
                     [&](const HapticMessage& message) { return message.code == mistake.code; });
    ASSERT_NE(found, told.end()) << "what has ended is kept";
    EXPECT_FALSE(found->isActive);
    EXPECT_GT(found->since_s, 0.0);
    EXPECT_GE(found->until_s, found->since_s);
    EXPECT_LE(found->until_s, midair::base::steadySeconds());
    box.scene->clearMessages();
    EXPECT_TRUE(box.scene->getStatistics().told.empty());
}

TEST(ActiveMessages, NameTheirNode)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    box.move(40.0);
    ASSERT_TRUE(viewer.framesUntil([&] { return !box.scene->getActiveMessages().empty(); }));
    const HapticMessage message = box.scene->getActiveMessages().front();
    EXPECT_EQ(message.code, "object.unreachable");
    EXPECT_EQ(message.node.get(), box.surface.get());
    box.surface->setPressure(-5.0);
    ASSERT_TRUE(
        viewer.framesUntil([&] { return activeCodes(*box.scene).count("property.silenced") > 0; }));
    for (const HapticMessage& one : box.scene->getActiveMessages())
        EXPECT_EQ(one.node.get(), box.surface.get()) << one.text;
}

TEST(ActiveMessages, OfAnObjectEndWithIt)
{
    BoxScene box;
    box.surface->setSpacing(-1.0);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return !activeCodes(*box.scene).empty(); }));
    osg::ref_ptr<osgMidair::HapticSurface> keep = box.surface;
    box.transform->removeChild(box.surface);
    const osg::ref_ptr<HapticPoints> other = new HapticPoints;
    other->setPoints({osg::Vec3d(0.0, 0.0, 0.15)});
    box.scene->addChild(other);
    EXPECT_TRUE(viewer.framesUntil([&] { return activeCodes(*box.scene).empty(); }));
    box.transform->addChild(keep);
    EXPECT_TRUE(
        viewer.framesUntil([&] { return activeCodes(*box.scene).count("property.invalid") > 0; }))
        << "it is back, and as wrong as before";
}

TEST(ActiveMessages, OfACallbackThatThrowsDontReachIt)
{
    struct Throwing : MessageCallback
    {
        void told(const HapticMessage& message) override
        {
            codes.push_back(message.code);
            throw std::runtime_error("no lamp");
        }
        std::vector<std::string> codes;
    };
    BoxScene box;
    const osg::ref_ptr<Throwing> callback = new Throwing;
    box.scene->setMessageCallback(callback);
    box.move(40.0);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return !callback->codes.empty(); }));
    viewer.frames(5);
    EXPECT_EQ(callback->codes, std::vector<std::string>{"object.unreachable"});
    EXPECT_TRUE(::says(*box.scene, "the message callback has thrown \"no lamp\""));
}
