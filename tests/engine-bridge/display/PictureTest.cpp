#include "engine-bridge/display/Picture.h"

#include "tests/engine-bridge/display/LightTracer.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d pixelOf(const EyeView& eye, const Display& display, const Vector3d& place)
{
    const Eigen::Vector4d clip = eye.projection * (eye.view * place).homogeneous();
    return {0.5 * (clip.x() / clip.w() + 1.0) * display.width,
            0.5 * (clip.y() / clip.w() + 1.0) * display.height};
}

/// The largest error in pixels over places around (0, 0, 0.15), moved by \a motion with all else.
/// \a compared counts places that are seen.
double worstPixel(const Display& display,
                  const Eigen::Isometry3d& head,
                  const Eigen::Isometry3d& motion,
                  std::mt19937& lot,
                  int& compared)
{
    std::uniform_real_distribution<double> aside(-0.08, 0.08);
    const Picture picture(display);
    const LightTracer tracer(display);
    double worst = 0.0;
    for (const int side : {-1, 0, 1})
    {
        const Vector3d eye = eyeOf(motion * head, display.ipd_m, side);
        EXPECT_EQ(picture.whyUnseen(eye), "");
        const EyeView view = eyeView(picture, eye, 0.02, 20.0);
        EXPECT_NEAR(view.view.linear().determinant(), 1.0, 1e-12);
        for (int i = 0; i < 60; ++i)
        {
            const Vector3d place =
                motion * Vector3d(aside(lot), aside(lot), 0.15 + 0.7 * aside(lot));
            const auto truth = tracer.pixel(eye, place);
            if (!truth) continue;
            ++compared;
            worst = std::max(worst, (pixelOf(view, display, place) - *truth).norm());
            EXPECT_TRUE(picture.shows(eye, place));
        }
    }
    return worst;
}

Display moved(const Display& display, const Eigen::Isometry3d& motion)
{
    Display result = display;
    for (Vector3d* corner : {&result.lowerLeft, &result.lowerRight, &result.upperLeft})
        *corner = motion * *corner;
    for (Optic& optic : result.optics)
    {
        optic.point = motion * optic.point;
        optic.normal = motion.linear() * optic.normal;
        for (Vector3d& corner : optic.outline)
            corner = motion * corner;
    }
    return result;
}

Optic rectangle(Optic optic, double halfWidth_m, double halfHeight_m)
{
    const Vector3d x = Vector3d::UnitX();
    const Vector3d y = optic.normal.cross(x);
    optic.outline = {optic.point - halfWidth_m * x - halfHeight_m * y,
                     optic.point + halfWidth_m * x - halfHeight_m * y,
                     optic.point + halfWidth_m * x + halfHeight_m * y,
                     optic.point - halfWidth_m * x + halfHeight_m * y};
    return optic;
}

} // namespace

// 0.5 pixel is asked for; what is left is rounding.
TEST(Picture, IsWhereLightThroughTheOpticsComesFrom)
{
    std::mt19937 lot(1);
    for (const auto& [name, display] : displays::all())
        for (const double tilt_deg : {0.0, 20.0})
        {
            int compared = 0;
            const double worst = worstPixel(
                display, displays::head(tilt_deg), Eigen::Isometry3d::Identity(), lot, compared);
            EXPECT_LT(worst, 1e-6) << name << ", head tilted by " << tilt_deg;
            EXPECT_GT(compared, 150) << name;
        }
}

TEST(Picture, IsThereWhereverTheDisplayIs)
{
    std::mt19937 lot(2);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    int compared = 0;
    for (int i = 0; i < 100; ++i)
    {
        Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
        motion.translation() = 2.0 * Vector3d(any(lot), any(lot), any(lot));
        motion.rotate(Eigen::Quaterniond(any(lot), any(lot), any(lot), any(lot)).normalized());
        const Vector3d place(0.1 * any(lot), -0.8 + 0.15 * any(lot), 0.25 + 0.1 * any(lot));
        for (auto& [name, display] : displays::all())
        {
            // Optics that aren't at 45 degrees.
            Display tried = display;
            for (Optic& optic : tried.optics)
                optic.normal =
                    (optic.normal + 0.08 * Vector3d(any(lot), any(lot), any(lot))).normalized();
            const Display there = moved(tried, motion);
            EXPECT_LT(
                worstPixel(there, displays::head(30.0 * any(lot), place), motion, lot, compared),
                1e-6)
                << name << " " << i;
        }
    }
    EXPECT_GT(compared, 30000);
}

