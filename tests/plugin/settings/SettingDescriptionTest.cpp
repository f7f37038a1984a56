// What the kit says of its settings and overlays in public types: that it is what the tables say.
#include "plugin/overlays/OverlayPart.h"
#include "plugin/settings/AllSettings.h"

#include <osgMidair/HapticOverlays>

#include <algorithm>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

template<typename T>
void expectAll(const SettingTable<T>& table)
{
    const std::vector<SettingDescription> said = T::getDescriptions();
    ASSERT_EQ(said.size(), table.rows().size());
    for (std::size_t i = 0; i < said.size(); ++i)
    {
        const Setting<T>& row = table.rows()[i];
        SCOPED_TRACE(row.name);
        EXPECT_EQ(said[i].name, row.name);
        EXPECT_EQ(said[i].summary, row.summary());
        EXPECT_EQ(said[i].values, row.values());
        EXPECT_EQ(said[i].words.size(), row.words.size());
        // The default is a value that set() takes, or it is not told as one.
        if (!said[i].initial.empty())
        {
            EXPECT_EQ(T::problemOf(row.name, said[i].initial), "");
        }
    }
}

SettingDescription find(const std::vector<SettingDescription>& all, const std::string& name)
{
    const auto found = std::find_if(
        all.begin(), all.end(), [&](const SettingDescription& one) { return one.name == name; });
    return found == all.end() ? SettingDescription() : *found;
}

} // namespace

TEST(SettingDescription, SaysWhatTheTablesSay)
{
    expectAll(sceneSettings());
    expectAll(surfaceProperties());
    const SettingDescription rate = find(HapticSettings::getDescriptions(), "fieldRate");
    EXPECT_EQ(rate.values, "1 .. 40000 Hz");
    EXPECT_EQ(rate.unit, "Hz");
    EXPECT_EQ(rate.low, 1.0);
    EXPECT_EQ(rate.high, 40000.0);
    EXPECT_FALSE(rate.isFlag);
    EXPECT_TRUE(find(HapticSettings::getDescriptions(), "phaseOnly").isFlag);
    const SettingDescription sampling = find(HapticProperty::getDescriptions(), "sampling");
    EXPECT_EQ(sampling.words, (std::vector<std::string>{"surface", "edges", "vertices"}));
    EXPECT_EQ(sampling.initial, "surface");
}

TEST(SettingDescription, TellsWhatIsWrongWithAValue)
{
    EXPECT_EQ(HapticSettings::problemOf("temperature", "20"), "");
    EXPECT_EQ(HapticSettings::problemOf("temperature", "100"),
              "is \"100\", should be a number, -40 .. 60 C");
    EXPECT_EQ(HapticSettings::problemOf("temperature", "warm"),
              "is \"warm\", should be a number, -40 .. 60 C");
    EXPECT_EQ(HapticProperty::problemOf("sampling", "corners"),
              "is \"corners\", should be one of surface, edges, vertices");
    EXPECT_EQ(HapticProperty::problemOf("colour", "red").rfind("unknown option \"colour\"", 0), 0u);
}

TEST(SettingDescription, NamesEveryOverlayAndItsNumbers)
{
    const std::vector<OverlayDescription> all = HapticOverlays::describe();
    ASSERT_EQ(all.size(), overlayKinds().size());
    const osg::ref_ptr<HapticOverlays> overlays = new HapticOverlays;
    int numbers = 0;
    for (const OverlayDescription& one : all)
    {
        EXPECT_NE(overlays->getOverlay(one.name), nullptr) << one.name;
        EXPECT_EQ(overlays->getOverlay(one.name), overlays->getOverlay(one.word));
        EXPECT_NE(HapticOverlays::keyNames().find(one.key), std::string::npos) << one.key;
        for (const SettingDescription& number : one.numbers)
        {
            ++numbers;
            EXPECT_TRUE(overlays->setNumber(number.name, number.low)) << number.name;
            EXPECT_TRUE(overlays->setNumber(number.name, std::stod(number.initial)))
                << number.name << " is " << number.initial;
        }
    }
    EXPECT_GE(numbers, 8);
}
