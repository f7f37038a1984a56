// What is told of an object that nothing is felt of: the cause, once while it lasts.
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticPoints>

#include <osg/Camera>
#include <osg/PagedLOD>
#include <osg/Switch>
#include <osgText/Text>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A surface named "mug" with one child, and a box that moves in each frame.
struct Told
{
    explicit Told(osg::Node* child, const osg::Vec3& place = osg::Vec3(0.0F, 0.0F, 0.15F)) :
        box(place)
    {
        mug->setName("mug");
        if (child) mug->addChild(child);
        box.scene->addChild(mug);
    }

    /// Messages about the mug after some frames, in which another object moves: "CODE: TEXT".
    std::vector<std::string> messages()
    {
        for (int i = 0; i < 10; ++i)
        {
            box.move(1e-3 * i);
            viewer.frame();
        }
        std::vector<std::string> all;
        const std::string path = "HapticScene/HapticSurface 'mug'";
        for (const HapticMessage& message : box.scene->getStatistics().told)
            if (message.path == path)
                all.push_back(message.code + message.text.substr(path.size()) +
                              (message.count > 1 ? " (again)" : ""));
        return all;
    }

    BoxScene box;
    osg::ref_ptr<HapticSurface> mug = new HapticSurface;
    HeadlessViewer viewer{box.scene};
};

std::vector<std::string> toldOf(osg::Node* child)
{
    return Told(child).messages();
}

osg::ref_ptr<osgText::Text> text()
{
    osg::ref_ptr<osgText::Text> words = new osgText::Text;
    words->setName("words");
    words->setText("Hi");
    return words;
}

using Texts = std::vector<std::string>;
const std::string kNothing = "object.invalid: is not played: each node below it ";

} // namespace

TEST(WhyUnfelt, NamesEachCauseAsWhatItIs)
{
    EXPECT_EQ(toldOf(nullptr),
              Texts{"object.invalid: has no drawables below it; it can't be felt"});
    EXPECT_EQ(toldOf(new osg::Geometry),
              Texts{"object.invalid: has no triangles; it can't be felt"});
    EXPECT_EQ(
        toldOf(text()),
        Texts{"object.geometry: Text 'words' is text of which 2 characters have no outline in "
              "their font (a TrueType font has them); they can't be felt"})
        << "once";
    const osg::ref_ptr<osg::Camera> camera = new osg::Camera;
    camera->setName("hud");
    camera->addChild(BoxScene::box());
    EXPECT_EQ(toldOf(camera),
              Texts{kNothing + "hangs on a camera, not in the world (Camera 'hud'); it can't be "
                               "felt"});
    const osg::ref_ptr<osg::PagedLOD> paged = new osg::PagedLOD;
    paged->setName("tile");
    paged->setFileName(0, "cup.obj");
    EXPECT_EQ(toldOf(paged),
              Texts{kNothing + "is not loaded (PagedLOD 'tile': \"cup.obj\"); it can't be felt"});
    const osg::ref_ptr<osg::Group> group = new osg::Group;
    for (const char* name : {"handle", "rim"})
    {
        const osg::ref_ptr<HapticSurface> inner = new HapticSurface(BoxScene::box());
        inner->setName(name);
        group->addChild(inner);
    }
    EXPECT_EQ(toldOf(group),
              Texts{kNothing +
                    "has its own haptic tags (HapticSurface 'handle' and 1 more); it can't be "
                    "felt"});
}

TEST(WhyUnfelt, NamesWhatHidesItAndThatItIsFeltWhenShown)
{
    const osg::ref_ptr<osg::Switch> doors = new osg::Switch;
    doors->setName("doors");
    doors->addChild(BoxScene::box(), false);
    doors->addChild(text(), false);
    Told told(doors);
    const Texts wanted = {"object.hidden: is not played: each node below it is hidden "
                          "(Switch 'doors'); it is felt once it is shown"};
    EXPECT_EQ(told.messages(), wanted);
    doors->setValue(0, true);
    ASSERT_TRUE(
        told.viewer.framesUntil([&] { return told.box.scene->getStatistics().objects == 2; }));
    EXPECT_EQ(told.messages(), wanted);
    doors->setValue(0, false);
    told.messages();
    EXPECT_EQ(told.box.scene->getStatistics().told.front().count, 2U) << "hidden a second time";

    const osg::ref_ptr<osg::Node> box = BoxScene::box();
    box->setName("lid");
    box->setNodeMask(0);
    EXPECT_EQ(toldOf(box),
              Texts{"object.hidden: is not played: each node below it is hidden "
                    "(ShapeDrawable 'lid'); it is felt once it is shown"});
}

TEST(WhyUnfelt, AnObstacleSaysItOnceToo)
{
    BoxScene box;
    box.scene->setShadows(true);
    const osg::ref_ptr<osg::Switch> arm = new osg::Switch;
    arm->setName("arm");
    arm->setUserValue("obstacle", true);
    arm->addChild(BoxScene::box(), false);
    box.scene->addChild(arm);
    HeadlessViewer viewer(box.scene);
    viewer.frames(10);
    const std::vector<HapticMessage> told = box.scene->getStatistics().told;
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0].code, "obstacle.invalid");
    EXPECT_EQ(told[0].count, 1U);
    EXPECT_EQ(told[0].text,
              "HapticScene/Switch 'arm': is not played: each node below it is hidden (Switch "
              "'arm'); it is no obstacle");
}

TEST(WhyUnfelt, PointsSayItOnce)
{
    BoxScene box;
    const osg::ref_ptr<HapticPoints> points = new HapticPoints;
    box.scene->addChild(points);
    HeadlessViewer viewer(box.scene);
    for (int i = 0; i < 10; ++i)
    {
        box.move(1e-3 * i);
        viewer.frame();
    }
    const std::vector<HapticMessage> told = box.scene->getStatistics().told;
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0].text, "HapticScene/HapticPoints: has no points; it can't be felt");
    EXPECT_EQ(told[0].count, 1U);
}