TEST(Picture, OfAHalfMirrorAloneIsFlipped)
{
    EXPECT_FALSE(Picture(displays::window()).isFlipped());
    EXPECT_TRUE(Picture(displays::halfMirror()).isFlipped());
    EXPECT_FALSE(Picture(displays::plate()).isFlipped());
    EXPECT_FALSE(Picture(displays::twoMirrors()).isFlipped());
}

TEST(Picture, TellsWhyTheEyeSeesNothing)
{
    const Vector3d eye(0.02, -0.8, 0.28);
    Display swapped = displays::window();
    std::swap(swapped.lowerRight, swapped.upperLeft);
    EXPECT_EQ(Picture(swapped).whyUnseen(eye),
              "the eye is 1.05 m behind the picture, most often because lowerRight_m and "
              "upperLeft_m are swapped");
    EXPECT_EQ(Picture(displays::screen({0.26, 0.25, 0.0}, {-0.26, 0.25, 0.0}, {0.26, 0.25, 0.30}))
                  .whyUnseen(eye),
              "the eye is 1.05 m behind the picture, most often because left and right corners are "
              "swapped");
    EXPECT_EQ(Picture(displays::screen({-0.26, 0.25, 0.3}, {0.26, 0.25, 0.3}, {-0.26, 0.25, 0.0}))
                  .whyUnseen(eye),
              "the eye is 1.05 m behind the picture, most often because lower and upper corners "
              "are swapped");
    EXPECT_EQ(Picture(displays::halfMirror()).whyUnseen({0.0, -0.2, -0.5}),
              "no light of the screen reaches the eye by optics[0]: both must be on the same side "
              "of a half mirror");
    for (const auto& [name, display] : displays::all())
        EXPECT_NE(Picture(display).whyUnseen({0.0, 2.0, 0.2}), "") << name;
}

TEST(Picture, IsCutByOutlinesAsLightIs)
{
    std::mt19937 lot(3);
    for (auto [name, display] : displays::all())
    {
        if (display.optics.empty()) continue;
        for (Optic& optic : display.optics)
            optic = rectangle(optic, 0.06, 0.09);
        const Picture picture(display);
        const LightTracer tracer(display);
        const Vector3d eye(0.02, -0.8, 0.28);
        const Vector3d low(-0.1, -0.1, 0.05);
        const Vector3d high(0.1, 0.1, 0.25);
        std::uniform_real_distribution<double> part(0.0, 1.0);
        int seen = 0;
        constexpr int kPlaces = 4000;
        for (int i = 0; i < kPlaces; ++i)
        {
            const Vector3d place =
                low + Vector3d(part(lot), part(lot), part(lot)).cwiseProduct(high - low);
            const bool truth = tracer.pixel(eye, place, true).has_value();
            ASSERT_EQ(picture.shows(eye, place), truth) << name;
            seen += truth ? 1 : 0;
        }
        const double share = seen / static_cast<double>(kPlaces);
        EXPECT_GT(share, 0.1) << name;
        EXPECT_LT(share, 0.9) << name;
        // 9 places along each edge, ends included.
        EXPECT_NEAR(picture.share(eye, low, high), share, 0.08) << name;
        // The part of the picture that is seen: its corners are on the rim of what shows.
        const std::vector<Vector3d> visible = picture.visiblePart(eye);
        ASSERT_GE(visible.size(), 3U) << name;
        Vector3d middle = Vector3d::Zero();
        for (const Vector3d& corner : visible)
            middle += corner / static_cast<double>(visible.size());
        for (const Vector3d& corner : visible)
        {
            EXPECT_TRUE(tracer.pixel(eye, middle + 0.999 * (corner - middle), true)) << name;
            EXPECT_FALSE(tracer.pixel(eye, middle + 1.001 * (corner - middle), true)) << name;
        }
    }
}

} // namespace midair::bridge
