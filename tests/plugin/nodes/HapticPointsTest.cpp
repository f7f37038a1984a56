#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticPoints>

#include <osg/Geometry>
#include <osgDB/Registry>

#include <algorithm>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

const std::vector<osg::Vec3d> kPlaces = {
    {0.0, 0.0, 0.0}, {0.0078125, 0.0, 0.0}, {0.01171875, 0.015625, 0.03125}};

/// Three points below a transform over one board.
struct Points
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    osg::ref_ptr<osg::MatrixTransform> transform = new osg::MatrixTransform;
    osg::ref_ptr<HapticPoints> points = new HapticPoints;
    HeadlessViewer viewer{scene};

    explicit Points(const std::vector<double>& pressures = {})
    {
        scene->setArray("board");
        points->setName("points");
        points->setPoints(kPlaces, pressures);
        transform->addChild(points);
        transform->setMatrix(osg::Matrixd::translate(0.0, 0.0, 0.15));
        scene->addChild(transform);
    }

    midair::haptics::ControlPoints played(int count)
    {
        const auto result = [&] { return SceneAccess::latestResult(*scene); };
        EXPECT_TRUE(
            viewer.framesUntil([&] { return result() && result()->points.size() == count; }));
        return result()->points;
    }

    bool says(const std::string& what) const
    {
        const auto messages = scene->getStatistics().messages;
        const std::string whose = "HapticScene/MatrixTransform/HapticPoints 'points': ";
        return std::any_of(messages.begin(),
                           messages.end(),
                           [&](const std::string& message) {
                               return message.rfind(whose, 0) == 0 &&
                                      message.find(what) != std::string::npos;
                           });
    }
};

osg::ref_ptr<osg::Node> throughStream(const osg::Node& node, const std::string& type)
{
    findPlugins();
    auto* format = osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
    const osg::ref_ptr<osgDB::Options> options = new osgDB::Options("fileType=" + type);
    std::stringstream stream(std::ios::in | std::ios::out | std::ios::binary);
    EXPECT_TRUE(format->writeNode(node, stream, options).success());
    return format->readNode(stream, options).takeNode();
}

} // namespace

TEST(HapticPoints, ExactlyThesePointsArePlayedWhereTheTransformTakesThem)
{
    Points scene;
    const osg::Matrixd matrix = osg::Matrixd::scale(2.0, 2.0, 2.0) *
                                osg::Matrixd::rotate(1.0, osg::Vec3d(1.0, 2.0, 3.0)) *
                                osg::Matrixd::translate(0.01, 0.0, 0.15);
    scene.transform->setMatrix(matrix);
    const midair::haptics::ControlPoints played = scene.played(3);
    EXPECT_FALSE(played.absolute);
    for (std::size_t i = 0; i < kPlaces.size(); ++i)
    {
        const osg::Vec3d place = kPlaces[i] * matrix;
        const Eigen::Vector3d wanted(place.x(), place.y(), place.z());
        EXPECT_LT((played.positions.colwise() - wanted).colwise().norm().minCoeff(), 1e-7) << i;
    }
}

TEST(HapticPoints, EachHasItsPressure)
{
    Points scene({300.0, 0.0, 600.0});
    scene.points->setPressureUnit(HapticProperty::PASCAL);
    const midair::haptics::ControlPoints played = scene.played(2); // 0 is not felt
    EXPECT_TRUE(played.absolute);
    for (int i = 0; i < 2; ++i)
        EXPECT_NEAR(played.targets[i], played.positions(0, i) < 0.005 ? 300.0 : 600.0, 1e-3);
    // A change of pressure alone is played too.
    scene.points->setPressures({200.0, 100.0, 400.0});
    EXPECT_NEAR(scene.played(3).targets.sum(), 700.0, 1e-3);
}

TEST(HapticPoints, WhatCannotBeFeltIsToldByName)
{
    Points scene({1.0, -1.0, std::numeric_limits<double>::quiet_NaN()});
    EXPECT_EQ(scene.played(1).size(), 1);
    EXPECT_TRUE(scene.says("of point 1, is -1, should be 0 or 1e-06 .. 100000"));
    EXPECT_TRUE(scene.says("2 of 3 points have invalid pressures"));
    scene.points->setPressures({1.0, 1.0});
    scene.played(0);
    EXPECT_TRUE(scene.says("has 2 pressures for 3 points; it can't be felt"));
    scene.points->setPoints({{0.0, std::numeric_limits<double>::infinity(), 0.0}, {}});
    scene.played(1);
    EXPECT_TRUE(scene.says("1 of 2 points are not finite"));
    scene.points->setPoints({});
    scene.played(0);
    EXPECT_TRUE(scene.says("has no points; it can't be felt"));
}

TEST(HapticPoints, PointsAtOnePlaceAreFeltAsOneWhichIsTold)
{
    Points scene;
    scene.points->setPoints({kPlaces[0], kPlaces[1], kPlaces[0], kPlaces[2], kPlaces[2]});
    EXPECT_EQ(scene.played(3).size(), 3);
    EXPECT_TRUE(scene.says("2 of 5 points coincide"));
    EXPECT_TRUE(scene.says("is point 2, which coincides with point 0"));
}

