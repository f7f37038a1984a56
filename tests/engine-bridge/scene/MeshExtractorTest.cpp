#include "engine-bridge/scene/MeshExtractor.h"

#include "tests/engine-bridge/scene/ExtractedMesh.h"
#include "tests/engine-bridge/scene/OsgScenes.h"

#include <osg/Billboard>
#include <osg/Camera>
#include <osg/LOD>
#include <osg/Shape>
#include <osg/ShapeDrawable>
#include <osg/Switch>

#include <gtest/gtest.h>

using namespace midair::bridge;

TEST(MeshExtractor, BakesInnerTransforms)
{
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(
        moved(osg::Matrixd::scale(2.0, 2.0, 2.0) * osg::Matrixd::translate(5.0, 0.0, 0.0),
              triangleGeometry()));
    const ExtractedMesh out = extractMesh(*root);
    ASSERT_EQ(out.mesh().vertices.cols(), 3);
    ASSERT_EQ(out.mesh().triangles.cols(), 1);
    // Small whole numbers: exact.
    EXPECT_EQ(out.mesh().vertices.col(0), Eigen::Vector3d(5.0, 0.0, 0.0));
    EXPECT_EQ(out.mesh().vertices.col(1), Eigen::Vector3d(7.0, 0.0, 0.0));
    EXPECT_EQ(out.mesh().vertices.col(2), Eigen::Vector3d(5.0, 2.0, 0.0));
}

TEST(MeshExtractor, TheRootsOwnTransformBelongsToThePose)
{
    auto root = moved(osg::Matrixd::translate(5.0, 0.0, 0.0), triangleGeometry());
    EXPECT_EQ(extractMesh(*root).mesh().vertices.col(0), Eigen::Vector3d(0.0, 0.0, 0.0));
}

TEST(MeshExtractor, SeveralDrawablesBecomeOneMesh)
{
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(triangleGeometry());
    root->addChild(moved(osg::Matrixd::translate(0.0, 0.0, 1.0), triangleGeometry()));
    const ExtractedMesh out = extractMesh(*root);
    ASSERT_EQ(out.mesh().triangles.cols(), 2);
    EXPECT_EQ(out.mesh().triangles.col(1), Eigen::Vector3i(3, 4, 5));
    EXPECT_EQ(out.mesh().vertices(2, 4), 1.0);
}

/// The triangles of the three vertices drawn in \a mode.
Eigen::Matrix3Xi drawnIn(GLenum mode)
{
    auto geometry = triangleGeometry();
    geometry->removePrimitiveSet(0, geometry->getNumPrimitiveSets());
    geometry->addPrimitiveSet(new osg::DrawArrays(mode, 0, 3));
    const ExtractedMesh out = extractMesh(*geometry);
    EXPECT_TRUE(out.warnings.empty()) << mode;
    return out.mesh().triangles;
}

TEST(MeshExtractor, LinesAndPointsBecomeTrianglesWithoutArea)
{
    Eigen::Matrix3Xi points(3, 3);
    points << 0, 1, 2, 0, 1, 2, 0, 1, 2;
    EXPECT_EQ(drawnIn(GL_POINTS), points);
    Eigen::Matrix3Xi loop(3, 3);
    loop << 0, 1, 2, 1, 2, 0, 1, 2, 0;
    EXPECT_EQ(drawnIn(GL_LINE_LOOP), loop);
    EXPECT_EQ(drawnIn(GL_LINE_STRIP), loop.leftCols(2));
    EXPECT_EQ(drawnIn(GL_LINES), loop.leftCols(1)); // the third vertex is half a line
}

TEST(MeshExtractor, EachOfSeveralLineStripsIsByItself)
{
    auto geometry = triangleGeometry();
    geometry->removePrimitiveSet(0, 1);
    static_cast<osg::Vec3Array*>(geometry->getVertexArray())->push_back({1.0f, 1.0f, 0.0f});
    osg::ref_ptr<osg::DrawArrayLengths> strips = new osg::DrawArrayLengths(GL_LINE_STRIP, 0);
    strips->push_back(2);
    strips->push_back(2);
    geometry->addPrimitiveSet(strips);
    Eigen::Matrix3Xi wanted(3, 2);
    wanted << 0, 2, 1, 3, 1, 3;
    EXPECT_EQ(extractMesh(*geometry).mesh().triangles, wanted);
}

TEST(MeshExtractor, AnOddNumberOfIndicesIsNotReadBeyond)
{
    auto geometry = triangleGeometry();
    geometry->removePrimitiveSet(0, 1);
    const GLuint indices[] = {0, 1, 2};
    geometry->addPrimitiveSet(new osg::DrawElementsUInt(GL_LINES, 3, indices));
    EXPECT_EQ(extractMesh(*geometry).mesh().triangles, Eigen::Vector3i(0, 1, 1));
}

