// The table of settings: that it is whole, and that what is made from it follows it row by row.
#include "engine-bridge/settings/SceneTable.h"
#include "haptics/sequence/FieldSettings.h"
#include "haptics/solvers/SolverSettings.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/UserOptions.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/ArrayGhost>
#include <osgMidair/HapticOverlays>

#include <osg/ApplicationUsage>
#include <osgDB/Registry>

#include <cmath>
#include <cstdlib>
#include <set>
#include <sstream>
#include <tuple>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// Stands for a member of any type.
struct Anything
{
    template<typename T>
    operator T() const; // NOLINT(google-explicit-constructor)
};

// Counting begins with too few.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"

/// How many members the aggregate \a T has.
template<typename T, typename... Members>
constexpr auto countMembers(int, Members... members) -> decltype(T{members..., Anything()}, 0)
{
    return countMembers<T>(0, members..., Anything());
}
template<typename T, typename... Members>
constexpr int countMembers(long, Members...)
{
    return sizeof...(Members);
}

#pragma GCC diagnostic pop

/// A text that \a row understands and that isn't its default, and keeps all its digits in text
/// files.
template<typename T>
std::string otherText(const Setting<T>& row)
{
    const T defaults;
    const std::vector<std::string> tried = {"true",
                                            "false",
                                            row.words.empty() ? "" : row.words.back().text,
                                            "2",
                                            "0.5",
                                            "0.25",
                                            "0.125",
                                            "0.0025",
                                            "50001",
                                            "110",
                                            "0 0 0.6",
                                            "2:0.5",
                                            "surface",
                                            "a=1",
                                            "1 0 0 0  0 0 1 0  0 -1 0 0  0.5 0.25 3 1"};
    for (const std::string& text : tried)
    {
        T object;
        std::string what;
        if (row.assign(object, text) && !row.repair(object, what) &&
            !isSame<T>(row.member, object, defaults))
            return text;
    }
    ADD_FAILURE() << "no value for " << row.name << " but its default";
    return {};
}

template<typename T>
void expectWhole(const SettingTable<T>& table)
{
    std::set<std::string> names;
    for (const Setting<T>& row : table.rows())
    {
        EXPECT_TRUE(names.insert(row.name).second) << row.name << " is there twice";
        EXPECT_TRUE(names.insert(row.storedName()).second) << row.storedName();
        EXPECT_FALSE(row.help.empty()) << row.name;
        T defaults;
        std::string what;
        EXPECT_FALSE(row.repair(defaults, what)) << "the default is in range: " << what;
    }
}

/// Whether \a table tells a difference in each row, and only there.
template<typename T>
void expectCompared(const SettingTable<T>& table)
{
    const T defaults;
    EXPECT_TRUE(T() == defaults);
    for (const Setting<T>& row : table.rows())
    {
        T other;
        std::string error;
        ASSERT_TRUE(table.set(other, row.name, otherText(row), error)) << error;
        EXPECT_FALSE(other == defaults) << row.name;
        T same;
        ASSERT_TRUE(table.set(same, row.name, otherText(row), error)) << error;
        EXPECT_TRUE(other == same) << row.name;
    }
}

osg::ref_ptr<osg::Node> throughFile(const osg::Node& node, const std::string& type)
{
    findPlugins();
    osgDB::ReaderWriter* format = osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
    std::stringstream stream(std::ios::in | std::ios::out | std::ios::binary);
    const osg::ref_ptr<osgDB::Options> options = new osgDB::Options("fileType=" + type);
    EXPECT_TRUE(format->writeNode(node, stream, options).success());
    return format->readNode(stream, options).takeNode();
}

/// Each row of \a table on its own: kept by a copy of \a N and by files.
template<class N, typename T, typename Get, typename Set>
void expectKept(const SettingTable<T>& table, Get get, Set set)
{
    for (const Setting<T>& row : table.rows())
    {
        T wanted;
        ASSERT_TRUE(row.assign(wanted, otherText(row)));
        const osg::ref_ptr<N> node = new N;
        (node.get()->*set)(wanted);
        const osg::ref_ptr<N> copy = osg::clone(node.get());
        EXPECT_TRUE((copy.get()->*get)() == wanted) << row.name;
        for (const char* type : {"Ascii", "XML", "Binary"})
        {
            const osg::ref_ptr<osg::Node> read = throughFile(*node, type);
            const auto* back = dynamic_cast<const N*>(read.get());
            ASSERT_NE(back, nullptr) << row.name;
            for (const Setting<T>& other : table.rows())
                EXPECT_TRUE(isSame<T>(other.member, (back->*get)(), wanted))
                    << row.name << " in " << type << " changes " << other.name;
        }
    }
}

} // namespace

