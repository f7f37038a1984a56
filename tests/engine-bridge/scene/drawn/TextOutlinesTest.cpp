#include "engine-bridge/scene/drawn/TextOutlines.h"

#include "engine-bridge/scene/MeshExtractor.h"
#include "tests/engine-bridge/scene/ExtractedMesh.h"

#include <osg/BoundingBox>
#include <osg/MatrixTransform>
#include <osgText/Text3D>
#include <osgText/Text>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

using namespace midair::bridge;

namespace
{

const std::string kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

template<class Kind>
osg::ref_ptr<Kind> textSaying(const std::string& words, float height = 1.0f)
{
    osg::ref_ptr<Kind> text = new Kind;
    text->setFont(kFont);
    text->setCharacterSize(height);
    text->setText(words);
    return text;
}

osg::BoundingBoxd boxOf(const TextOutlines& outlines)
{
    osg::BoundingBoxd box;
    for (const auto& [a, b] : outlines.lines)
    {
        box.expandBy(outlines.places[static_cast<std::size_t>(a)]);
        box.expandBy(outlines.places[static_cast<std::size_t>(b)]);
    }
    return box;
}

/// Number of closed loops, if every place has as many lines that begin as lines that end there.
int loops(const TextOutlines& outlines)
{
    std::vector<int> group(outlines.places.size());
    std::vector<int> balance(outlines.places.size());
    for (std::size_t i = 0; i < group.size(); ++i)
        group[i] = static_cast<int>(i);
    for (const auto& [a, b] : outlines.lines)
    {
        ++balance[static_cast<std::size_t>(a)];
        --balance[static_cast<std::size_t>(b)];
        const int from = group[static_cast<std::size_t>(a)];
        const int to = group[static_cast<std::size_t>(b)];
        std::replace(group.begin(), group.end(), from, to);
    }
    EXPECT_TRUE(std::all_of(balance.begin(), balance.end(), [](int lines) { return lines == 0; }));
    std::vector<int> used;
    for (const auto& [a, b] : outlines.lines)
        used.push_back(group[static_cast<std::size_t>(a)]);
    std::sort(used.begin(), used.end());
    return static_cast<int>(std::unique(used.begin(), used.end()) - used.begin());
}

struct TextOutlinesTest : testing::Test
{
    void SetUp() override
    {
        if (!std::filesystem::exists(kFont)) GTEST_SKIP() << "there is no " << kFont;
    }
};

} // namespace

TEST_F(TextOutlinesTest, ACharacterIsItsContours)
{
    const TextOutlines flat = textOutlines(*textSaying<osgText::Text>("B"));
    EXPECT_EQ(flat.problem, "");
    EXPECT_EQ(loops(flat), 3) << "the outer one, and two holes";
    EXPECT_EQ(loops(textOutlines(*textSaying<osgText::Text3D>("B"))), 3);
    EXPECT_EQ(loops(textOutlines(*textSaying<osgText::Text>("I i"))), 3);
}

// The picture of a flat text is drawn in pixels of its font, 1/32 of its height by default; a
// solid one has the very outline.
TEST_F(TextOutlinesTest, TheyAreWhereTheTextIsDrawn)
{
    for (const auto align : {osgText::TextBase::LEFT_BASE_LINE, osgText::TextBase::CENTER_CENTER})
    {
        const osg::ref_ptr<osgText::Text> flat = textSaying<osgText::Text>("HHH", 0.04f);
        const osg::ref_ptr<osgText::Text3D> solid = textSaying<osgText::Text3D>("HHH", 0.04f);
        for (osgText::TextBase* text : {static_cast<osgText::TextBase*>(flat.get()),
                                        static_cast<osgText::TextBase*>(solid.get())})
        {
            text->setAlignment(align);
            text->setAxisAlignment(osgText::TextBase::XZ_PLANE);
            text->setPosition({0.1f, 0.2f, 0.3f});
            const osg::BoundingBoxd box = boxOf(textOutlines(*text));
            const osg::BoundingBox drawn = text->getBoundingBox();
            EXPECT_NEAR(box.yMin(), box.yMax(), 1e-6) << "one plane";
            EXPECT_GT(box.yMin(), static_cast<double>(drawn.yMin()) - 1e-6);
            EXPECT_LT(box.yMax(), static_cast<double>(drawn.yMax()) + 1e-6);
            EXPECT_GT(box.zMax() - box.zMin(), 0.7 * 0.04) << "the height of a capital";
            EXPECT_LT(box.zMax() - box.zMin(), 0.75 * 0.04);
            EXPECT_GT(box.xMin(), static_cast<double>(drawn.xMin()) - 0.002);
            EXPECT_LT(box.xMax(), static_cast<double>(drawn.xMax()) + 0.002);
            EXPECT_GT(box.zMin(), static_cast<double>(drawn.zMin()) - 0.002);
            EXPECT_LT(box.zMax(), static_cast<double>(drawn.zMax()) + 0.002);
        }
    }
}

