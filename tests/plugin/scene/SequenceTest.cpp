// An osg::Sequence shows one mesh after the other; each is sampled once.
#include "tests/plugin/KitTest.h"

#include <osg/Sequence>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

struct Steps : testing::Test
{
    Steps()
    {
        scene->setArray("board");
        transform->setMatrix(osg::Matrixd::translate(0.0, 0.0, 0.15));
        scene->addChild(transform);
    }

    /// Shows the children of \a sequence in turn until each was felt \a rounds times; returns how
    /// often meshes were sampled.
    std::uint64_t sampledIn(int rounds)
    {
        sequence->setMode(osg::Sequence::STOP); // the test says when, not the clock
        HeadlessViewer viewer(scene);
        for (int round = 0; round < rounds; ++round)
            for (unsigned int shown = 0; shown < sequence->getNumChildren(); ++shown)
            {
                sequence->setValue(static_cast<int>(shown));
                EXPECT_TRUE(viewer.framesUntil(
                    [&]
                    {
                        const auto field = scene->getField();
                        return field && width(*field) == shown;
                    }))
                    << round << ": " << shown;
            }
        return scene->getStatistics().meshesSampled;
    }

    /// The number of the mesh that is felt, by its size.
    static unsigned int width(const HapticField& field)
    {
        double most = 0.0;
        for (const HapticField::ControlPoint& point : field.getPoints())
            most = std::max(most, point.position.x());
        return most > 0.019 ? 1 : 0;
    }

    osg::ref_ptr<HapticScene> scene = new HapticScene;
    osg::ref_ptr<osg::MatrixTransform> transform = new osg::MatrixTransform;
    osg::ref_ptr<osg::Sequence> sequence = new osg::Sequence;
    osg::ref_ptr<osg::Node> small = BoxScene::box(0.03f);
    osg::ref_ptr<osg::Node> large = BoxScene::box(0.04f);
};

} // namespace

TEST_F(Steps, OfHapticObjectsAreSampledOnceEach)
{
    transform->addChild(sequence);
    sequence->addChild(new HapticSurface(small.get()), 1.0);
    sequence->addChild(new HapticSurface(large.get()), 1.0);
    EXPECT_EQ(sampledIn(4), 2u);
}

TEST_F(Steps, WithinAnObjectAreSampledOnceEach)
{
    osg::ref_ptr<HapticSurface> surface = new HapticSurface(sequence.get());
    transform->addChild(surface);
    sequence->addChild(small, 1.0);
    sequence->addChild(large, 1.0);
    EXPECT_EQ(sampledIn(4), 2u);
    EXPECT_EQ(scene->getStatistics().meshesRead, 2u);
}