TEST(SettingTable, HasARowForEachMember)
{
    constexpr int kWithoutRow = 4; // wishes, isSilenced, whySilenced, arrayDescription
    using namespace midair::haptics;
    // A base counts as a member.
    const int object = countMembers<midair::bridge::ObjectSettings>(0);
    EXPECT_EQ(object, static_cast<int>(midair::bridge::objectTable().rows().size()));
    // Of an object's whySilenced has no row.
    EXPECT_EQ(object + countMembers<HapticProperty>(0) - 1,
              static_cast<int>(surfaceProperties().rows().size()) + 1);
    const int solver = countMembers<SolverSettings>(0);
    const int field = countMembers<SequenceSettings>(0) + countMembers<PlayingSettings>(0) +
                      solver + countMembers<FieldSettings>(0) - 3;
    EXPECT_EQ(solver, static_cast<int>(solverSettings().rows().size()));
    EXPECT_EQ(field, static_cast<int>(fieldSettings().rows().size()));
    const int scene = field + countMembers<midair::bridge::SceneSettings>(0) - 1;
    EXPECT_EQ(scene, static_cast<int>(midair::bridge::sceneTable().rows().size()));
    EXPECT_EQ(scene + countMembers<HapticSettings>(0) - 1,
              static_cast<int>(sceneSettings().rows().size()) + kWithoutRow);
}

TEST(SettingTable, IsWhole)
{
    expectWhole(sceneSettings());
    expectWhole(surfaceProperties());
}

// The texts of earPoints, dead and weak name nothing: they are places and numbers.
TEST(SettingTable, WhatAFileNamesIsAWishButForTheSolver)
{
    for (const Setting<HapticSettings>& row : sceneSettings().rows())
        EXPECT_EQ(row.isWish,
                  std::holds_alternative<std::string HapticSettings::*>(row.member) &&
                      row.name != "solver" && row.name != "earPoints" && row.name != "dead" &&
                      row.name != "weak")
            << row.name;
}

TEST(SettingTable, ComparesEachRow)
{
    expectCompared(sceneSettings());
    expectCompared(surfaceProperties());
}

TEST(SettingTable, CopiesAndFilesKeepEachRow)
{
    expectKept<HapticScene>(sceneSettings(), &HapticScene::getSettings, &HapticScene::setSettings);
    expectKept<HapticSurface>(
        surfaceProperties(), &HapticSurface::getProperty, &HapticSurface::setProperty);
}

TEST(SettingTable, MakesTheVariables)
{
    const auto& usage = osg::ApplicationUsage::instance()->getEnvironmentalVariables();
    for (const Setting<HapticSettings>& row : sceneSettings().rows())
    {
        if (row.variable.empty()) continue;
        const std::string name = "OSG_MIDAIR_" + row.variable;
        const auto entry = usage.find(name + " <" + row.name + ">");
        ASSERT_NE(entry, usage.end()) << name;
        EXPECT_NE(entry->second.find(row.summary()), std::string::npos) << entry->second;
        const std::string text = otherText(row);
        const char* before = std::getenv(name.c_str());
        const std::string kept = before ? before : "";
        setenv(name.c_str(), text.c_str(), 1);
        HapticSettings wanted;
        std::string error;
        ASSERT_TRUE(wanted.set(row.name, text, error)) << error;
        std::vector<std::string> errors;
        const HapticSettings got =
            Environment::restrict(Environment::replace(HapticSettings(), errors));
        EXPECT_TRUE(isSame<HapticSettings>(row.member, got, wanted)) << name;
        EXPECT_TRUE(errors.empty()) << errors.front();
        before ? setenv(name.c_str(), kept.c_str(), 1) : unsetenv(name.c_str());
    }
}

// Scenes that are shown beside each other are one where none of the settings differs whose row says
// that another array or device is opened, or that all is elsewhere.
TEST(SettingTable, RowsSayWhichScenesCanBeOne)
{
    std::set<std::string> apart;
    const osg::ref_ptr<HapticScene> host = new HapticScene;
    const auto suits = [&host](const HapticSettings& settings)
    {
        const osg::ref_ptr<HapticScene> guest = new HapticScene;
        guest->setSettings(settings);
        return SceneAccess::engine(*host).suits(SceneAccess::engine(*guest));
    };
    for (const Setting<HapticSettings>& row : sceneSettings().rows())
    {
        HapticSettings other;
        ASSERT_TRUE(row.assign(other, otherText(row)));
        if (!suits(other)) apart.insert(row.name);
    }
    EXPECT_EQ(
        apart,
        (std::set<std::string>{"array", "calibration", "dead", "device", "metresPerUnit", "weak"}));
    HapticSettings described;
    described.arrayDescription = std::make_shared<const ArrayDescription>();
    EXPECT_FALSE(suits(described));
}

