// What a clip plane cuts off is not seen, so it is not felt.
#include "tests/plugin/KitTest.h"

#include <osg/ClipNode>
#include <osg/ClipPlane>
#include <osg/Program>

#include <algorithm>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A box below a ClipNode, which keeps what is at x > 0 of its own frame.
struct ClippedBox : testing::Test
{
    ClippedBox()
    {
        box.scene->removeChild(box.transform);
        clip->addClipPlane(plane);
        clip->addChild(box.transform);
        outer->addChild(clip);
        box.scene->addChild(outer);
    }

    double least() const { return extreme(false); }
    double most() const { return extreme(true); }
    double extreme(bool isMost) const
    {
        const osg::ref_ptr<const HapticField> field = box.scene->getField();
        if (!field || field->getPoints().empty()) return 0.0;
        const auto [low, high] = std::minmax_element(field->getPoints().begin(),
                                                     field->getPoints().end(),
                                                     [](const auto& a, const auto& b)
                                                     { return a.position.x() < b.position.x(); });
        return (isMost ? high : low)->position.x();
    }

    bool says(const std::string& what) const
    {
        const auto messages = box.scene->getStatistics().messages;
        return std::any_of(messages.begin(),
                           messages.end(),
                           [&](const std::string& text)
                           { return text.find(what) != std::string::npos; });
    }

    BoxScene box; ///< 40 mm wide
    osg::ref_ptr<osg::ClipPlane> plane = new osg::ClipPlane(0, 1.0, 0.0, 0.0, 0.0);
    osg::ref_ptr<osg::ClipNode> clip = new osg::ClipNode;
    osg::ref_ptr<osg::MatrixTransform> outer = new osg::MatrixTransform;
    HeadlessViewer viewer{box.scene};
};

/// A box whose state, or that of a group below it, does what the graphics card alone knows.
struct StateOfABox : ClippedBox
{
    osg::ref_ptr<osg::Group> inside = new osg::Group;

    StateOfABox()
    {
        plane->setClipPlane(0.0, 0.0, 1.0, 10.0); // far away
        box.surface->addChild(inside);
        inside->addChild(BoxScene::box(0.02f));
        inside->setName("inside");
    }

    static osg::ref_ptr<osg::Program> program(const std::string& line)
    {
        osg::ref_ptr<osg::Program> made = new osg::Program;
        made->addShader(new osg::Shader(osg::Shader::VERTEX, "void main()\n{\n" + line + "\n}\n"));
        return made;
    }
};

} // namespace

TEST_F(ClippedBox, IsFeltInFrontOfThePlaneOnly)
{
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_GE(least(), 0.0);
    EXPECT_NEAR(most(), 0.02, 1e-6);
    plane->setClipPlane(-1.0, 0.0, 0.0, 0.01);
    EXPECT_TRUE(viewer.framesUntil([&] { return least() < -0.019; })) << "the plane has moved";
    EXPECT_LE(most(), 0.01);
    outer->setMatrix(osg::Matrixd::translate(0.005, 0.0, 0.0));
    EXPECT_TRUE(viewer.framesUntil([&] { return least() > -0.016; })) << "with its frame";
    EXPECT_LE(most(), 0.015);
    EXPECT_TRUE(box.scene->getStatistics().messages.empty());
}

TEST_F(ClippedBox, IsFeltWholeWhereThePlaneIsOff)
{
    box.transform->getOrCreateStateSet()->setMode(GL_CLIP_PLANE0, osg::StateAttribute::OFF);
    EXPECT_TRUE(viewer.framesUntil([&] { return least() < -0.019; }));
    clip->setLocalStateSetModes(osg::StateAttribute::ON | osg::StateAttribute::OVERRIDE);
    EXPECT_TRUE(viewer.framesUntil([&] { return box.points() > 0 && least() >= 0.0; }))
        << "forced from above";
    clip->setLocalStateSetModes(osg::StateAttribute::OFF);
    EXPECT_TRUE(viewer.framesUntil([&] { return least() < -0.019; }));
}

TEST_F(ClippedBox, BehindThePlaneIsSilent)
{
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    plane->setClipPlane(1.0, 0.0, 0.0, -1.0);
    EXPECT_TRUE(viewer.framesUntil([&] { return box.points() == 0; }));
}

TEST_F(ClippedBox, ItsOutlinesAreNotPlayedWhole)
{
    box.surface->setSampling(HapticProperty::EDGES);
    plane->setClipPlane(1.0, 0.0, 0.0, 0.1);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.scene->getStatistics().outline; }))
        << "nothing is clipped: one smooth field";
    plane->setClipPlane(1.0, 0.0, 0.0, 0.0);
    ASSERT_TRUE(viewer.framesUntil([&] { return !box.scene->getStatistics().outline; }));
    viewer.frames(100);
    EXPECT_FALSE(box.scene->getStatistics().outline);
    EXPECT_GE(least(), 0.0);
}

TEST_F(StateOfABox, AShaderThatMayMoveVerticesIsTold)
{
    inside->getOrCreateStateSet()->setAttribute(
        program("gl_Position = gl_ModelViewProjectionMatrix * (gl_Vertex + vec4(0, 0, 1, 0));"));
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return says("Group 'inside' has a shader that may move vertices"); }));
}

TEST_F(StateOfABox, AShaderAboveIsToldToo)
{
    outer->setName("above");
    outer->getOrCreateStateSet()->setAttribute(program("gl_Position = bent(gl_Vertex);"));
    EXPECT_TRUE(viewer.framesUntil(
        [&] { return says("MatrixTransform 'above' has a shader that may move vertices"); }));
}

TEST_F(StateOfABox, AUsualShaderIsNot)
{
    inside->getOrCreateStateSet()->setAttribute(
        program("gl_Position =\n  gl_ModelViewProjectionMatrix*gl_Vertex;"));
    outer->getOrCreateStateSet()->setAttribute(program("gl_Position = ftransform();"));
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    EXPECT_TRUE(box.scene->getStatistics().messages.empty());
}

TEST_F(StateOfABox, AClipPlaneOfAStateIsTold)
{
    inside->getOrCreateStateSet()->setAttributeAndModes(new osg::ClipPlane(3, 1.0, 0.0, 0.0, 0.0));
    EXPECT_TRUE(viewer.framesUntil([&] { return says("Group 'inside' has a clip plane"); }));
}

TEST_F(StateOfABox, AClipNodeInAnAbsoluteFrameIsTold)
{
    clip->setReferenceFrame(osg::ClipNode::ABSOLUTE_RF);
    EXPECT_TRUE(
        viewer.framesUntil([&] { return says("ClipNode clips in an absolute frame, not in"); }));
}

TEST_F(StateOfABox, AClipNodeWithinIsTold)
{
    const osg::ref_ptr<osg::ClipNode> within = new osg::ClipNode;
    within->addChild(BoxScene::box(0.01f));
    inside->addChild(within);
    EXPECT_TRUE(viewer.framesUntil([&] { return says("ClipNode is inside the haptic object"); }));
}
