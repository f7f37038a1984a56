// The C interface has the settings and properties of scenes: the same names, ranges, words,
// defaults and help.
#include <osgMidair/HapticProperty>
#include <osgMidair/HapticSettings>

#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <midair.h>

using namespace osgMidair;

namespace
{

/// Compares what the C interface lists with \a ofKit; returns what it doesn't have.
template<typename Descriptions>
std::set<std::string> lacking(int ofObjects, const Descriptions& ofKit)
{
    std::map<std::string, std::string> summaries(ofKit.begin(), ofKit.end());
    const char* name = nullptr;
    const char* summary = nullptr;
    std::size_t count = 0;
    for (; midair_setting(ofObjects, count, &name, &summary) == MIDAIR_OK; ++count)
    {
        const auto found = summaries.find(name);
        EXPECT_NE(found, summaries.end()) << name << " is no setting of scenes";
        if (found == summaries.end()) continue;
        EXPECT_EQ(summary, found->second) << name;
        summaries.erase(found);
    }
    EXPECT_GT(count, 10U);
    std::set<std::string> left;
    for (const auto& entry : summaries)
        left.insert(entry.first);
    return left;
}

} // namespace

TEST(CInterfaceSettings, AreThoseOfScenes)
{
    EXPECT_EQ(
        lacking(0, HapticSettings::describe()),
        (std::set<std::string>{
            "array", "calibration", "device", "earCamera", "hands", "heads", "metresPerUnit"}));
    EXPECT_EQ(
        lacking(1, HapticProperty::describe()),
        (std::set<std::string>{"intensity", "intensityChannel", "intensityHigh", "intensityLow"}));
}
