#include "engine-bridge/pipeline/SampleCache.h"
#include "engine-bridge/scene/MeshCache.h"
#include "tests/engine-bridge/scene/ExtractedMesh.h"
#include "tests/engine-bridge/scene/OsgScenes.h"

#include <osg/Group>
#include <osg/Image>
#include <osg/TexGen>
#include <osg/Texture2D>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

/// Two texels: \a left and \a right.
osg::ref_ptr<osg::Image> twoTexels(const osg::Vec4& left, const osg::Vec4& right)
{
    osg::ref_ptr<osg::Image> image = new osg::Image;
    image->allocateImage(2, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE);
    image->setColor(left, 0, 0);
    image->setColor(right, 1, 0);
    return image;
}

const osg::Vec4 kBlack(0.0f, 0.0f, 0.0f, 1.0f);
const osg::Vec4 kWhite(1.0f, 1.0f, 1.0f, 1.0f);

struct Paint : testing::Test
{
    osg::ref_ptr<osg::Geometry> geometry = triangleGeometry(); // u, v = x, y
    osg::ref_ptr<osg::Texture2D> texture = new osg::Texture2D;
    osg::ref_ptr<osg::Group> root = new osg::Group;
    ExtractOptions options;
    std::vector<std::string> warnings;

    Paint()
    {
        osg::ref_ptr<osg::Vec2Array> uv = new osg::Vec2Array(osg::Array::BIND_PER_VERTEX);
        uv->push_back({0.0f, 0.0f});
        uv->push_back({1.0f, 0.0f});
        uv->push_back({0.0f, 1.0f});
        geometry->setTexCoordArray(0, uv);
        texture->setWrap(osg::Texture::WRAP_S, osg::Texture::CLAMP_TO_EDGE);
        texture->setImage(twoTexels(kBlack, kWhite));
        geometry->getOrCreateStateSet()->setTextureAttributeAndModes(0, texture);
        root->addChild(geometry);
        options.paint.source = PaintOptions::TEXTURE;
    }

    /// Intensity where x is \a x on the lower edge.
    double at(double x)
    {
        const ExtractedMesh out = extractMesh(*root, options);
        warnings = out.warnings;
        return static_cast<double>(
            haptics::intensityAt(out.mesh(), 0, Eigen::Vector3d(1.0 - x, x, 0.0)));
    }
};

} // namespace

TEST_F(Paint, TheTextureIsSampledAtTheCoordinatesOfThePoint)
{
    EXPECT_NEAR(at(0.0), 0.0, 1e-6);
    EXPECT_NEAR(at(0.25), 0.0, 1e-6) << "the middle of the black texel";
    EXPECT_NEAR(at(0.5), 0.5, 1e-6);
    EXPECT_NEAR(at(0.75), 1.0, 1e-6);
    EXPECT_TRUE(warnings.empty());
    options.paint.source = PaintOptions::NONE;
    EXPECT_EQ(at(0.25), 1.0);
}

TEST_F(Paint, TheNearestTextureAboveCounts)
{
    geometry->setStateSet(nullptr);
    osg::ref_ptr<osg::Group> above = new osg::Group;
    above->addChild(root);
    above->getOrCreateStateSet()->setTextureAttributeAndModes(0, texture);
    EXPECT_NEAR(at(0.25), 0.0, 1e-6) << "above the haptic node";
    osg::ref_ptr<osg::Texture2D> white = new osg::Texture2D(twoTexels(kWhite, kWhite));
    root->getOrCreateStateSet()->setTextureAttributeAndModes(0, white);
    EXPECT_NEAR(at(0.25), 1.0, 1e-6) << "the haptic node's own";
}

TEST_F(Paint, TheTextureMatrixCounts)
{
    geometry->getStateSet()->setTextureAttributeAndModes(
        0, new osg::TexMat(osg::Matrixd::translate(0.5, 0.0, 0.0)));
    EXPECT_NEAR(at(0.25), 1.0, 1e-6);
}

TEST_F(Paint, ChannelAndRange)
{
    texture->setImage(twoTexels({0.2f, 0.4f, 0.6f, 0.5f}, kWhite));
    const double texel = 1.0 / 255.0;
    EXPECT_NEAR(at(0.25), 0.4 * 0.5, texel) << "brightness: the mean times alpha";
    options.paint.channel = PaintOptions::RED;
    EXPECT_NEAR(at(0.25), 0.2, texel);
    options.paint.channel = PaintOptions::GREEN;
    EXPECT_NEAR(at(0.25), 0.4, texel);
    options.paint.channel = PaintOptions::BLUE;
    EXPECT_NEAR(at(0.25), 0.6, texel);
    options.paint.channel = PaintOptions::ALPHA;
    EXPECT_NEAR(at(0.25), 0.5, texel);
    options.paint.low = 0.25;
    options.paint.high = 0.75;
    EXPECT_NEAR(at(0.25), 0.5, texel);
    EXPECT_NEAR(at(0.75), 0.75, 1e-6);
    options.paint.low = 1.0;
    options.paint.high = 0.0;
    EXPECT_NEAR(at(0.75), 0.0, 1e-6) << "inverted";
}

