// A scene of the C interface on devices, with hands.
#include "tests/Eventually.h"
#include "tests/device/limits/UserCapTexts.h"
#include "tests/engine-bridge/c/Played.h"

#include <osgMidair/ArrayState>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <functional>
#include <utility>

#include <sys/resource.h>

// One name for each in C, in C++ and in texts (Python's are compared by the test Python.interface).
TEST(CPlay, StatesHaveOneNameInAllLanguages)
{
    using osgMidair::ArrayState;
    const std::pair<int, const char*> names[] = {{MIDAIR_STATE_CLOSED, "closed"},
                                                 {MIDAIR_STATE_OPENING, "opening"},
                                                 {MIDAIR_STATE_SILENT, "silent"},
                                                 {MIDAIR_STATE_PLAYING, "playing"},
                                                 {MIDAIR_STATE_MUTED, "muted"},
                                                 {MIDAIR_STATE_LOST, "lost"},
                                                 {MIDAIR_STATE_FAULT, "fault"}};
    for (const auto& [number, name] : names)
        EXPECT_STREQ(osgMidair::stateName(static_cast<ArrayState>(number)), name);
}

TEST(CPlay, PlaysMutesAndStops)
{
    Focus of;
    midair_field* field = nullptr;
    EXPECT_EQ(midair_newest_field(of.scene, &field), MIDAIR_NOT_YET);
    EXPECT_EQ(stateOf(of.scene), MIDAIR_STATE_CLOSED);
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK) << midair_last_error();
    ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << of.messages();
    ASSERT_TRUE(updatesUntil(of.scene,
                             [&]
                             {
                                 midair_field_info info{};
                                 return midair_newest_field(of.scene, &field) == MIDAIR_OK &&
                                        midair_field_about(field, &info) == MIDAIR_OK &&
                                        info.playing == 1;
                             }));
    midair_point point{};
    ASSERT_EQ(midair_field_points(field, &point, 1), MIDAIR_OK) << midair_last_error();
    EXPECT_EQ(point.object, of.points);
    EXPECT_GT(point.achieved_Pa, 500.0);
    EXPECT_NEAR(point.wanted_Pa, point.achieved_Pa, 0.02 * point.wanted_Pa);
    EXPECT_EQ(midair_field_close(field), MIDAIR_OK);
    std::size_t needed = 0;
    EXPECT_EQ(midair_device_status(of.scene, nullptr, 0, &needed), MIDAIR_OK);
    EXPECT_GT(needed, 5U);
    ASSERT_EQ(midair_mute(of.scene, 1), MIDAIR_OK);
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_MUTED));
    ASSERT_EQ(midair_mute(of.scene, 0), MIDAIR_OK);
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING));
    // What is out of reach is silence, and said.
    double far[16];
    std::copy_n(kIdentity, 16, far);
    far[11] = 5.0;
    ASSERT_EQ(midair_set_pose(of.scene, of.points, far), MIDAIR_OK);
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_SILENT));
    EXPECT_TRUE(updatesUntil(of.scene, [&] { return !of.messages().empty(); }));
    EXPECT_EQ(midair_stop(of.scene), MIDAIR_OK);
    EXPECT_EQ(stateOf(of.scene), MIDAIR_STATE_CLOSED);
    EXPECT_EQ(midair_update(of.scene, 1e6), MIDAIR_NOT_YET);
    EXPECT_EQ(midair_stop(of.scene), MIDAIR_OK) << "again";
}

