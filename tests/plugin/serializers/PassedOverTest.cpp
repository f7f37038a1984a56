// What OSG's own text reader leaves out of its nodes around and below the kit's: each time it is
// told with its line, and a lost mask or mark silences the scene.
#include "tests/plugin/serializers/PropertyText.h"

using namespace property_text;

namespace
{

/// A scene with a stock group named "shape" that has \a properties, and a known property behind.
std::string sceneWith(const std::string& properties, const std::string& className = "osg::Group")
{
    return "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n\n"
           "osgMidair::HapticScene { UniqueID 1\n"
           "Name \"kept\"\n"
           "Children 2 {\n" +
           className + " { UniqueID 2\n" + properties +
           "}\n"
           "osg::Node { UniqueID 3 Name \"behind\" } }\n"
           "Cycle 4 }\n";
}

const std::string kTag =
    "UserDataContainer TRUE { osg::DefaultUserDataContainer { UniqueID 9\nUDC_UserObjects 1 {\n"
    "osg::StringValueObject { UniqueID 10\nName \"haptic\"\nValue \"sampling=edges; text } {\"\n"
    "} } } }\n";

osg::ref_ptr<HapticScene> read(const std::string& text)
{
    const osg::ref_ptr<osg::Node> node = parsed(text, false);
    osg::ref_ptr<HapticScene> scene = dynamic_cast<HapticScene*>(node.get());
    EXPECT_TRUE(scene) << text;
    if (!scene) return nullptr;
    EXPECT_EQ(scene->getCycle(), 4) << "what follows is read";
    EXPECT_GE(scene->getNumChildren(), 1u);
    if (scene->getNumChildren() == 0) return nullptr;
    EXPECT_EQ(scene->getChild(scene->getNumChildren() - 1)->getName(), "behind");
    return scene;
}

} // namespace

TEST(PassedOver, AStockNodeInOsgsOrderSaysNothing)
{
    Notices notices;
    const auto scene =
        read(sceneWith("Name \"shape\"\n" + kTag + "NodeMask 0xff\nChildren 0 {\n}\n"));
    ASSERT_TRUE(scene);
    EXPECT_EQ(notices.text(), "");
    EXPECT_FALSE(scene->getSettings().isSilenced);
    std::string tag;
    EXPECT_TRUE(scene->getChild(0)->getUserValue("haptic", tag));
    EXPECT_EQ(tag, "sampling=edges; text } {");
}

TEST(PassedOver, AMarkBehindAMaskIsToldAndSilencesTheScene)
{
    Notices notices;
    const auto scene = read(sceneWith("Name \"shape\"\nNodeMask 0xff\n" + kTag));
    ASSERT_TRUE(scene);
    EXPECT_NE(notices.text().find("line 11: OSG skips \"UserDataContainer\""), std::string::npos)
        << notices.text();
    EXPECT_TRUE(scene->getSettings().isSilenced) << "the floor might be felt in its place";
    EXPECT_NE(notices.text().find("; nothing is played until that is right"), std::string::npos);
}

TEST(PassedOver, AMaskBehindTheChildrenIsToldAndSilencesTheScene)
{
    Notices notices;
    const auto scene = read(sceneWith("Children 0 {\n}\nNodeMask 0x0\n"));
    ASSERT_TRUE(scene);
    EXPECT_NE(notices.text().find("line 11: OSG skips \"NodeMask\""), std::string::npos)
        << notices.text();
    EXPECT_TRUE(scene->getSettings().isSilenced) << "it was to be hidden";
}

TEST(PassedOver, AnythingElseIsToldAlone)
{
    Notices notices;
    const auto scene = read(sceneWith("Children 0 {\n}\nName \"late } name\"\n"));
    ASSERT_TRUE(scene);
    EXPECT_NE(notices.text().find("line 11: OSG skips \"Name\""), std::string::npos)
        << notices.text();
    EXPECT_FALSE(scene->getSettings().isSilenced);
}

TEST(PassedOver, AnUnknownClassIsToldWithTheNearest)
{
    Notices notices;
    const auto scene = read(sceneWith("Name \"ball\"\nPressure 500\n", "osgMidair::HapticSurfce"));
    ASSERT_TRUE(scene);
    EXPECT_NE(notices.text().find("line 9: unknown class \"osgMidair::HapticSurfce\" (did you mean "
                                  "osgMidair::HapticSurface?)"),
              std::string::npos)
        << notices.text();
    EXPECT_EQ(notices.text().find("OSG skips"), std::string::npos) << "one cause, told once";
}

TEST(PassedOver, AMarkInAnUnknownClassSilencesTheScene)
{
    Notices notices;
    const auto scene = read(sceneWith("Name \"ball\"\n" + kTag, "osgMine::Ball"));
    ASSERT_TRUE(scene);
    EXPECT_TRUE(scene->getSettings().isSilenced);
}
