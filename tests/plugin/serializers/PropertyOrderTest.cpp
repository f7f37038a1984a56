// Properties in text files in any order are read alike.
#include "plugin/settings/AllSettings.h"
#include "tests/plugin/serializers/PropertyText.h"

#include <osgMidair/HapticOverlays>

#include <algorithm>
#include <random>

using namespace property_text;

namespace
{

/// A value of \a row that isn't its default.
template<typename T>
Written unusual(const Setting<T>& row)
{
    const T defaults;
    for (const char* text : {"false",
                             "true",
                             "3",
                             "0.25",
                             "0.1",
                             "0.002",
                             "110",
                             "60000",
                             "\"board\"",
                             "\"3\"",
                             "\"3:0.5\"",
                             "\"0 0 0.3\"",
                             "\"surface\"",
                             "\"a=1\""})
    {
        T object;
        std::string what;
        std::string bare = text;
        bare.erase(std::remove(bare.begin(), bare.end(), '"'), bare.end());
        const bool isText = std::holds_alternative<std::string T::*>(row.member);
        if (isText == (text[0] == '"') && row.words.empty() && row.assign(object, bare) &&
            !row.repair(object, what) && !isSame<T>(row.member, object, defaults))
            return scalar(row.storedName(), text);
    }
    if (!row.words.empty()) return scalar(row.storedName(), row.words.back().stored);
    return {row.storedName(),
            "{ 1 0 0 0 0 1 0 0 0 0 1 0 0.5 0.25 0 1 }",
            "text=\"1 0 0 0 &nl;0 1 0 0 &nl;0 0 1 0 &nl;0.5 0.25 0 1\" />"};
}

template<typename T>
List allOf(const SettingTable<T>& table)
{
    List all = {scalar("Name", "\"a } b\""), scalar("NodeMask", "0xff")};
    for (const Setting<T>& row : table.rows())
        all.push_back(unusual(row));
    return all;
}

List sceneList()
{
    List all = allOf(sceneSettings());
    all.push_back({"Children",
                   "1 { osg::Group { UniqueID 2 Name \"child\" } }",
                   "attribute=\"1\"><osg--Group><UniqueID attribute=\"2\" /><Name "
                   "attribute=\"&quot;child&quot;\" /></osg--Group></Children>"});
    return all;
}

List pointsList()
{
    List all = allOf(surfaceProperties());
    all.push_back({"Points",
                   "2 { 0 0 0.01 0 0.02 0.01 }",
                   "attribute=\"2\" text=\"0 0 0.01 &nl;0 0.02 0.01\" />"});
    all.push_back({"Pressures", "2 { 800 400 }", "attribute=\"2\" text=\"800 &nl;400\" />"});
    return all;
}

/// All of a node that the lists set.
template<class N>
std::string picture(const N& node)
{
    std::ostringstream out;
    const osg::Node& all = node;
    const osg::Group* group = all.asGroup();
    out << node.getName() << ' ' << std::hex << node.getNodeMask() << std::dec << ' '
        << (group ? group->getNumChildren() : 0);
    if (const auto* points = dynamic_cast<const HapticPoints*>(&all))
        out << ' ' << points->getPoints().size() << ' ' << points->getPressures().size();
    return out.str();
}

/// Whether \a list, in the order that it has, gives \a wanted.
template<class N>
void expectSame(const List& list, const N& wanted, bool isXml)
{
    Notices notices;
    const osg::ref_ptr<N> node = through<N>(list, isXml);
    ASSERT_NE(node, nullptr);
    EXPECT_TRUE(stateOf(*node) == stateOf(wanted)) << fileOf(nameOf<N>(), list, isXml);
    EXPECT_EQ(picture(*node), picture(wanted)) << fileOf(nameOf<N>(), list, isXml);
    EXPECT_EQ(notices.text(), "");
}

/// Random orders of all, and each pair in both.
template<class N>
void expectAnyOrder(const List& all, bool isXml)
{
    const osg::ref_ptr<N> whole = through<N>(all, isXml);
    ASSERT_NE(whole, nullptr);
    EXPECT_FALSE(stateOf(*whole) == stateOf(*osg::ref_ptr<N>(new N)));
    std::mt19937 random(7);
    List mixed = all;
    for (int i = 0; i < 60 && !testing::Test::HasFailure(); ++i)
    {
        std::shuffle(mixed.begin(), mixed.end(), random);
        expectSame(mixed, *whole, isXml);
    }
    expectSame({all.rbegin(), all.rend()}, *whole, isXml);
    for (std::size_t a = 0; a < all.size() && !testing::Test::HasFailure(); ++a)
        for (std::size_t b = 0; b < a; ++b)
        {
            const osg::ref_ptr<N> one = through<N>({all[a], all[b]}, isXml);
            ASSERT_NE(one, nullptr);
            expectSame({all[b], all[a]}, *one, isXml);
        }
}

} // namespace

TEST(PropertyOrder, OfScenesIsAny)
{
    expectAnyOrder<HapticScene>(sceneList(), false);
    expectAnyOrder<HapticScene>(sceneList(), true);
}

TEST(PropertyOrder, OfSurfacesIsAny)
{
    List all = allOf(surfaceProperties());
    all.push_back(sceneList().back());
    expectAnyOrder<HapticSurface>(all, false);
    expectAnyOrder<HapticSurface>(all, true);
}

TEST(PropertyOrder, OfPointsIsAny)
{
    expectAnyOrder<HapticPoints>(pointsList(), false);
    expectAnyOrder<HapticPoints>(pointsList(), true);
}

TEST(PropertyOrder, OfOverlaysIsAny)
{
    List all = {scalar("Name", "\"o\""),
                scalar("ShowHands", "FALSE"),
                scalar("ShowControlPoints", "no"),
                scalar("SliceRadius", "50 mm"),
                scalar("PointRadius", "0.003"),
                scalar("ShowFieldVolume", "0")};
    std::mt19937 random(7);
    for (const bool isXml : {false, true})
        for (int i = 0; i < 60 && !testing::Test::HasFailure(); ++i)
        {
            Notices notices;
            std::shuffle(all.begin(), all.end(), random);
            const auto overlays = through<HapticOverlays>(all, isXml);
            ASSERT_NE(overlays, nullptr);
            EXPECT_EQ(overlays->getName(), "o");
            EXPECT_FALSE(overlays->getOverlay("Hands")->isShown());
            EXPECT_FALSE(overlays->getOverlay("ControlPoints")->isShown());
            EXPECT_FALSE(overlays->getOverlay("FieldVolume")->isShown());
            EXPECT_TRUE(overlays->getOverlay("FieldSlice")->isShown());
            EXPECT_EQ(notices.text(), "");
        }
}