TEST(CPlay, AMisunderstoodCapSilencesWhatPlays)
{
    Focus of;
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING));
    EXPECT_EQ(midair_set(of.scene, "maxPressure", "loud"), MIDAIR_INVALID);
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_SILENT));
    EXPECT_EQ(midair_update(of.scene, 1e5), MIDAIR_SILENCED);
    EXPECT_EQ(midair_set(of.scene, "maxPressure", "100 Pa"), MIDAIR_OK);
    EXPECT_EQ(midair_update(of.scene, 1e5), MIDAIR_OK);
    EXPECT_EQ(midair_update(of.scene, 1.0), MIDAIR_INVALID) << "time goes on";
    EXPECT_EQ(midair_stop(of.scene), MIDAIR_OK);
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING));
    midair_field* field = nullptr;
    ASSERT_TRUE(
        updatesUntil(of.scene, [&] { return midair_newest_field(of.scene, &field) == MIDAIR_OK; }));
    midair_point point{};
    ASSERT_EQ(midair_field_points(field, &point, 1), MIDAIR_OK);
    EXPECT_LE(point.achieved_Pa, 100.0 + 1e-3);
    midair_field_close(field);
}

TEST(CPlay, ADeviceThatCannotBeOpenedIsTold)
{
    Focus of;
    ASSERT_EQ(midair_play(of.scene, "record:/nosuch/folder/file.hfr"), MIDAIR_OK);
    EXPECT_TRUE(updatesUntil(
        of.scene, [&] { return of.messages().find("/nosuch/folder") != std::string::npos; }))
        << of.messages();
    EXPECT_NE(stateOf(of.scene), MIDAIR_STATE_PLAYING);
}

TEST(CHands, ContactsOfAFingerOnThePlate)
{
    Opened of("octagon");
    const double vertices[] = {
        -0.03, 0.0, -0.03, 0.03, 0.0, -0.03, 0.03, 0.0, 0.03, -0.03, 0.0, 0.03};
    const uint32_t triangles[] = {0, 2, 1, 0, 3, 2};
    midair_object plate = 0;
    ASSERT_EQ(midair_add_mesh(of.scene, vertices, 4, triangles, 2, nullptr, &plate), MIDAIR_OK);
    ASSERT_EQ(midair_object_set(of.scene, plate, "touchEvents", "true"), MIDAIR_OK);
    ASSERT_EQ(midair_set(of.scene, "render", "contact"), MIDAIR_OK);
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    midair_hand hand{};
    const double tip[] = {0.0, 0.006, 0.0};
    const double turn[] = {-0.70710678, 0.0, 0.0, 0.70710678}; // fingers down
    ASSERT_EQ(midair_make_hand(1, tip, turn, &hand), MIDAIR_OK) << midair_last_error();
    std::vector<midair_contact> contacts(8);
    std::vector<midair_touch> touches(64);
    std::size_t count = 0;
    ASSERT_TRUE(updatesUntil(of.scene,
                             [&]
                             {
                                 midair_set_hands(of.scene, &hand, 1);
                                 return midair_contacts(of.scene, contacts.data(), 8, &count) ==
                                            MIDAIR_OK &&
                                        count > 0 && contacts[0].foci > 0;
                             }))
        << of.messages();
    EXPECT_EQ(contacts[0].object, plate);
    EXPECT_EQ(contacts[0].hand, 1);
    EXPECT_NEAR(contacts[0].centre[1], 0.0, 1e-6);
    EXPECT_GT(contacts[0].area_m2, 0.0);
    ASSERT_EQ(midair_touches(of.scene, touches.data(), 64, &count), MIDAIR_OK);
    ASSERT_GE(count, 1U);
    EXPECT_EQ(touches[0].object, plate);
    if (count > 0)
    {
        EXPECT_EQ(midair_touches(of.scene, touches.data(), 0, &count), MIDAIR_TOO_SMALL);
    }
    midair_hand last[2] = {};
    ASSERT_EQ(midair_last_hands(of.scene, last, 2, &count), MIDAIR_OK) << midair_last_error();
    ASSERT_EQ(count, 1U);
    EXPECT_EQ(last[0].id, 1);
    for (int j = 0; j < MIDAIR_JOINTS; ++j)
    {
        EXPECT_EQ(last[0].joints[j].position_valid, 1) << j;
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(last[0].joints[j].position[axis], hand.joints[j].position[axis], 1e-3) << j;
        EXPECT_NEAR(last[0].joints[j].radius_m, hand.joints[j].radius_m, 1e-6) << j;
    }
    EXPECT_EQ(midair_last_hands(of.scene, last, 0, &count), MIDAIR_TOO_SMALL);
    EXPECT_EQ(midair_last_hands(nullptr, last, 2, &count), MIDAIR_CLOSED);
    hand.joints[0].position[0] = NAN;
    EXPECT_EQ(midair_set_hands(of.scene, &hand, 1), MIDAIR_INVALID);
    hand.joints[0].position[0] = 0.0;
    hand.joints[0].radius_m = 1.0;
    EXPECT_EQ(midair_set_hands(of.scene, &hand, 1), MIDAIR_INVALID);
    EXPECT_EQ(midair_set_hands(of.scene, nullptr, 0), MIDAIR_OK);
    EXPECT_EQ(midair_set_hands(of.scene, &hand, 65), MIDAIR_INVALID);
    EXPECT_TRUE(updatesUntil(of.scene,
                             [&] {
                                 return midair_contacts(of.scene, contacts.data(), 8, &count) ==
                                            MIDAIR_OK &&
                                        count == 0;
                             }));
    ASSERT_EQ(midair_last_hands(of.scene, last, 2, &count), MIDAIR_OK);
    EXPECT_EQ(count, 0U) << "they have gone";
}