TEST(MeshExtractor, JoinsOfStripsAreNoLines)
{
    auto geometry = triangleGeometry();
    geometry->removePrimitiveSet(0, 1);
    auto* vertices = static_cast<osg::Vec3Array*>(geometry->getVertexArray());
    for (const float x : {3.0f, 4.0f, 3.0f})
        vertices->push_back({x, x == 3.0f ? 0.0f : 1.0f, static_cast<float>(vertices->size())});
    const GLuint indices[] = {0, 1, 2, 2, 3, 3, 4, 5};
    geometry->addPrimitiveSet(new osg::DrawElementsUInt(GL_TRIANGLE_STRIP, 8, indices));
    EXPECT_EQ(extractMesh(*geometry).mesh().triangles.cols(), 2);
}

TEST(MeshExtractor, PrimitivesThatCantBeFeltAreTold)
{
    auto geometry = triangleGeometry();
    geometry->setName("patches");
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_PATCHES, 0, 3));
    const ExtractedMesh out = extractMesh(*geometry);
    EXPECT_EQ(out.mesh().triangles.cols(), 1);
    EXPECT_EQ(out.warnings,
              std::vector<std::string>{"Geometry 'patches' has primitives of mode 0xe (neither "
                                       "triangles, lines nor points); they can't be felt"});
}

TEST(MeshExtractor, QuadsStripsAndFansBecomeTriangles)
{
    auto geometry = triangleGeometry();
    static_cast<osg::Vec3Array*>(geometry->getVertexArray())->push_back({1.0f, 1.0f, 0.0f});
    for (const GLenum mode : {GL_QUADS, GL_TRIANGLE_STRIP, GL_TRIANGLE_FAN, GL_POLYGON})
    {
        geometry->removePrimitiveSet(0, geometry->getNumPrimitiveSets());
        geometry->addPrimitiveSet(new osg::DrawArrays(mode, 0, 4));
        EXPECT_EQ(extractMesh(*geometry).mesh().triangles.cols(), 2) << mode;
    }
}

TEST(MeshExtractor, ReadsDoubleVertices)
{
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    osg::ref_ptr<osg::Vec3dArray> vertices = new osg::Vec3dArray;
    for (const double x : {0.0, 1.0, 1e-9})
        vertices->push_back({x, x * x, 0.0});
    geometry->setVertexArray(vertices);
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, 3));
    EXPECT_EQ(extractMesh(*geometry).mesh().vertices(0, 2), 1e-9);
}

TEST(MeshExtractor, ReadsShapes)
{
    osg::ref_ptr<osg::ShapeDrawable> box = new osg::ShapeDrawable(new osg::Box({}, 2.0f));
    const ExtractedMesh out = extractMesh(*box);
    EXPECT_EQ(out.mesh().triangles.cols(), 12);
    const Eigen::Vector3d extent =
        out.mesh().vertices.rowwise().maxCoeff() - out.mesh().vertices.rowwise().minCoeff();
    EXPECT_TRUE(extent.isApprox(Eigen::Vector3d::Constant(2.0), 1e-6)) << "float vertices";
}

TEST(MeshExtractor, IndicesBeyondTheVerticesAreLeftOutWithAWarning)
{
    auto geometry = triangleGeometry();
    geometry->setName("broken");
    osg::ref_ptr<osg::DrawElementsUShort> elements = new osg::DrawElementsUShort(GL_TRIANGLES);
    for (const unsigned short i : {0, 1, 2, 0, 1, 9})
        elements->push_back(i);
    geometry->setPrimitiveSet(0, elements);
    const ExtractedMesh out = extractMesh(*geometry);
    EXPECT_EQ(out.mesh().triangles.cols(), 1);
    ASSERT_EQ(out.warnings.size(), 1u);
    EXPECT_EQ(out.warnings[0],
              "Geometry 'broken' has indices beyond its 3 vertices; those triangles are left out");
}

TEST(MeshExtractor, WhatIsSwitchedOffOrMaskedIsNotFelt)
{
    osg::ref_ptr<osg::Switch> root = new osg::Switch;
    root->addChild(triangleGeometry(), true);
    root->addChild(triangleGeometry(), false);
    EXPECT_EQ(extractMesh(*root).mesh().triangles.cols(), 1);
    root->getChild(0)->setNodeMask(0);
    EXPECT_EQ(extractMesh(*root).mesh().triangles.cols(), 0);
}

TEST(MeshExtractor, LevelsOfDetailCountAtTheirFinest)
{
    osg::ref_ptr<osg::LOD> root = new osg::LOD;
    root->addChild(new osg::ShapeDrawable(new osg::Box), 0.0f, 10.0f);
    root->addChild(triangleGeometry(), 10.0f, 1e6f);
    EXPECT_EQ(extractMesh(*root).mesh().triangles.cols(), 12);
}

