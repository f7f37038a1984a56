#include "tests/plugin/KitTest.h"

#include <osg/Geometry>
#include <osg/ShapeDrawable>
#include <osg/ValueObject>

#include <cmath>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// The box over the board, and a sheet of 200 x 150 mm above it that is tagged.
struct Mirrored : BoxScene
{
    osg::ref_ptr<osg::MatrixTransform> plate =
        new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.25));

    explicit Mirrored(const std::string& tag, bool isTriangle = false)
    {
        scene->setEven(0); // figures at its points
        plate->setName("screen");
        plate->setUserValue("reflector", tag);
        osg::ref_ptr<osg::Geometry> sheet =
            osg::createTexturedQuadGeometry(osg::Vec3(-0.1f, -0.075f, 0.0f),
                                            osg::Vec3(0.2f, 0.0f, 0.0f),
                                            osg::Vec3(0.0f, 0.15f, 0.0f));
        if (isTriangle)
            sheet->setPrimitiveSet(0, new osg::DrawArrays(osg::PrimitiveSet::TRIANGLES, 0, 3));
        plate->addChild(sheet);
        scene->addChild(plate);
    }

    std::vector<midair::haptics::Reflector> reflectors() const
    {
        const auto newest = result();
        return newest && newest->array ? newest->array->reflectors
                                       : std::vector<midair::haptics::Reflector>();
    }
};

} // namespace

TEST(ReflectorTag, ItsFaceIsARectangleOfTheArrayAndIsFollowed)
{
    Mirrored mirrored("accuracy=0.2; reflection=0.8; reflectionPhase=0.3");
    HeadlessViewer viewer(mirrored.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return !mirrored.reflectors().empty(); }));
    EXPECT_EQ(mirrored.scene->getStatistics().objects, 1) << "it isn't felt";
    const midair::haptics::Reflector one = mirrored.reflectors().at(0);
    EXPECT_EQ(one.name, "screen");
    EXPECT_NEAR(one.position.z(), 0.25, 1e-6);
    EXPECT_NEAR(std::abs(one.normal.z()), 1.0, 1e-6);
    EXPECT_NEAR(one.size_m.prod(), 0.03, 1e-6);
    EXPECT_NEAR(one.size_m.maxCoeff(), 0.2, 1e-6);
    EXPECT_EQ(one.reflection, 0.8);
    EXPECT_EQ(one.reflectionPhase_rad, 0.3);
    EXPECT_EQ(one.accuracy_mm, 0.2);
    // In free air it has 2 %, not corrected 27 %.
    EXPECT_LT(mirrored.scene->getStatistics().rms, 0.04) << "the field is solved for it";
    mirrored.plate->setMatrix(osg::Matrixd::translate(0.0, 0.0, 0.27));
    ASSERT_TRUE(viewer.framesUntil(
        [&]
        {
            const auto now = mirrored.reflectors();
            return now.size() == 1 && std::abs(now[0].position.z() - 0.27) < 1e-6;
        }));
    EXPECT_LT(mirrored.scene->getStatistics().rms, 0.04);
    mirrored.plate->setNodeMask(0);
    EXPECT_TRUE(viewer.framesUntil([&] { return mirrored.reflectors().empty(); }))
        << "masked, it is not there";
    EXPECT_TRUE(mirrored.scene->getStatistics().messages.empty());
}

TEST(ReflectorTag, WhatCantBeUsedIsSaidOnceAndEnds)
{
    const std::string path = "HapticScene/MatrixTransform 'screen': ";
    Mirrored mirrored("reflection=2");
    HeadlessViewer viewer(mirrored.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return !mirrored.reflectors().empty(); }));
    viewer.frames(5);
    const auto codes = [&]
    {
        std::vector<std::string> all;
        for (const HapticMessage& one : mirrored.scene->getStatistics().told)
            if (one.isActive) all.push_back(one.code);
        return all;
    };
    const std::vector<std::string> both = {"reflector.invalid", "reflector.limited"};
    EXPECT_EQ(codes(), both);
    EXPECT_EQ(mirrored.scene->getStatistics().told.at(0).count, 1);
    EXPECT_EQ(mirrored.reflectors().at(0).reflection, 1.0) << "caps know the strongest";
    mirrored.plate->setUserValue("reflector", std::string("accuracy=0.5 mm"));
    EXPECT_TRUE(viewer.framesUntil([&] { return codes().empty(); }));
    mirrored.plate->setUserValue("reflector", std::string("false"));
    EXPECT_TRUE(viewer.framesUntil([&] { return mirrored.reflectors().empty(); }));

    Mirrored triangle("accuracy=0.2", true);
    HeadlessViewer other(triangle.scene);
    ASSERT_TRUE(other.framesUntil([&] { return triangle.points() > 0; }));
    other.frames(5);
    EXPECT_TRUE(triangle.reflectors().empty());
    const auto messages = triangle.scene->getStatistics().messages;
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_EQ(messages[0],
              path + "as a reflector: has a face that is no rectangle; it reflects nothing");
}

TEST(ReflectorTag, ClosedBodiesAreThoseOfFieldsAtRest)
{
    const std::string path = "HapticScene/MatrixTransform 'screen': as a reflector: is curved; ";
    const auto saidOf = [&](const std::string& tag)
    {
        Mirrored mirrored(tag);
        mirrored.plate->removeChildren(0, 1);
        mirrored.plate->addChild(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.02f)));
        HeadlessViewer viewer(mirrored.scene);
        EXPECT_TRUE(viewer.framesUntil([&] { return mirrored.points() > 0; }));
        viewer.frames(5);
        EXPECT_TRUE(mirrored.reflectors().empty());
        const auto messages = mirrored.scene->getStatistics().messages;
        return messages.empty() ? std::string() : messages.front();
    };
    EXPECT_EQ(saidOf("accuracy=0.2"), path + "only fields at rest are solved for it");
    EXPECT_EQ(saidOf("accuracy=2"), path + "it reflects nothing");
    EXPECT_EQ(saidOf("accuracy=0.2; reflection=0.8"), path + "it reflects nothing");
}