// As the kit has it, in EarsTest.cpp, and with the same texts.
TEST(CPlay, EachTextOfTheUsersCapsIsUnderstoodOrSilences)
{
    for (const UserCapText& one : userCapTexts())
    {
        const SetVariable variable(one.variable, one.text);
        Focus of;
        ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
        if (one.isUnderstood)
        {
            EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING))
                << one.variable << "=" << one.text << ": " << of.messages();
            continue;
        }
        EXPECT_TRUE(updatesUntil(of.scene,
                                 [&] {
                                     return of.messages().find(std::string(one.variable) +
                                                               " is \"") != std::string::npos;
                                 }))
            << one.variable << "=" << one.text << ": " << of.messages();
        EXPECT_NE(stateOf(of.scene), MIDAIR_STATE_PLAYING) << one.variable << "=" << one.text;
        EXPECT_EQ(midair_update(of.scene, 1e6), MIDAIR_SILENCED) << one.variable << "=" << one.text;
    }
}

// Set before the scene plays, and while it does.
TEST(CPlay, AUserWhoDisablesTheArrayIsObeyed)
{
    for (const bool isLate : {false, true})
    {
        SCOPED_TRACE(isLate);
        Focus of;
        if (isLate)
        {
            ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
            ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING));
        }
        const SetVariable enabled("OSG_MIDAIR_ENABLED", "false");
        if (!isLate)
        {
            ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
        }
        EXPECT_TRUE(
            updatesUntil(of.scene, [&] { return stateOf(of.scene) != MIDAIR_STATE_PLAYING; }));
        EXPECT_EQ(midair_update(of.scene, 1e6), MIDAIR_SILENCED);
        EXPECT_EQ(std::string(midair_last_error()),
                  "OSG_MIDAIR_ENABLED is false; nothing is played");
        EXPECT_NE(stateOf(of.scene), MIDAIR_STATE_PLAYING);
    }
}

TEST(CPlay, PlacesThatAreNotUnderstoodAreRefused)
{
    for (const UserCapText& one : userCapTexts())
    {
        if (one.variable != std::string("OSG_MIDAIR_EAR_POINTS")) continue;
        const Focus of;
        EXPECT_EQ(midair_set(of.scene, "earPoints", one.text.c_str()),
                  one.isUnderstood ? MIDAIR_OK : MIDAIR_INVALID)
            << one.text;
        EXPECT_EQ(midair_update(of.scene, 0.0), MIDAIR_NOT_YET);
    }
}

