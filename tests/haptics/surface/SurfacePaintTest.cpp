#include "haptics/surface/SurfacePaint.h"

#include "haptics/surface/SurfaceSampler.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

PaintImage image(int width, int height, std::vector<float> values)
{
    PaintImage picture;
    picture.width = width;
    picture.height = height;
    picture.values = std::move(values);
    return picture;
}

/// A square of 100 mm in z = 0, u along x and v along y, 0 .. 1.
TriangleMesh paintedSquare(const PaintImage& picture)
{
    TriangleMesh mesh;
    mesh.vertices.resize(3, 4);
    mesh.vertices << 0, 0.1, 0.1, 0, 0, 0, 0.1, 0.1, 0, 0, 0, 0;
    mesh.triangles.resize(3, 2);
    mesh.triangles << 0, 0, 1, 2, 2, 3;
    auto paint = std::make_shared<SurfacePaint>();
    paint->coordinates = mesh.vertices.topRows<2>() * 10.0;
    paint->images.push_back(std::make_shared<PaintImage>(picture));
    paint->image = {0, 0};
    mesh.paint = paint;
    return mesh;
}

} // namespace

TEST(PaintImage, IsExactInTheMiddleOfTexelsAndLinearBetween)
{
    const PaintImage picture = image(2, 2, {0.0f, 1.0f, 0.5f, 0.25f});
    EXPECT_FLOAT_EQ(picture.at(0.25, 0.25), 0.0f);
    EXPECT_FLOAT_EQ(picture.at(0.75, 0.25), 1.0f);
    EXPECT_FLOAT_EQ(picture.at(0.25, 0.75), 0.5f);
    EXPECT_FLOAT_EQ(picture.at(0.75, 0.75), 0.25f);
    EXPECT_FLOAT_EQ(picture.at(0.5, 0.25), 0.5f);
    EXPECT_FLOAT_EQ(picture.at(0.5, 0.5), 0.4375f) << "the mean of all four";
}

TEST(PaintImage, WrapsAsTheTextureIsDrawn)
{
    PaintImage picture = image(4, 1, {0.0f, 0.25f, 0.5f, 1.0f});
    EXPECT_FLOAT_EQ(picture.at(1.125, 0.5), 0.0f);
    EXPECT_FLOAT_EQ(picture.at(-0.125, 0.5), 1.0f);
    EXPECT_FLOAT_EQ(picture.at(5.0, -7.0), 0.5f) << "half way from the last texel to the first";
    picture.wrapU = PaintImage::Wrap::CLAMP;
    EXPECT_FLOAT_EQ(picture.at(1.125, 0.5), 1.0f);
    EXPECT_FLOAT_EQ(picture.at(-3.0, 0.5), 0.0f);
    picture.wrapU = PaintImage::Wrap::MIRROR;
    EXPECT_FLOAT_EQ(picture.at(1.125, 0.5), 1.0f);
    EXPECT_FLOAT_EQ(picture.at(1.875, 0.5), 0.0f);
    EXPECT_FLOAT_EQ(picture.at(-0.375, 0.5), 0.25f);
}

TEST(PaintImage, WhatIsNoPictureOrNoPlaceIsFeltInFull)
{
    EXPECT_EQ(PaintImage().at(0.5, 0.5), 1.0f);
    EXPECT_EQ(image(1, 1, {0.25f}).at(std::numeric_limits<double>::quiet_NaN(), 0.0), 1.0f);
    EXPECT_EQ(image(1, 1, {0.25f}).at(1e300, 0.0), 0.25f);
}

TEST(SurfacePaint, EachSampleHasTheIntensityOfItsPlace)
{
    // A ramp along u of 100 texels: at u between the outer middles it is u.
    std::vector<float> ramp;
    for (int i = 0; i < 100; ++i)
        ramp.push_back((static_cast<float>(i) + 0.5f) / 100.0f);
    PaintImage picture = image(100, 1, ramp);
    picture.wrapU = PaintImage::Wrap::CLAMP;
    TriangleMesh mesh = paintedSquare(picture);
    SurfaceSamples samples = sampleSurface(mesh, {});
    ASSERT_GT(samples.size(), 100);
    for (int i = 0; i < samples.size(); ++i)
        EXPECT_NEAR(static_cast<double>(samples.intensity[i]),
                    samples.positions(0, i) * 10.0,
                    0.0051) // half a texel at the border
            << i;
    // Painted anew, the samples take that over where they are.
    mesh.paint = paintedSquare(image(1, 1, {0.5f})).paint;
    updateSamples(mesh, samples);
    EXPECT_EQ(samples.intensity.minCoeff(), 0.5f);
    EXPECT_EQ(samples.intensity.maxCoeff(), 0.5f);
}

TEST(SurfacePaint, TrianglesWithoutAPictureAreFeltInFull)
{
    TriangleMesh mesh = paintedSquare(image(1, 1, {0.0f}));
    auto paint = std::make_shared<SurfacePaint>(*mesh.paint);
    paint->image = {0, -1};
    mesh.paint = paint;
    EXPECT_EQ(intensityAt(mesh, 0, Eigen::Vector3d(0.2, 0.3, 0.5)), 0.0f);
    EXPECT_EQ(intensityAt(mesh, 1, Eigen::Vector3d(0.2, 0.3, 0.5)), 1.0f);
}

TEST(SurfacePaint, PaintForAnotherMeshIsNamed)
{
    TriangleMesh mesh = paintedSquare(image(1, 1, {0.0f}));
    auto paint = std::make_shared<SurfacePaint>(*mesh.paint);
    paint->image.pop_back();
    mesh.paint = paint;
    try
    {
        sampleSurface(mesh, {});
        FAIL();
    }
    catch (const std::exception& error)
    {
        EXPECT_STREQ(error.what(),
                     "The mesh's paint is for 4 vertices and 1 triangles; there are 4 and 2");
    }
}
