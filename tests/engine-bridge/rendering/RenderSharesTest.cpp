#include "engine-bridge/rendering/RenderShares.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "tests/engine-bridge/contact/ContactScenes.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

using namespace midair::bridge;
using namespace midair::bridge::test;
using Eigen::Vector3d;

namespace
{

/// A sheet that is rendered as \a render says, a finger \a depth_m deep in it, and what follows.
struct Scene
{
    explicit Scene(Render render, RenderSharesOptions options = {}) : shares(options)
    {
        objects.push_back(object(sheet()));
        objects[0].properties.render = render;
    }

    /// One frame; \a depth_m: of the finger; none if it isn't finite.
    void frame(double depth_m, double rest_s = 0.0, double sigma_m = 0.0)
    {
        HandFrame hands;
        if (std::isfinite(depth_m)) hands = ball(Vector3d(x_m, 0.0, 8e-3 - depth_m));
        for (Hand& hand : hands.hands)
            for (HandJoint& joint : hand.joints)
                joint.sigma_m = sigma_m;
        time_s += 0.01;
        tracker.update(objects, hands, time_s);
        tracker.advance(0.01);
        shares.update(objects, tracker.contacts(), hands, time_s, rest_s);
        shares.advance(0.01);
    }
    double whole() const { return shares.whole(1); }

    std::vector<HapticObject> objects;
    ContactTracker tracker;
    RenderShares shares;
    double time_s = 0.0;
    double x_m = 0.0;
};

constexpr double kNoHand = std::numeric_limits<double>::quiet_NaN();

} // namespace

TEST(RenderShares, WhatIsWholeStaysWholeAndWhatIsTouchedNever)
{
    Scene whole(Render::OBJECT), touched(Render::CONTACT);
    EXPECT_FALSE(whole.shares.concerns(whole.objects));
    EXPECT_TRUE(touched.shares.concerns(touched.objects));
    for (const double depth_m : {kNoHand, 1.3e-3, -0.05})
        for (int i = 0; i < 30; ++i)
        {
            whole.frame(depth_m);
            touched.frame(depth_m);
            ASSERT_EQ(whole.whole(), 1.0);
            ASSERT_EQ(whole.shares.contacts(1), 0.0);
            ASSERT_EQ(touched.whole(), 0.0);
            ASSERT_EQ(touched.shares.contacts(1), 1.0);
        }
}

TEST(RenderShares, TheSceneDecidesWhereTheObjectInherits)
{
    RenderSharesOptions options;
    options.render = Render::CONTACT;
    Scene scene(Render::INHERIT, options), own(Render::OBJECT, options);
    EXPECT_TRUE(scene.shares.concerns(scene.objects));
    EXPECT_FALSE(own.shares.concerns(own.objects));
}

TEST(RenderShares, AutoFadesInATenthOfASecondWhenHandsAreKnownAndLost)
{
    Scene scene(Render::AUTO);
    scene.frame(kNoHand);
    EXPECT_EQ(scene.whole(), 1.0);
    double power = 0.0;
    int frames = 0;
    while (scene.whole() > 0.0 && ++frames < 100)
    {
        scene.frame(1.3e-3);
        power = std::pow(scene.whole(), 2) + std::pow(scene.shares.contacts(1), 2);
        ASSERT_NEAR(power, 1.0, 1e-9);
    }
    EXPECT_NEAR(frames, 10, 1);
    frames = 0;
    while (scene.whole() < 1.0 && ++frames < 100)
        scene.frame(kNoHand);
    EXPECT_NEAR(frames, 20, 2); // hands count as known for a tenth, too
}

// Or the errors of a point that has faded to next to nothing would be told, and nobody feels it.
TEST(RenderShares, TheLastFiftiethOfAFadeIsLeftOut)
{
    Scene scene(Render::AUTO);
    scene.frame(kNoHand);
    for (int i = 0; i < 9; ++i)
        scene.frame(1.3e-3);
    EXPECT_NEAR(scene.whole(), std::sin(0.05 * midair::base::kPi), 1e-6);
    scene.shares.advance(0.0085);
    EXPECT_TRUE(scene.shares.isFading());
    EXPECT_EQ(scene.whole(), 0.0);
    EXPECT_EQ(scene.shares.contacts(1), 1.0);
    EXPECT_EQ(scene.shares.mostWhole(), 0.0);
}

// At its beginning contacts are as faint: 4e-13 Pa was wanted, and the error told in 1e14 %.
TEST(RenderShares, TheFirstFiftiethOfAFadeIsLeftOutOfContacts)
{
    RenderSharesOptions slow;
    slow.fade_s = 1.0;
    Scene scene(Render::AUTO, slow);
    scene.frame(kNoHand);
    scene.frame(1.3e-3);
    ASSERT_TRUE(scene.shares.isFading());
    EXPECT_NEAR(scene.whole(), std::sin(0.495 * midair::base::kPi), 1e-9);
    EXPECT_EQ(scene.shares.contacts(1), 0.0);
}

TEST(RenderShares, AHandThatIsUncertainFeelsTheWholeObject)
{
    Scene scene(Render::AUTO);
    for (int i = 0; i < 30; ++i)
        scene.frame(1.3e-3);
    EXPECT_EQ(scene.whole(), 0.0);
    for (int i = 0; i < 30; ++i)
        scene.frame(1.3e-3, 0.0, 0.02); // predicted to 20 mm
    EXPECT_EQ(scene.whole(), 1.0);
    for (int i = 0; i < 30; ++i)
        scene.frame(1.3e-3);
    EXPECT_EQ(scene.whole(), 0.0);
    for (int i = 0; i < 30; ++i)
    {
        scene.x_m = 2e-3 * (i - 15); // 0.2 m/s, and 100 ms late: 20 mm
        scene.frame(1.3e-3, 0.1);
    }
    EXPECT_EQ(scene.whole(), 1.0);
}

// e is 5 mm; the radius of a patch 1 mm deep is 3.9 mm.
TEST(RenderShares, TremorOfAMillimetreDoesNotSwitch)
{
    Scene scene(Render::AUTO);
    for (int i = 0; i < 30; ++i)
        scene.frame(1.5e-3);
    ASSERT_EQ(scene.whole(), 0.0);
    for (int i = 0; i < 500; ++i)
    {
        scene.frame(1.5e-3 + 0.5e-3 * std::sin(0.6 * i)); // 1 mm from end to end, 10 Hz
        ASSERT_EQ(scene.whole(), 0.0) << i;
    }
}

TEST(RenderShares, SettingsOutOfRangeAreNamed)
{
    const auto error = [](auto change)
    {
        RenderSharesOptions options;
        change(options);
        std::string text;
        EXPECT_FALSE(options.isValid(&text));
        EXPECT_THROW(RenderShares{options}, midair::base::InputError);
        return text;
    };
    EXPECT_NE(error([](auto& o) { o.fade_s = -1.0; }).find("fade_s"), std::string::npos);
    EXPECT_NE(error([](auto& o) { o.hysteresis = 0.5; }).find("hysteresis"), std::string::npos);
    EXPECT_NE(error([](auto& o) { o.trackerError_m = NAN; }).find("trackerError"),
              std::string::npos);
    EXPECT_NE(error([](auto& o) { o.render = Render::INHERIT; }).find("INHERIT"),
              std::string::npos);
}
