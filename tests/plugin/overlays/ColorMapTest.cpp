#include <osgMidair/ColorMap>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

using osgMidair::ColorMap;

namespace
{

osg::Vec3f labAt(const ColorMap& map, int i)
{
    return osgMidair::oklabFromSrgb(map.color(static_cast<float>(i) / (ColorMap::kSize - 1)));
}

/// Distances in Oklab between neighbouring entries \a first .. \a last.
std::vector<float> steps(const ColorMap& map, int first, int last)
{
    std::vector<float> made;
    for (int i = first; i < last; ++i)
        made.push_back((labAt(map, i + 1) - labAt(map, i)).length());
    return made;
}

/// Largest deviation of \a values from their mean, relative.
float unevenness(const std::vector<float>& values)
{
    float sum = 0.0F;
    for (const float value : values)
        sum += value;
    const float mean = sum / static_cast<float>(values.size());
    float worst = 0.0F;
    for (const float value : values)
        worst = std::max(worst, std::abs(value / mean - 1.0F));
    return worst;
}

void expectColor(const osg::Vec3f& color, int red, int green, int blue)
{
    // Half an 8-bit step, and as much for the spline's table.
    EXPECT_NEAR(255.0F * color.x(), red, 1.0F);
    EXPECT_NEAR(255.0F * color.y(), green, 1.0F);
    EXPECT_NEAR(255.0F * color.z(), blue, 1.0F);
}

/// What an eye without its red (protan) or green (deutan) cones sees, in linear RGB (F. Vienot, H.
/// Brettel, J. D. Mollon, "Digital video colourmaps for checking the legibility of displays by
/// dichromats", 1999, equations for both kinds).
osg::Vec3f seenByDichromat(const osg::Vec3f& srgb, bool protan)
{
    const auto linear = [](float s) { return std::pow(s, 2.2F); };
    const float r = linear(srgb.x());
    const float g = linear(srgb.y());
    const float b = linear(srgb.z());
    const float rg = protan ? 0.11238F * r + 0.88762F * g : 0.29275F * r + 0.70725F * g;
    const float blue = protan ? 0.00401F * r - 0.00401F * g + b : -0.02234F * r + 0.02234F * g + b;
    const auto back = [](float l) { return std::pow(std::clamp(l, 0.0F, 1.0F), 1.0F / 2.2F); };
    return {back(rg), back(rg), back(blue)};
}

} // namespace

TEST(ColorMap, OklabAndBack)
{
    // White is L = 1 without chroma; red as Ottosson tabulates it.
    const osg::Vec3f white = osgMidair::oklabFromSrgb({1.0F, 1.0F, 1.0F});
    EXPECT_NEAR(white.x(), 1.0F, 1e-4F);
    EXPECT_NEAR(std::hypot(white.y(), white.z()), 0.0F, 1e-4F);
    const osg::Vec3f red = osgMidair::oklabFromSrgb({1.0F, 0.0F, 0.0F});
    EXPECT_NEAR(red.x(), 0.628F, 1e-3F);
    EXPECT_NEAR(red.y(), 0.225F, 1e-3F);
    EXPECT_NEAR(red.z(), 0.126F, 1e-3F);
    for (const osg::Vec3f& color : {osg::Vec3f(0.2F, 0.4F, 0.9F),
                                    osg::Vec3f(0.9F, 0.1F, 0.05F),
                                    osg::Vec3f(0.01F, 0.5F, 0.3F)})
        EXPECT_LT((osgMidair::srgbFromOklab(osgMidair::oklabFromSrgb(color)) - color).length(),
                  1e-4F);
}

TEST(ColorMap, PressureRisesInEvenSteps)
{
    const ColorMap& map = ColorMap::pressure();
    expectColor(map.color(0.0F), 68, 1, 84);
    expectColor(map.color(1.0F), 253, 231, 37);
    for (int i = 0; i + 1 < ColorMap::kSize; ++i)
        ASSERT_GT(labAt(map, i + 1).x(), labAt(map, i).x()) << "at " << i;
    // 1/4096 of the curve's length is a sixteenth of a step, on either side.
    EXPECT_LT(unevenness(steps(map, 0, ColorMap::kSize - 1)), 0.15F);
}

