#include "plugin/scene/CollectHapticSurfacesVisitor.h"
#include "tests/plugin/KitTest.h"

#include <osg/Camera>
#include <osg/LOD>
#include <osg/PositionAttitudeTransform>
#include <osg/Switch>

#include <set>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

struct Collect : testing::Test
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    osg::ref_ptr<HapticSurface> surface = new HapticSurface(BoxScene::box().get());
    CollectHapticSurfacesVisitor visitor;

    const std::vector<HapticInstance>& instances()
    {
        markTags(*scene);
        visitor.collect({{scene.get(), osg::Matrixd()}});
        return visitor.instances();
    }
};

osg::ref_ptr<osg::MatrixTransform> at(double x, osg::Node* child)
{
    osg::ref_ptr<osg::MatrixTransform> transform =
        new osg::MatrixTransform(osg::Matrixd::translate(x, 0.0, 0.0));
    transform->addChild(child);
    return transform;
}

} // namespace

TEST_F(Collect, FindsWhereItIs)
{
    scene->addChild(at(1.0, at(2.0, surface)));
    ASSERT_EQ(instances().size(), 1u);
    EXPECT_EQ(instances()[0].node, surface);
    EXPECT_EQ(instances()[0].world.getTrans(), osg::Vec3d(3.0, 0.0, 0.0));
}

TEST_F(Collect, EveryInstanceOfASharedNode)
{
    scene->addChild(at(1.0, surface));
    scene->addChild(at(2.0, surface));
    osg::ref_ptr<osg::MatrixTransform> shared = at(0.5, surface);
    scene->addChild(at(10.0, shared));
    scene->addChild(at(20.0, shared));
    std::set<double> places;
    std::set<std::uint64_t> ids;
    for (const HapticInstance& instance : instances())
    {
        places.insert(instance.world.getTrans().x());
        ids.insert(instance.id);
    }
    EXPECT_EQ(places, (std::set<double>{1.0, 2.0, 10.5, 20.5}));
    EXPECT_EQ(ids.size(), 4u);
    const std::uint64_t first = instances()[0].id;
    EXPECT_EQ(instances()[0].id, first) << "the same from frame to frame";
}

TEST_F(Collect, SwitchedOffIsNotFelt)
{
    osg::ref_ptr<osg::Switch> theSwitch = new osg::Switch;
    theSwitch->addChild(surface, true);
    scene->addChild(theSwitch);
    EXPECT_EQ(instances().size(), 1u);
    theSwitch->setAllChildrenOff();
    EXPECT_EQ(instances().size(), 0u);
}

TEST_F(Collect, MaskedIsNotFelt)
{
    osg::ref_ptr<osg::Group> group = new osg::Group;
    group->addChild(surface);
    scene->addChild(group);
    group->setNodeMask(0);
    EXPECT_EQ(instances().size(), 0u);
    group->setNodeMask(2);
    EXPECT_EQ(instances().size(), 1u);
    visitor.setTraversalMask(1);
    EXPECT_EQ(instances().size(), 0u) << "the visitor's own mask";
}

TEST_F(Collect, LodIsFeltAtItsFinestWhereverTheCameraIs)
{
    osg::ref_ptr<HapticSurface> coarse = new HapticSurface;
    osg::ref_ptr<osg::LOD> lod = new osg::LOD;
    lod->addChild(coarse, 10.0f, 1e6f);
    lod->addChild(surface, 0.0f, 10.0f);
    scene->addChild(lod);
    ASSERT_EQ(instances().size(), 1u);
    EXPECT_EQ(instances()[0].node, surface);
}

TEST_F(Collect, WhatHangsOnACameraHasNoPlaceInTheWorld)
{
    osg::ref_ptr<osg::Camera> hud = new osg::Camera;
    hud->addChild(surface);
    scene->addChild(hud);
    osg::ref_ptr<osg::MatrixTransform> absolute = at(1.0, surface);
    absolute->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
    scene->addChild(absolute);
    ASSERT_EQ(instances().size(), 2u);
    EXPECT_FALSE(instances()[0].inWorld);
    EXPECT_FALSE(instances()[1].inWorld);
}

TEST_F(Collect, NestedSurfacesAreTwoObjects)
{
    osg::ref_ptr<HapticSurface> outer = new HapticSurface;
    outer->addChild(surface);
    scene->addChild(outer);
    EXPECT_EQ(instances().size(), 2u);
}

TEST_F(Collect, WhatIsInASceneInsideTheSceneIsTheOuterOnes)
{
    osg::ref_ptr<HapticScene> inner = new HapticScene;
    inner->addChild(surface);
    scene->addChild(inner);
    EXPECT_EQ(instances().size(), 1u);
    inner->setEnabled(false);
    EXPECT_EQ(instances().size(), 0u);
}

TEST_F(Collect, TagsOnOrdinaryNodes)
{
    osg::ref_ptr<osg::Group> text = new osg::Group;
    text->setUserValue("haptic", std::string("pressure=2"));
    osg::ref_ptr<osg::PositionAttitudeTransform> flag = new osg::PositionAttitudeTransform;
    flag->setUserValue("haptic", true);
    flag->setPosition(osg::Vec3d(3.0, 0.0, 0.0));
    osg::ref_ptr<osg::Group> description = new osg::Group;
    description->addDescription("haptic: sampling=edges");
    osg::ref_ptr<osg::Group> other = new osg::Group;
    other->addDescription("haptics are nice");
    other->setUserValue("colour", 3);
    for (const osg::ref_ptr<osg::Group>& group :
         {text, osg::ref_ptr<osg::Group>(flag), description, other})
        scene->addChild(group);
    ASSERT_EQ(instances().size(), 3u);
    std::string tag;
    EXPECT_TRUE(hapticTag(*text, tag));
    EXPECT_EQ(tag, "pressure=2");
    EXPECT_TRUE(hapticTag(*flag, tag));
    EXPECT_EQ(tag, "true");
    EXPECT_EQ(instances()[1].world.getTrans().x(), 3.0) << "its own transform included";
    EXPECT_TRUE(hapticTag(*description, tag));
    EXPECT_EQ(tag, "sampling=edges");
    EXPECT_FALSE(hapticTag(*other, tag));
}

TEST_F(Collect, ObstaclesAreTaggedLikeObjects)
{
    osg::ref_ptr<osg::Group> flag = new osg::Group;
    flag->setUserValue("obstacle", true);
    osg::ref_ptr<osg::Group> off = new osg::Group;
    off->setUserValue("obstacle", false);
    osg::ref_ptr<osg::Group> description = new osg::Group;
    description->addDescription("obstacle");
    for (const osg::ref_ptr<osg::Group>& group : {flag, off, description})
        scene->addChild(at(1.0, group));
    scene->addChild(surface);
    ASSERT_EQ(instances().size(), 3u);
    EXPECT_EQ(instances()[0].node, flag);
    EXPECT_EQ(instances()[0].kind, HapticInstance::OBSTACLE);
    EXPECT_EQ(instances()[0].world.getTrans().x(), 1.0);
    EXPECT_EQ(instances()[1].node, description);
    EXPECT_TRUE(instances()[2].isFelt());
    EXPECT_TRUE(isOwnObject(*flag)) << "no part of an object around it";
    EXPECT_FALSE(isOwnObject(*off));
}

TEST_F(Collect, ThePathNamesTheNodes)
{
    surface->setName("hand");
    scene->addChild(at(1.0, surface));
    instances();
    EXPECT_EQ(visitor.path(visitor.instances()[0]),
              "HapticScene/MatrixTransform/HapticSurface 'hand'");
}