TEST(CPlay, AVariableThatIsSetWhileItPlaysHoldsFromThenOn)
{
    Focus of;
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING));
    const auto comesBelow = [&](double most_Pa)
    {
        return updatesUntil(of.scene,
                            [&]
                            {
                                midair_field* field = nullptr;
                                midair_point point{};
                                if (midair_newest_field(of.scene, &field) != MIDAIR_OK)
                                    return false;
                                midair_field_points(field, &point, 1);
                                midair_field_close(field);
                                return point.achieved_Pa > 0.0 && point.achieved_Pa <= most_Pa;
                            });
    };
    ASSERT_FALSE(of.messages().find("cap of") != std::string::npos);
    {
        const SetVariable pressure("OSG_MIDAIR_MAX_PRESSURE", "100");
        EXPECT_TRUE(comesBelow(100.0 + 1e-3)) << of.messages();
    }
    const SetVariable wrong("OSG_MIDAIR_MAX_PRESSURE", "loud");
    EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_SILENT));
    EXPECT_NE(of.messages().find("OSG_MIDAIR_MAX_PRESSURE is \"loud\""), std::string::npos)
        << of.messages();
}

namespace
{

/// A finger 2 mm in a plate, which is felt as a whole.
struct Pressed : Opened
{
    explicit Pressed(const std::string& device = "sim:") : Opened("octagon")
    {
        const double vertices[] = {
            -0.03, 0.0, -0.03, 0.03, 0.0, -0.03, 0.03, 0.0, 0.03, -0.03, 0.0, 0.03};
        const uint32_t triangles[] = {0, 2, 1, 0, 3, 2};
        EXPECT_EQ(midair_add_mesh(scene, vertices, 4, triangles, 2, nullptr, &plate), MIDAIR_OK);
        EXPECT_EQ(midair_object_set(scene, plate, "touchEvents", "true"), MIDAIR_OK);
        EXPECT_EQ(midair_object_set(scene, plate, "spacing", "15 mm"), MIDAIR_OK);
        const double tip[] = {0.0, 0.005, 0.0};
        const double turn[] = {-0.70710678, 0.0, 0.0, 0.70710678}; // fingers down
        EXPECT_EQ(midair_make_hand(1, tip, turn, &hand), MIDAIR_OK);
        EXPECT_EQ(midair_play(scene, device.c_str()), MIDAIR_OK) << midair_last_error();
    }

    bool until(const std::function<bool()>& reached)
    {
        return updatesUntil(scene,
                            [&]
                            {
                                midair_set_hands(scene, &hand, 1);
                                return reached();
                            });
    }
    /// Runs \a count updates.
    void updates(int count)
    {
        until([&] { return --count <= 0; });
    }
    /// The largest force of a touch; -1: none touches.
    double force_N() const
    {
        std::vector<midair_touch> touches(64);
        std::size_t count = 0;
        EXPECT_EQ(midair_touches(scene, touches.data(), touches.size(), &count), MIDAIR_OK);
        double most_N = -1.0;
        for (std::size_t i = 0; i < count; ++i)
            if (touches[i].touching != 0) most_N = std::max(most_N, touches[i].force_N);
        return most_N;
    }

    midair_object plate = 0;
    midair_hand hand{};
};

} // namespace

TEST(CHands, NoTouchHasAForceWhateverSilencesTheArray)
{
    struct Case
    {
        const char* name;
        std::function<void(Pressed&)> silence;
        std::function<void(Pressed&)> undo;
        double silent_N; ///< -1: touches end
        bool isAtOnce;   ///< needs no update
    };
    const auto set = [](const char* name, const char* value)
    { return [=](Pressed& of) { midair_set(of.scene, name, value); }; };
    const Case cases[] = {
        {"muted",
         [](Pressed& of) { midair_mute(of.scene, 1); },
         [](Pressed& of) { midair_mute(of.scene, 0); },
         0.0,
         true},
        {"no amplitude", set("maxAmplitude", "0"), set("maxAmplitude", "1"), 0.0, false},
        {"a cap that nothing keeps",
         set("maxPressure", "0.01 Pa"),
         set("maxPressure", "0"),
         0.0,
         false},
        {"misunderstood", set("maxPressure", "loud"), set("maxPressure", "0"), -1.0, false},
        {"disabled", set("enabled", "false"), set("enabled", "true"), -1.0, false},
        {"stopped",
         [](Pressed& of) { midair_stop(of.scene); },
         [](Pressed& of) { midair_play(of.scene, "sim:"); },
         -1.0,
         true},
    };
    for (const Case& one : cases)
    {
        Pressed of;
        ASSERT_TRUE(of.until([&] { return of.force_N() > 0.0; })) << one.name << of.messages();
        EXPECT_EQ(stateOf(of.scene), MIDAIR_STATE_PLAYING) << one.name;
        one.silence(of);
        if (one.isAtOnce)
        {
            EXPECT_EQ(of.force_N(), one.silent_N) << one.name;
        }
        for (int i = 0; i < 5; ++i)
        {
            of.updates(1);
            EXPECT_EQ(of.force_N(), one.silent_N) << one.name << ", update " << i;
        }
        one.undo(of);
        EXPECT_TRUE(of.until([&] { return of.force_N() > 0.0; })) << one.name << ", undone";
    }
}

