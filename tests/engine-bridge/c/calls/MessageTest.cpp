// Messages of the C interface: listed with their states, told to a callback, and forgotten.
#include "tests/Eventually.h"
#include "tests/engine-bridge/c/Played.h"

#include <cstdlib>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace
{

std::vector<midair_message> listed(midair_scene* scene)
{
    std::vector<midair_message> all(100);
    std::size_t count = 0;
    EXPECT_EQ(midair_list_messages(scene, all.data(), all.size(), &count), MIDAIR_OK);
    all.resize(count);
    return all;
}

std::set<std::string> activeCodes(midair_scene* scene)
{
    std::set<std::string> codes;
    for (const midair_message& message : listed(scene))
        if (message.active) codes.insert(message.code);
    return codes;
}

/// What a callback was told: the newest state of each code.
struct Told
{
    std::map<std::string, bool> active;
    std::map<std::string, std::string> text;
    midair_scene* scene = nullptr;

    static void take(void* user, const midair_message* message, const char* text)
    {
        auto& told = *static_cast<Told*>(user);
        told.active[message->code] = message->active != 0;
        told.text[message->code] = text;
        EXPECT_FALSE(listed(told.scene).empty()) << "it may call functions with the scene";
    }
};

struct Mistake
{
    const char* code;
    std::function<void(const Focus&)> make;
    std::function<void(const Focus&)> mend;
};

} // namespace

TEST(CMessages, AreActiveUntilTheMistakeIsMended)
{
    const auto set = [](const char* name, const char* value)
    { return [=](const Focus& of) { midair_set(of.scene, name, value); }; };
    const auto setObject = [](const char* name, const char* value)
    { return [=](const Focus& of) { midair_object_set(of.scene, of.points, name, value); }; };
    const auto move = [](double z)
    {
        return [=](const Focus& of)
        {
            double matrix[16];
            std::copy_n(kIdentity, 16, matrix);
            matrix[11] = z;
            midair_set_pose(of.scene, of.points, matrix);
        };
    };
    const auto variable = [](const char* value)
    {
        return [=](const Focus&) {
            value ? setenv("OSG_MIDAIR_MAX_PRESSURE", value, 1)
                  : unsetenv("OSG_MIDAIR_MAX_PRESSURE");
        };
    };
    const std::vector<Mistake> mistakes = {
        {"settings.silenced", set("maxPressure", "loud"), set("maxPressure", "0")},
        {"settings.silenced", variable("loud"), variable(nullptr)},
        {"property.silenced", setObject("enabled", "loud"), setObject("enabled", "true")},
        {"object.unreachable", move(40.0), move(0.0)},
        {"solver.unknown", set("solver", "nosuch"), set("solver", "gauss-newton")},
        {"cap.pressure", set("maxPressure", "200 Pa"), set("maxPressure", "0")},
    };
    for (const Mistake& mistake : mistakes)
    {
        SCOPED_TRACE(mistake.code);
        Focus of;
        Told told;
        told.scene = of.scene;
        ASSERT_EQ(midair_on_message(of.scene, &Told::take, &told), MIDAIR_OK);
        ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
        ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING)) << of.messages();
        EXPECT_EQ(activeCodes(of.scene), std::set<std::string>());
        mistake.make(of);
        EXPECT_TRUE(updatesUntil(
            of.scene,
            [&] { return told.active.count(mistake.code) > 0 && told.active[mistake.code]; }));
        EXPECT_EQ(activeCodes(of.scene), std::set<std::string>{mistake.code})
            << "one mistake is one message";
        mistake.mend(of);
        EXPECT_TRUE(updatesUntil(of.scene, [&] { return !told.active[mistake.code]; }));
        EXPECT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING));
        EXPECT_EQ(activeCodes(of.scene), std::set<std::string>());
        ASSERT_EQ(midair_on_message(of.scene, nullptr, nullptr), MIDAIR_OK);
    }
}

TEST(CMessages, HaveANumberATextAndTimes)
{
    Focus of;
    ASSERT_EQ(midair_play(of.scene, "sim:"), MIDAIR_OK);
    ASSERT_TRUE(comesTo(of.scene, MIDAIR_STATE_PLAYING));
    midair_object_set(of.scene, of.points, "enabled", "loud");
    ASSERT_EQ(midair_update(of.scene, 1e5), MIDAIR_SILENCED);
    std::vector<midair_message> all = listed(of.scene);
    ASSERT_EQ(all.size(), 1U);
    EXPECT_STREQ(all[0].code, "property.silenced");
    EXPECT_EQ(all[0].severity, MIDAIR_FAULT);
    EXPECT_EQ(all[0].object, of.points);
    EXPECT_GT(all[0].since_s, 0.0);
    EXPECT_EQ(all[0].until_s, 0.0);
    char text[300];
    ASSERT_EQ(midair_message_text(of.scene, all[0].number, text, sizeof text, nullptr), MIDAIR_OK);
    EXPECT_EQ(of.messages(), text);
    EXPECT_EQ(midair_message_text(of.scene, 12345, text, sizeof text, nullptr), MIDAIR_UNKNOWN);
    ASSERT_EQ(midair_clear_messages(of.scene), MIDAIR_OK);
    EXPECT_EQ(listed(of.scene).size(), 1U) << "it is active";
    midair_object_set(of.scene, of.points, "enabled", "true");
    ASSERT_EQ(midair_update(of.scene, 1e5), MIDAIR_OK);
    all = listed(of.scene);
    ASSERT_EQ(all.size(), 1U);
    EXPECT_EQ(all[0].active, 0);
    EXPECT_GE(all[0].until_s, all[0].since_s);
    ASSERT_EQ(midair_clear_messages(of.scene), MIDAIR_OK);
    EXPECT_TRUE(listed(of.scene).empty());
    std::size_t count = 5;
    EXPECT_EQ(midair_list_messages(of.scene, nullptr, 0, &count), MIDAIR_OK);
    EXPECT_EQ(count, 0U);
    EXPECT_EQ(midair_list_messages(nullptr, nullptr, 0, &count), MIDAIR_CLOSED);
}