TEST(ColorMap, RadiationRisesInEvenStepsAndIsNotTakenForPressure)
{
    const ColorMap& map = ColorMap::radiation();
    for (int i = 0; i + 1 < ColorMap::kSize; ++i)
        ASSERT_GT(labAt(map, i + 1).x(), labAt(map, i).x()) << "at " << i;
    EXPECT_LT(unevenness(steps(map, 0, ColorMap::kSize - 1)), 0.15F);
    for (int i = 64; i < 216; ++i) // but near the dark and the light end
        EXPECT_GT((labAt(map, i) - labAt(ColorMap::pressure(), i)).length(), 0.12F) << "at " << i;
}

TEST(ColorMap, DivergingIsEvenOnBothSidesOfANeutralMiddle)
{
    const ColorMap& map = ColorMap::diverging();
    const osg::Vec3f middle = osgMidair::oklabFromSrgb(map.color(0.5F));
    EXPECT_LT(std::hypot(middle.y(), middle.z()), 0.01F);
    EXPECT_GT(middle.x(), 0.93F);
    const std::vector<float> low = steps(map, 0, 126);
    const std::vector<float> high = steps(map, 128, 254);
    EXPECT_LT(unevenness(low), 0.02F);
    EXPECT_LT(unevenness(high), 0.02F);
    EXPECT_NEAR(low.front() / high.front(), 1.0F, 0.02F);
    for (int i = 0; i < 127; ++i)
        EXPECT_NEAR(labAt(map, i).x(), labAt(map, 255 - i).x(), 0.01F);
}

TEST(ColorMap, DivergingEndsStayApartForColourBlindEyes)
{
    const ColorMap& map = ColorMap::diverging();
    const float full = (labAt(map, 0) - labAt(map, 255)).length();
    for (const bool protan : {true, false})
    {
        const osg::Vec3f low = osgMidair::oklabFromSrgb(seenByDichromat(map.color(0.0F), protan));
        const osg::Vec3f high = osgMidair::oklabFromSrgb(seenByDichromat(map.color(1.0F), protan));
        // A pair of red and green would keep under a fifth.
        EXPECT_GT((low - high).length(), 0.6F * full) << (protan ? "protan" : "deutan");
    }
}

TEST(ColorMap, PhaseClosesAndFavoursNoAngle)
{
    const ColorMap& map = ColorMap::phase();
    EXPECT_LT((map.color(0.0F) - map.color(1.0F)).length(), 1e-3F);
    for (int i = 0; i < ColorMap::kSize; ++i)
    {
        EXPECT_NEAR(labAt(map, i).x(), 0.73F, 0.005F);
        EXPECT_NEAR(std::hypot(labAt(map, i).y(), labAt(map, i).z()), 0.12F, 0.005F) << i;
    }
}

TEST(ColorMap, OutsideAndNotANumberAreClamped)
{
    const ColorMap& map = ColorMap::pressure();
    EXPECT_EQ(map.color(-3.0F), map.color(0.0F));
    EXPECT_EQ(map.color(7.0F), map.color(1.0F));
    EXPECT_EQ(map.color(std::numeric_limits<float>::quiet_NaN()), map.color(0.0F));
    EXPECT_EQ(map.color(std::numeric_limits<float>::infinity()), map.color(1.0F));
}

TEST(ColorMap, RatioIsLogarithmicBetweenHalfAndTwice)
{
    EXPECT_FLOAT_EQ(ColorMap::ratioPosition(5.0F, 5.0F), 0.5F);
    EXPECT_FLOAT_EQ(ColorMap::ratioPosition(2.5F, 5.0F), 0.0F);
    EXPECT_FLOAT_EQ(ColorMap::ratioPosition(10.0F, 5.0F), 1.0F);
    EXPECT_FLOAT_EQ(ColorMap::ratioPosition(5.0F * std::sqrt(2.0F), 5.0F), 0.75F);
    EXPECT_FLOAT_EQ(ColorMap::ratioPosition(0.0F, 5.0F), 0.0F);
    EXPECT_FLOAT_EQ(ColorMap::ratioPosition(1.0F, 0.0F), 0.0F);
}

TEST(ColorMap, ImageHoldsTheMap)
{
    const osg::ref_ptr<osg::Image> image = ColorMap::pressure().createImage();
    ASSERT_EQ(image->s(), ColorMap::kSize);
    ASSERT_EQ(image->t(), 1);
    const osg::Vec4 last = image->getColor(ColorMap::kSize - 1, 0);
    expectColor({last.r(), last.g(), last.b()}, 253, 231, 37);
    EXPECT_FLOAT_EQ(last.a(), 1.0F);
}
