#include "engine-bridge/scene/MeshCache.h"

#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/Geometry>

#include <gtest/gtest.h>

using namespace osgMidair;
using midair::bridge::MeshCache;

namespace
{

/// A plate of side x side vertices, 100 mm wide, 150 mm above the board.
osg::ref_ptr<osg::Geometry> plate(unsigned int side)
{
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
    osg::ref_ptr<osg::DrawElementsUInt> quads = new osg::DrawElementsUInt(GL_QUADS);
    for (unsigned int j = 0; j < side; ++j)
        for (unsigned int i = 0; i < side; ++i)
            vertices->push_back(osg::Vec3d(0.1 * i / side - 0.05, 0.1 * j / side - 0.05, 0.15));
    for (unsigned int j = 0; j + 1 < side; ++j)
        for (unsigned int i = 0; i + 1 < side; ++i)
            for (const unsigned int v : {0U, 1U, side + 1U, side})
                quads->push_back(j * side + i + v);
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setVertexArray(vertices);
    geometry->addPrimitiveSet(quads);
    return geometry;
}

} // namespace

TEST(LargeSurface, IsFeltOnceItIsReadWholeAndSmallOnesAtOnce)
{
    osg::ref_ptr<HapticScene> scene = new HapticScene;
    scene->setDevice("null:");
    scene->setArray("board");
    scene->addChild(new HapticSurface(plate(256).get()));
    scene->addChild(new HapticSurface(plate(40).get()));
    const osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
    scene->update(stamp);
    EXPECT_EQ(scene->getStatistics().objects, 1) << "the small one";
    EXPECT_EQ(scene->getStatistics().objectsBeingRead, 1);
    int frames = 1;
    for (; frames < 100 && scene->getStatistics().objectsBeingRead > 0; ++frames)
    {
        EXPECT_EQ(scene->getStatistics().objects, 1);
        scene->update(stamp);
    }
    EXPECT_EQ(scene->getStatistics().objects, 2);
    constexpr int kBytes = 256 * 256 * 12 + 255 * 255 * 4 * 4; // vertices and indices
    EXPECT_LE(frames, kBytes / int(MeshCache::kFrameBytes) + 2);
    EXPECT_EQ(scene->getStatistics().meshesRead, 2u);
    EXPECT_TRUE(scene->getStatistics().messages.empty());
}
