#include "plugin/scene/SceneCollector.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticSurface>

#include <algorithm>

#include <gtest/gtest.h>

using namespace osgMidair;

TEST(PropertyConversion, AnUnknownMaterialIsToldAndItsObjectAloneIsNotFeltWhereItIsTouched)
{
    BoxScene box;
    osg::ref_ptr<HapticSurface> other = new HapticSurface;
    other->setName("other");
    other->addChild(BoxScene::box(0.02F));
    box.transform->addChild(other);
    box.surface->setMaterial("clothe");
    other->setMaterial("cloth");
    HeadlessViewer viewer(box.scene);
    const auto says = [&](const std::string& part)
    {
        const auto messages = box.scene->getStatistics().messages;
        return std::any_of(messages.begin(),
                           messages.end(),
                           [&](const std::string& text)
                           { return text.find(part) != std::string::npos; });
    };
    EXPECT_TRUE(viewer.framesUntil([&] { return says("material \"clothe\" is unknown"); }));
    EXPECT_TRUE(says("did you mean cloth")) << "the nearest";
    HapticProperty property;
    property.material = "clothe";
    EXPECT_EQ(forBridge(property).material.mostForce_N, 0.0);
    EXPECT_NE(problemOfMaterial(property), "");
    property.material = "cloth";
    EXPECT_GT(forBridge(property).material.mostForce_N, 0.0);
    EXPECT_EQ(problemOfMaterial(property), "");
    property.roughness = 2.0;
    EXPECT_EQ(forBridge(property).material.mostForce_N, 0.0) << "a number out of range";
    EXPECT_NE(problemOfMaterial(property), "");
}