TEST(HapticPoints, OfPointsAtOnePlaceTheFirstCounts)
{
    // The second is nearer to the array's middle; 0 is none that counts.
    const std::vector<osg::Vec3d> places = {
        {0.01, 0.0, 0.0}, {0.01 - 4e-7, 0.0, 0.0}, {-0.01, 0.0, 0.0}, {-0.01, 0.0, 0.0}};
    Points scene;
    scene.points->setPressureUnit(HapticProperty::PASCAL);
    scene.points->setPoints(places, {100.0, 300.0, 0.0, 200.0});
    const midair::haptics::ControlPoints played = scene.played(2);
    for (int i = 0; i < 2; ++i)
        EXPECT_NEAR(played.targets[i], played.positions(0, i) > 0.0 ? 100.0 : 200.0, 1e-3);
    EXPECT_TRUE(scene.says("1 of 4 points coincide"));
    EXPECT_TRUE(scene.says("is point 1, which coincides with point 0"));
}

// Where none can be used nothing is kept, and it was told in each frame.
TEST(HapticPoints, WhatIsWrongIsToldWhenItBegins)
{
    Points scene({-1.0, -1.0, -1.0});
    const auto count = [&](const std::string& part)
    {
        std::uint64_t all = 0;
        for (const HapticMessage& message : scene.scene->getStatistics().told)
            if (message.text.find(part) != std::string::npos) all += message.count;
        return all;
    };
    const auto move = [&](int frames, double pressure)
    {
        for (int i = 0; i < frames; ++i)
        {
            if (pressure != 0.0) scene.points->setPressures({pressure, pressure, -1.0 - i});
            scene.transform->setMatrix(osg::Matrixd::translate(1e-3 * i, 0.0, 0.15));
            scene.viewer.frame();
        }
    };
    move(10, 0.0);
    EXPECT_EQ(count("3 of 3 points have invalid pressures"), 1u);
    EXPECT_EQ(count("none of its points can be used"), 1u);
    move(10, 1.0); // others each time, and one that is wrong still
    EXPECT_EQ(count("points have invalid pressures"), 1u);
    scene.points->setPressures({1.0, 1.0, 1.0});
    scene.viewer.frame();
    scene.points->setPressures({1.0, 1.0, -1.0});
    scene.viewer.frame();
    EXPECT_EQ(count("points have invalid pressures"), 2u) << "it begins again";
}

TEST(HapticPoints, ComesThroughFilesOfAllKinds)
{
    const osg::ref_ptr<HapticPoints> points = new HapticPoints;
    points->setPoints(kPlaces, {1.0, 0.25, 0.5});
    points->setPressure(0.5);
    points->setPriority(3);
    for (const std::string type : {"Ascii", "XML", "Binary"})
    {
        const osg::ref_ptr<osg::Node> read = throughStream(*points, type);
        const auto* copy = dynamic_cast<const HapticPoints*>(read.get());
        ASSERT_NE(copy, nullptr) << type;
        ASSERT_EQ(copy->getPoints().size(), kPlaces.size()) << type;
        for (std::size_t i = 0; i < kPlaces.size(); ++i) // OSG's texts have six digits
            EXPECT_LT((copy->getPoints()[i] - kPlaces[i]).length(), 1e-7) << type;
        EXPECT_EQ(copy->getPressures(), points->getPressures()) << type;
        EXPECT_EQ(copy->getPressure(), 0.5) << type;
        EXPECT_TRUE(copy->getProperty() == points->getProperty()) << type;
        EXPECT_GT(copy->getNumChildrenRequiringEventTraversal(), 0u) << type;
    }
    const osg::ref_ptr<HapticPoints> clone = osg::clone(points.get());
    EXPECT_EQ(clone->getPoints(), kPlaces);
    EXPECT_EQ(clone->getPressures(), points->getPressures());
    EXPECT_EQ(clone->getProperty(), points->getProperty());
}

TEST(HapticPoints, AFileWithMorePointsThanItHasIsRefused)
{
    findPlugins();
    auto* format = osgDB::Registry::instance()->getReaderWriterForExtension("osgt");
    std::istringstream file("#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n\n"
                            "osgMidair::HapticPoints {\n  UniqueID 1\n  FormatVersion 1\n"
                            "  Points 4000000000 {\n    0 0 0\n  }\n}\n");
    const Notices notices;
    EXPECT_FALSE(format->readNode(file, nullptr).success());
    EXPECT_NE(notices.text().find("HapticPoints: Points can't be read"), std::string::npos)
        << notices.text();
}

TEST(HapticPoints, ALineOfAGeometryIsFeltAlongIt)
{
    BoxScene box;
    osg::ref_ptr<osg::Geometry> line = new osg::Geometry;
    osg::ref_ptr<osg::Vec3Array> ends = new osg::Vec3Array;
    ends->push_back({-0.017f, 0.0f, 0.0f});
    ends->push_back({0.017f, 0.0f, 0.0f});
    line->setVertexArray(ends);
    line->addPrimitiveSet(new osg::DrawArrays(GL_LINES, 0, 2));
    box.surface->removeChild(0, 1);
    box.surface->addChild(line);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == 4; }));
    const Eigen::Matrix3Xd places = box.result()->points.positions;
    EXPECT_LT((places.bottomRows(2).colwise() - Eigen::Vector2d(0.0, 0.15)).norm(), 1e-7);
    EXPECT_NEAR(places.row(0).maxCoeff() - places.row(0).minCoeff(), 0.034, 1e-7);
    // With edges at rest it is one smooth field.
    box.surface->setSampling(HapticProperty::EDGES);
    EXPECT_TRUE(viewer.framesUntil([&] { return box.result()->outline; }));
}