TEST_F(TextOutlinesTest, WidthAndHeightCount)
{
    const osg::ref_ptr<osgText::Text> text = textSaying<osgText::Text>("H");
    const osg::BoundingBoxd wide = boxOf(textOutlines(*text));
    text->setCharacterSize(2.0f, 2.0f); // twice as high, and as wide as before
    const osg::BoundingBoxd high = boxOf(textOutlines(*text));
    EXPECT_NEAR(high.yMax() - high.yMin(), 2.0 * (wide.yMax() - wide.yMin()), 1e-5);
    EXPECT_NEAR(high.xMax() - high.xMin(), wide.xMax() - wide.xMin(), 1e-5);
}

TEST_F(TextOutlinesTest, WhatHasNoPlaceOrOutlineIsTold)
{
    const osg::ref_ptr<osgText::Text> text = textSaying<osgText::Text>("to you");
    text->setAxisAlignment(osgText::TextBase::SCREEN);
    EXPECT_NE(textOutlines(*text).problem.find("turns or scales with the screen"),
              std::string::npos);
    text->setAxisAlignment(osgText::TextBase::XY_PLANE);
    text->setAutoRotateToScreen(false);
    EXPECT_EQ(textOutlines(*text).problem, "");
    text->setCharacterSizeMode(osgText::TextBase::SCREEN_COORDS);
    EXPECT_NE(textOutlines(*text).problem.find("turns or scales with the screen"),
              std::string::npos);
    EXPECT_NE(textOutlines(*textSaying<osgText::Text>("  ")).problem.find("without any character"),
              std::string::npos);
    const osg::ref_ptr<osgText::Text> plain = new osgText::Text; // OSG's own font of pixels
    plain->setText("ab");
    EXPECT_NE(textOutlines(*plain).problem.find("2 characters have no outline"), std::string::npos);
}

TEST_F(TextOutlinesTest, AreReadAsLinesAndAnew)
{
    const osg::ref_ptr<osgText::Text> text = textSaying<osgText::Text>("o");
    const osg::ref_ptr<osg::MatrixTransform> root = new osg::MatrixTransform;
    const osg::ref_ptr<osg::MatrixTransform> moved =
        new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 5.0));
    moved->addChild(text);
    root->addChild(moved);
    const ExtractedMesh read = extractMesh(*root);
    EXPECT_TRUE(read.warnings.empty());
    ASSERT_GT(read.mesh().triangles.cols(), 10);
    EXPECT_EQ(read.mesh().triangles.row(1), read.mesh().triangles.row(2)) << "lines";
    EXPECT_NEAR(read.mesh().vertices.row(2).minCoeff(), 5.0, 1e-6);
    const MeshFingerprint before = fingerprint(*root);
    EXPECT_EQ(fingerprint(*root), before);
    text->setPosition({1.0f, 0.0f, 0.0f});
    const MeshFingerprint placed = fingerprint(*root);
    EXPECT_NE(placed.vertices, before.vertices);
    EXPECT_EQ(placed.topology, before.topology) << "the same lines elsewhere";
    text->setText("u");
    EXPECT_NE(fingerprint(*root).topology, placed.topology);
    const MeshFingerprint other = fingerprint(*root);
    text->setAutoRotateToScreen(true);
    EXPECT_NE(fingerprint(*root).topology, other.topology);
}
