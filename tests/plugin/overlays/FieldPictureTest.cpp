#include <osgMidair/ColorMap>
#include <osgMidair/FieldPicture>

#include <cmath>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// 1000 Pa at one sample of 5 x 3, and none elsewhere.
FieldPicture spot()
{
    FieldPicture picture;
    picture.corner.set(-0.02, -0.01, 0.0);
    picture.across.set(0.04, 0.0, 0.0);
    picture.up.set(0.0, 0.02, 0.0);
    picture.columns = 5;
    picture.rows = 3;
    picture.pressures_Pa.assign(15, 0.0F);
    picture.pressures_Pa[2 * 5 + 3] = 1000.0F;
    return picture;
}

} // namespace

TEST(FieldPicture, ItsPlacesAreTheSamplesRowByRow)
{
    const std::vector<osg::Vec3d> places = spot().getPlaces();
    ASSERT_EQ(places.size(), 15u);
    EXPECT_LT((places[0] - osg::Vec3d(-0.02, -0.01, 0.0)).length(), 1e-12);
    EXPECT_LT((places[4] - osg::Vec3d(0.02, -0.01, 0.0)).length(), 1e-12);
    EXPECT_LT((places[2 * 5 + 3] - osg::Vec3d(0.01, 0.01, 0.0)).length(), 1e-12);
}

TEST(FieldPicture, TheSliceShowsThePressureWhereItIs)
{
    const osg::ref_ptr<osg::Image> slice = spot().createSlice();
    ASSERT_TRUE(slice.valid());
    ASSERT_EQ(slice->s(), slice->t() / 3 * 5);
    const int texel = slice->s() / 5;
    const auto colorAt = [&](int column, int row)
    {
        const osg::Vec4 color =
            slice->getColor(column * texel + texel / 2, row * texel + texel / 2);
        return osg::Vec3f(color.r(), color.g(), color.b());
    };
    EXPECT_LT((colorAt(3, 2) - ColorMap::pressure().color(1.0F)).length(), 0.01F);
    EXPECT_LT((colorAt(1, 2) - ColorMap::pressure().color(0.0F)).length(), 0.01F);
    EXPECT_LT((colorAt(3, 0) - ColorMap::pressure().color(0.0F)).length(), 0.01F);
}

TEST(FieldPicture, AFigureHasItsSizeInPixels)
{
    int width = 0;
    int height = 0;
    EXPECT_TRUE(spot().createFigure(width, height).valid());
    // The longer side is 620 pixels long, beside margins for axes and scale.
    EXPECT_EQ(width, 620 + 92 + 150);
    EXPECT_EQ(height, 310 + 92 + 78);
}

TEST(FieldPicture, WhatCannotBeDrawnIsToldAndNotDrawn)
{
    const auto problemAfter = [](auto change)
    {
        FieldPicture picture = spot();
        change(picture);
        int width = 0;
        int height = 0;
        const std::string problem = picture.getProblem();
        EXPECT_EQ(picture.createSlice() == nullptr, !problem.empty());
        EXPECT_EQ(picture.createFigure(width, height) == nullptr, !problem.empty());
        return problem;
    };
    EXPECT_EQ(problemAfter([](FieldPicture&) {}), "");
    EXPECT_EQ(problemAfter([](FieldPicture& p) { p.rows = 1; }),
              "a field image needs at least 2 x 2 samples, not 5 x 1");
    EXPECT_EQ(problemAfter([](FieldPicture& p) { p.pressures_Pa.pop_back(); }),
              "a field image of 5 x 3 samples was given 14 pressures");
    EXPECT_EQ(problemAfter([](FieldPicture& p) { p.pressures_Pa[4] = std::nanf(""); }),
              "a field image was given pressures that are not finite");
    EXPECT_EQ(problemAfter([](FieldPicture& p) { p.up.set(0.01, 0.02, 0.0); }),
              "a field image needs two finite edges, perpendicular to each other");
    EXPECT_EQ(problemAfter([](FieldPicture& p) { p.across.set(0.0, 0.0, 0.0); }),
              "a field image needs two finite edges, perpendicular to each other");
    EXPECT_EQ(
        problemAfter([](FieldPicture& p) { p.points.push_back({osg::Vec3d(0.0, HUGE_VAL, 0.0)}); }),
        "a field image was given places that are not finite");
}