TEST(MeshExtractor, WhatHangsOnTheCameraIsNotInTheWorld)
{
    osg::ref_ptr<osg::Group> root = new osg::Group;
    osg::ref_ptr<osg::Camera> hud = new osg::Camera;
    hud->addChild(triangleGeometry());
    root->addChild(hud);
    auto absolute = moved(osg::Matrixd(), triangleGeometry());
    absolute->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
    absolute->setName("hud");
    root->addChild(absolute);
    const ExtractedMesh out = extractMesh(*root);
    EXPECT_EQ(out.mesh().triangles.cols(), 0);
    ASSERT_EQ(out.warnings.size(), 1u);
    EXPECT_EQ(out.warnings[0],
              "MatrixTransform 'hud' has an absolute reference frame; it can't be felt");
}

TEST(MeshExtractor, ABillboardIsFeltUnturnedWithAWarning)
{
    osg::ref_ptr<osg::Group> root = new osg::Group;
    osg::ref_ptr<osg::Billboard> billboard = new osg::Billboard;
    billboard->addDrawable(triangleGeometry());
    root->addChild(billboard);
    const ExtractedMesh out = extractMesh(*root);
    EXPECT_EQ(out.mesh().triangles.cols(), 1);
    ASSERT_EQ(out.warnings.size(), 1u);
    EXPECT_EQ(out.warnings[0], "Billboard turns with the camera on screen; it is felt unturned");
}

TEST(MeshExtractor, PaintedVerticesBecomeIntensity)
{
    auto geometry = triangleGeometry();
    osg::ref_ptr<osg::Vec4Array> colors = new osg::Vec4Array(osg::Array::BIND_PER_VERTEX);
    colors->push_back({1.0f, 1.0f, 1.0f, 1.0f});
    colors->push_back({0.5f, 0.5f, 0.5f, 1.0f});
    colors->push_back({1.0f, 1.0f, 1.0f, 0.25f});
    geometry->setColorArray(colors);
    EXPECT_EQ(extractMesh(*geometry).mesh().intensity.size(), 0) << "only where asked for";
    ExtractOptions options;
    options.paint.source = PaintOptions::VERTEX_COLORS;
    EXPECT_EQ(extractMesh(*geometry, options).mesh().intensity, Eigen::Vector3f(1.0f, 0.5f, 0.25f));
}

TEST(MeshFingerprint, IsTheSameWhileNothingChanges)
{
    auto geometry = triangleGeometry();
    osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(geometry);
    const MeshFingerprint before = fingerprint(*root);
    geometry->dirtyBound();
    EXPECT_EQ(fingerprint(*root), before) << "dirtyBound() is no change";
    EXPECT_EQ(extractMesh(*root).state.fingerprint(), before);
}

TEST(MeshFingerprint, MovedVerticesAreNotNewTriangles)
{
    auto geometry = triangleGeometry();
    const MeshFingerprint before = fingerprint(*geometry);
    (*static_cast<osg::Vec3Array*>(geometry->getVertexArray()))[0].z() = 0.1f;
    geometry->getVertexArray()->dirty();
    const MeshFingerprint after = fingerprint(*geometry);
    EXPECT_NE(after.vertices, before.vertices);
    EXPECT_EQ(after.topology, before.topology);
}

TEST(MeshFingerprint, SeesTheChildListPrimitivesArraysAndInnerTransforms)
{
    osg::ref_ptr<osg::Group> root = new osg::Group;
    auto geometry = triangleGeometry();
    auto transform = moved(osg::Matrixd(), geometry);
    root->addChild(transform);
    MeshFingerprint before = fingerprint(*root);
    auto changed = [&before, &root]
    {
        const MeshFingerprint now = fingerprint(*root);
        const bool different = now != before;
        before = now;
        return different;
    };
    EXPECT_FALSE(changed());
    transform->setMatrix(osg::Matrixd::translate(0.0, 0.0, 1e-6));
    EXPECT_TRUE(changed()) << "inner transform";
    geometry->getPrimitiveSet(0)->dirty();
    EXPECT_TRUE(changed()) << "primitive set";
    geometry->setVertexArray(new osg::Vec3Array(3));
    EXPECT_TRUE(changed()) << "vertex array";
    root->addChild(triangleGeometry());
    EXPECT_TRUE(changed()) << "child added";
    root->getChild(1)->setNodeMask(0);
    EXPECT_TRUE(changed()) << "child masked";
    root->removeChild(1);
    EXPECT_FALSE(changed()) << "what is masked is not there";
}

TEST(MeshExtractor, InstancingIsTold)
{
    const osg::ref_ptr<osg::Geometry> geometry = triangleGeometry();
    geometry->setName("grass");
    geometry->getPrimitiveSet(0)->setNumInstances(100);
    const ExtractedMesh read = extractMesh(*geometry);
    EXPECT_EQ(read.mesh().triangles.cols(), 1);
    ASSERT_EQ(read.warnings.size(), 1u);
    EXPECT_NE(read.warnings[0].find("Geometry 'grass' is drawn 100 times by instancing"),
              std::string::npos);
}