TEST(CHands, NoTouchHasAForceWithoutAnArrayThatPlays)
{
    // One that can't be opened, and one that takes fields and plays none.
    for (const std::string device : {"record:/nosuch/folder/file", "sim:?drop=1"})
    {
        Pressed of(device);
        const int32_t state = device == "sim:?drop=1" ? MIDAIR_STATE_FAULT : MIDAIR_STATE_CLOSED;
        ASSERT_TRUE(of.until([&] { return of.force_N() >= 0.0 && stateOf(of.scene) == state; }))
            << device;
        for (int i = 0; i < 50; ++i)
        {
            of.updates(1);
            EXPECT_EQ(of.force_N(), 0.0) << device;
        }
    }
    Pressed lost("sim:?unplug_at=1s");
    ASSERT_TRUE(lost.until([&] { return lost.force_N() > 0.0; }));
    ASSERT_TRUE(lost.until([&] { return stateOf(lost.scene) == MIDAIR_STATE_LOST; }));
    lost.updates(1);
    EXPECT_EQ(lost.force_N(), 0.0);
    Pressed held("sim:?hold=200ms");
    ASSERT_TRUE(held.until([&] { return held.force_N() > 0.0; }));
    EXPECT_TRUE(eventually([&] { return held.force_N() == 0.0; })) << "nobody leads it";
    EXPECT_TRUE(held.until([&] { return held.force_N() > 0.0; }));
    ASSERT_EQ(midair_set_hands(held.scene, nullptr, 0), MIDAIR_OK);
    EXPECT_TRUE(updatesUntil(held.scene, [&] { return held.force_N() < 0.0; })) << "nobody there";
}

// Updates that move nothing leave no time in which the device is looked after.
TEST(CPlay, AFullDiskIsToldHoweverFieldsArePlayed)
{
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const rlimit small{40000, before.rlim_max};
    const std::string file = testing::TempDir() + "midair-full.recording";
    const std::pair<const char*, const char*> all[] = {
        {"cycle", "4"}, {"subsets", "2"}, {"cycleSteps", "8"}, {"render", "auto"}};
    for (const auto& [name, value] : all)
    {
        Pressed of("null:");
        ASSERT_EQ(midair_set(of.scene, name, value), MIDAIR_OK) << name << midair_last_error();
        ASSERT_EQ(midair_object_set(of.scene, of.plate, "modulationFrequency", "150"), MIDAIR_OK)
            << midair_last_error();
        ASSERT_EQ(midair_play(of.scene, ("record:" + file).c_str()), MIDAIR_OK);
        ASSERT_TRUE(of.until([&] { return stateOf(of.scene) == MIDAIR_STATE_PLAYING; })) << name;
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
        EXPECT_TRUE(of.until([&] { return stateOf(of.scene) == MIDAIR_STATE_LOST; })) << name;
        EXPECT_TRUE(
            of.until([&] { return of.messages().find("writing failed") != std::string::npos; }))
            << name << of.messages();
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
        midair_stop(of.scene);
        std::remove(file.c_str());
    }
}
