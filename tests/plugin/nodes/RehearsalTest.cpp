#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticPoints>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace osgMidair;

TEST(Rehearsal, OpensNothingReal)
{
    const std::string file = testing::TempDir() + "midair-rehearsal.bin";
    std::filesystem::remove(file);
    BoxScene box;
    box.scene->setDevice("record:" + file);
    box.scene->setHands("openxr:");
    box.scene->setRehearsed(true);
    EXPECT_TRUE(box.scene->getRehearsed());
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_EQ(box.scene->getStatistics().device.find("sim:"), 0u)
        << box.scene->getStatistics().device;
    EXPECT_EQ(box.scene->getGrantedSettings().device, "record:" + file);
    EXPECT_EQ(box.scene->getGrantedSettings().hands, "openxr:");
    EXPECT_EQ(box.scene->getSettings().device, "record:" + file);
    EXPECT_FALSE(std::filesystem::exists(file));
    EXPECT_TRUE(box.scene->getStatistics().told.empty());
}

// Nobody tries to open them, so nobody else would tell.
TEST(Rehearsal, TellsNamesThatAreNone)
{
    BoxScene box;
    box.scene->setDevice("smi:");
    box.scene->setHands("recroded:hand.csv");
    box.scene->setRehearsed(true);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_TRUE(says(*box.scene, "device \"smi:\": unknown kind \"smi:\""));
    EXPECT_TRUE(says(*box.scene, "hand source \"recroded:hand.csv\" is not known"));
    EXPECT_EQ(box.scene->getStatistics().told.size(), 2U);
}

TEST(Rehearsal, FindsObjectsThatAreNotFeltToo)
{
    BoxScene box;
    const osg::ref_ptr<HapticSurface> empty = new HapticSurface;
    empty->setName("empty");
    const osg::ref_ptr<HapticSurface> off = new HapticSurface(BoxScene::box().get());
    off->setName("off");
    off->setEnabled(false);
    off->setSpacing(-1.0); // the default is used
    box.scene->addChild(empty);
    box.scene->addChild(off);
    HeadlessViewer viewer(box.scene);
    viewer.frames(2);
    std::vector<FoundObject> found = box.scene->getFoundObjects();
    std::sort(found.begin(),
              found.end(),
              [](const FoundObject& a, const FoundObject& b) { return a.path < b.path; });
    ASSERT_EQ(found.size(), 3u);
    EXPECT_EQ(found[0].path, "HapticScene/HapticSurface 'empty'");
    EXPECT_FALSE(found[0].hasShape);
    EXPECT_EQ(found[1].path, "HapticScene/HapticSurface 'off'");
    EXPECT_FALSE(found[1].hasShape);
    EXPECT_EQ(found[1].property.spacing, 0.0);
    EXPECT_TRUE(found[2].hasShape);
    EXPECT_EQ(found[2].node.get(), box.surface.get());
}

TEST(Rehearsal, TheFieldCountsWhatIsLeftOutOfEachObject)
{
    BoxScene box;
    const osg::ref_ptr<HapticPoints> points = new HapticPoints;
    points->setName("points");
    points->setPoints({{0.0, 0.0, 0.3}, {0.0, 0.0, -0.1}, {0.0, 0.0, -0.2}}); // two behind it
    const osg::ref_ptr<HapticSurface> far = new HapticSurface(BoxScene::box().get());
    const osg::ref_ptr<osg::MatrixTransform> away =
        new osg::MatrixTransform(osg::Matrixd::translate(50.0, 0.0, 0.0));
    away->addChild(far);
    box.scene->addChild(points);
    box.scene->addChild(away);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const osg::ref_ptr<const HapticField> field = box.scene->getField();
    ASSERT_EQ(field->getObjects().size(), 3u);
    for (const HapticField::Object& object : field->getObjects())
    {
        EXPECT_EQ(object.isUnreachable, object.node.get() == far.get()) << object.path;
        EXPECT_EQ(object.outOfWorkspace, object.node.get() == points.get() ? 2u : 0u)
            << object.path;
        EXPECT_EQ(object.outOfReach, 0u);
    }
    EXPECT_GE(field->getReach(), 0.3);
}