TEST_F(Paint, VertexColoursTakeChannelAndRangeToo)
{
    osg::ref_ptr<osg::Vec4ubArray> colors = new osg::Vec4ubArray(osg::Array::BIND_PER_VERTEX);
    colors->push_back({0, 255, 0, 255});
    colors->push_back({255, 0, 0, 255});
    colors->push_back({0, 0, 0, 255});
    geometry->setColorArray(colors);
    options.paint = {PaintOptions::VERTEX_COLORS, PaintOptions::RED, 0.5, 1.0};
    EXPECT_NEAR(at(0.0), 0.5, 1e-6);
    EXPECT_NEAR(at(0.5), 0.75, 1e-6);
    EXPECT_NEAR(at(1.0), 1.0, 1e-6);
}

TEST_F(Paint, WhatIsMissingIsNamedAndFeltInFull)
{
    const auto warns = [this](const std::string& what)
    {
        EXPECT_EQ(at(0.25), 1.0);
        ASSERT_EQ(warnings.size(), 1u) << what;
        EXPECT_EQ(warnings[0], what);
    };
    geometry->setName("lid");
    texture->setName("bumps");
    texture->setImage(nullptr);
    warns("Geometry 'lid': Texture2D 'bumps' has no image in memory (not loaded, or released after "
          "drawing); it is felt unpainted");
    osg::ref_ptr<osg::Image> compressed = new osg::Image;
    compressed->allocateImage(4, 4, 1, GL_COMPRESSED_RGB_S3TC_DXT1_EXT, GL_UNSIGNED_BYTE);
    texture->setImage(compressed);
    warns("Geometry 'lid': Texture2D 'bumps' is compressed; it is felt unpainted");
    geometry->setTexCoordArray(0, nullptr);
    warns("Geometry 'lid' has no texture coordinates in unit 0; it is felt unpainted");
    geometry->setStateSet(nullptr);
    warns("Geometry 'lid' has no texture in unit 0; it is felt unpainted");
    options.paint.source = PaintOptions::VERTEX_COLORS;
    warns("Geometry 'lid' has no vertex colours; it is felt unpainted");
}

TEST_F(Paint, AnImageThatIsLetGoOfOnceDrawnIsStillFelt)
{
    MeshCache cache;
    const auto frame = [&]
    {
        std::vector<CachedMesh> parts;
        cache.beginFrame();
        cache.get(*root, Eigen::Matrix4d::Identity(), options, parts, warnings);
        cache.endFrame();
        return parts.at(0);
    };
    const CachedMesh before = frame();
    texture->setImage(nullptr); // what drawing does with setUnRefImageDataAfterApply(true)
    EXPECT_EQ(frame().meshId, before.meshId);
    // Something else about the mesh changes: it is read again, and still painted.
    geometry->getVertexArray()->dirty();
    const CachedMesh after = frame();
    EXPECT_NE(after.meshId, before.meshId);
    EXPECT_NEAR(haptics::intensityAt(*after.mesh, 0, Eigen::Vector3d(0.75, 0.25, 0.0)), 0.0, 1e-6);
    EXPECT_TRUE(warnings.empty());
}

TEST_F(Paint, APictureThatChangesIsPaintedAnewWithoutSampling)
{
    MeshCache cache;
    SampleCache samples;
    const auto frame = [&]
    {
        std::vector<CachedMesh> parts;
        cache.beginFrame();
        cache.get(*root, Eigen::Matrix4d::Identity(), options, parts, warnings);
        cache.endFrame();
        HapticObject object;
        object.meshId = parts.at(0).meshId;
        object.topologyId = parts.at(0).topologyId;
        object.mesh = parts.at(0).mesh;
        const Eigen::VectorXf intensity = samples.get(object, 0.1).sets.front().intensity;
        samples.endSnapshot();
        return intensity;
    };
    EXPECT_EQ(frame().maxCoeff(), 1.0f);
    texture->getImage()->setColor(kBlack, 1, 0);
    texture->getImage()->dirty();
    EXPECT_EQ(frame().maxCoeff(), 0.0f);
    EXPECT_EQ(samples.sampled(), 1u);
    EXPECT_EQ(samples.followed(), 1u);
    options.paint.low = 0.5;
    EXPECT_EQ(frame().maxCoeff(), 0.5f) << "another range";
}

TEST_F(Paint, CoordinatesOfTheGraphicsCardAreTold)
{
    root->getOrCreateStateSet()->setTextureMode(0, GL_TEXTURE_GEN_S, osg::StateAttribute::ON);
    EXPECT_EQ(at(0.0), 1.0) << "unpainted";
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("texture coordinates that the graphics card makes (TexGen)"),
              std::string::npos);
    const MeshFingerprint before = fingerprint(*root, options);
    geometry->getOrCreateStateSet()->setTextureMode(0, GL_TEXTURE_GEN_S, osg::StateAttribute::OFF);
    EXPECT_NE(fingerprint(*root, options).paint, before.paint);
    EXPECT_LT(at(0.0), 1.0);
    EXPECT_TRUE(warnings.empty());
}