// What a file may only wish is opened by its grant, which another file may not have.
TEST(SettingTable, ScenesCanBeOneWhereTheyWishForTheSameBesideTheSameFile)
{
    const auto suits = [](const HapticSettings& a, const HapticSettings& b)
    {
        const osg::ref_ptr<HapticScene> host = new HapticScene;
        const osg::ref_ptr<HapticScene> guest = new HapticScene;
        host->setSettings(a);
        guest->setSettings(b);
        return SceneAccess::engine(*host).suits(SceneAccess::engine(*guest));
    };
    HapticSettings own;
    HapticSettings wish;
    wish.wishes.asked["device"] = wish.device;
    wish.wishes.folder = "here";
    HapticSettings elsewhere = wish;
    elsewhere.wishes.folder = "there";
    HapticSettings hands;
    hands.wishes.asked["hands"] = "mouse:";
    hands.wishes.folder = "there";
    EXPECT_TRUE(suits(own, own));
    EXPECT_TRUE(suits(wish, wish));
    EXPECT_FALSE(suits(own, wish));
    EXPECT_FALSE(suits(wish, own));
    EXPECT_FALSE(suits(wish, elsewhere));
    EXPECT_TRUE(suits(own, hands)) << "the host's hands count";
}

// A text that only its row can judge is judged wherever it comes from.
TEST(SettingTable, RowsJudgeTexts)
{
    for (const auto& [name, value, why] :
         {std::tuple{"earPoints", "0 0", "earPoints is \"0 0\", should be "},
          std::tuple{"dead", "7, 7", "dead has 7 twice"},
          std::tuple{"weak", "3:0", "weak has \"3:0\", should be "}})
    {
        const Setting<HapticSettings>& row = *sceneSettings().find(name);
        HapticSettings settings;
        std::string error;
        ASSERT_TRUE(settings.set(name, value, error)) << error;
        EXPECT_FALSE(row.holds(settings)) << name;
        const std::string problem = HapticSettings::problemOf(name, value);
        EXPECT_EQ((row.name + " " + problem).find(why), 0u) << problem;
        const std::vector<std::string> said = settings.repair();
        ASSERT_EQ(said.size(), 1u) << name;
        EXPECT_EQ(said.front(), row.name + " " + problem + "; nothing is played");
        EXPECT_TRUE(settings.isSilenced);
        EXPECT_TRUE(isSame<HapticSettings>(row.member, settings, HapticSettings())) << name;
    }
}

TEST(OverlayKinds, CopiesAndFilesKeepEachNumber)
{
    int numbers = 0;
    for (const auto& [place, kind] : overlayKinds())
        for (const OverlayNumber& number : kind.numbers)
        {
            ++numbers;
            const double initial = number.get(*kind.make());
            EXPECT_TRUE(number.range.holds(initial)) << number.name;
            const double wanted = number.range.holds(0.125) ? 0.125 : number.range.high;
            const osg::ref_ptr<HapticOverlays> node = new HapticOverlays;
            EXPECT_TRUE(node->setNumber(number.storedName(), wanted)) << number.name;
            EXPECT_FALSE(node->setNumber(number.name, -1.0));
            EXPECT_FALSE(node->setNumber(number.name, std::nan("")));
            node->getOverlay("hands")->setShown(false);
            const osg::ref_ptr<HapticOverlays> copy = osg::clone(node.get());
            EXPECT_EQ(number.get(*copy->getOverlay(kind.name)), wanted) << number.name;
            for (const char* type : {"Ascii", "XML", "Binary"})
            {
                const osg::ref_ptr<osg::Node> read = throughFile(*node, type);
                auto* back = dynamic_cast<HapticOverlays*>(read.get());
                ASSERT_NE(back, nullptr) << type;
                EXPECT_EQ(number.get(*back->getOverlay(kind.name)), wanted)
                    << number.name << " in " << type;
                EXPECT_FALSE(back->isShown("hands"));
                EXPECT_TRUE(back->isShown("volume"));
                for (const auto& [others, other] : overlayKinds())
                    for (const OverlayNumber& same : other.numbers)
                        EXPECT_TRUE(same.name == number.name ||
                                    same.get(*back->getOverlay(other.name)) ==
                                        same.get(*other.make()))
                            << same.name;
            }
        }
    EXPECT_GE(numbers, 10);
}

TEST(OverlayKinds, NumbersOutOfRangeInAFileAreToldAndTheDefaultStays)
{
    const Notices notices;
    const osg::ref_ptr<osg::Node> read = [&]
    {
        const osg::ref_ptr<HapticOverlays> node = new HapticOverlays;
        node->get<ArrayGhost>()->setOpacity(7.0F); // the overlay's own setter doesn't check
        return throughFile(*node, "Binary");
    }();
    const auto* back = dynamic_cast<HapticOverlays*>(read.get());
    ASSERT_NE(back, nullptr);
    EXPECT_NE(notices.text().find("arrayOpacity is 7, should be 0 .. 1"), std::string::npos)
        << notices.text();
}

TEST(OverlayKinds, AreRefusedWhereTheyClash)
{
    const std::size_t before = overlayKinds().size();
    OverlayKind kind = overlayKinds().begin()->second;
    const Notices notices;
    const OverlayRegistration again(kind);
    kind = {8, "Fog", "fog", "the fog", "fog", 0xFFC5, 70, kind.make}; // F8
    const OverlayRegistration mute(kind);
    EXPECT_EQ(overlayKinds().size(), before);
    for (const char* said : {"ControlPoints", "F8 is reserved"})
        EXPECT_NE(notices.text().find(said), std::string::npos) << notices.text();
}
