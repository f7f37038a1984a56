#include "engine-bridge/settings/SceneTable.h"

#include <gtest/gtest.h>

using namespace midair;
using bridge::SceneSettings;

TEST(SceneTable, SaysWhatFollowsFromAChange)
{
    const SceneSettings before;
    const auto effectOf = [&](const std::string& name, const std::string& value)
    {
        SceneSettings after;
        std::string error;
        EXPECT_TRUE(bridge::sceneTable().set(after, name, value, error)) << error;
        return bridge::sceneTable().effects(before, after);
    };
    EXPECT_EQ(effectOf("loudness", "0.5"), base::Effect::SOLVE);
    EXPECT_EQ(effectOf("earPoints", "0 0 1"), base::Effect::SOLVE);
    EXPECT_EQ(effectOf("render", "contact"), base::Effect::SOLVE);
    EXPECT_EQ(effectOf("dead", "3"), base::Effect::REOPEN);
    EXPECT_EQ(effectOf("weak", "3:0.5"), base::Effect::REOPEN);
    for (const char* own : {"enabled", "reach", "shadows", "prediction", "temperature"})
    {
        const std::string name = own;
        const std::string value = name == "enabled"      ? "false"
                                  : name == "shadows"    ? "true"
                                  : name == "prediction" ? "kalman"
                                                         : "3";
        EXPECT_EQ(effectOf(name, value), base::Effect::NOTHING) << name;
    }
    EXPECT_EQ(bridge::sceneTable().effects(before, SceneSettings()), base::Effect::NOTHING);
}

TEST(SceneTable, EffectsOfSeveralChangesAreJoined)
{
    SceneSettings after;
    after.dead = "1";
    after.maxPressure = 300.0;
    EXPECT_EQ(bridge::sceneTable().effects({}, after), base::Effect::SOLVE | base::Effect::REOPEN);
}
