#include "engine-bridge/display/Coincidence.h"

#include "haptics/base/Percentile.h"
#include "tests/engine-bridge/display/LightTracer.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr double kMedianOfThree = 1.53817; ///< of the size of a normal error, over its sigma

/// What is wrong in the room.
struct Injected
{
    Vector3d eye = Vector3d::Zero();
    double ipd_m = 0.0;
    Vector3d screen = Vector3d::Zero();
    Vector3d turn = Vector3d::Zero(); ///< about the screen's middle
};

/// The displays of the other tests, for two eyes.
std::vector<Display> displaysForTwo()
{
    std::vector<Display> all;
    for (auto [name, display] : displays::all())
    {
        display.stereo = StereoMode::SIDE_BY_SIDE;
        display.isIpdGiven = true;
        all.push_back(display);
    }
    return all;
}

Display injected(Display display, const Injected& errors)
{
    const Vector3d middle = 0.5 * (display.lowerRight + display.upperLeft);
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    if (errors.turn.norm() > 0.0)
        turn = Eigen::AngleAxisd(errors.turn.norm(), errors.turn.normalized()).toRotationMatrix();
    for (Vector3d* corner : {&display.lowerLeft, &display.lowerRight, &display.upperLeft})
        *corner = middle + turn * (*corner - middle) + errors.screen;
    return display;
}

/// Where two eyes see what was drawn at \a place, by following light: each eye's sight of the pixel
/// that was lit for it, and the place that is nearest to both.
std::optional<Vector3d>
traced(const Display& display, const Vector3d& place, const Injected& errors)
{
    const LightTracer drawn(display);
    const LightTracer real(injected(display, errors));
    const Eigen::Isometry3d head = displays::head(0.0);
    Eigen::Matrix<double, 6, 5> lines = Eigen::Matrix<double, 6, 5>::Zero();
    Eigen::Matrix<double, 6, 1> eyes;
    for (const int i : {0, 1})
    {
        const Vector3d x = (i - 0.5) * head.linear().col(0);
        const auto pixel = drawn.pixel(head.translation() + display.ipd_m * x, place);
        if (!pixel) return {};
        const Vector3d eye = head.translation() + (display.ipd_m + errors.ipd_m) * x + errors.eye;
        const auto aim = real.aimAt(eye, place, *pixel);
        if (!aim) return {};
        // place - s way = eye, for both eyes, in the least squares
        lines.block<3, 3>(3 * i, 0).setIdentity();
        lines.block<3, 1>(3 * i, 3 + i) = -(*aim - eye).normalized();
        eyes.segment<3>(3 * i) = eye;
    }
    const Eigen::Matrix<double, 5, 1> solved =
        (lines.transpose() * lines).inverse() * (lines.transpose() * eyes);
    return Vector3d(solved.head<3>());
}

/// The median and the 95 % of how far \a place is seen from where it is, mm; \a put draws the
/// errors.
CoincidencePart truth(const Display& display,
                      const Vector3d& place,
                      const std::function<Injected(const std::function<Vector3d()>&)>& put)
{
    std::mt19937 lot(7);
    std::normal_distribution<double> normal;
    const auto three = [&] { return Vector3d(normal(lot), normal(lot), normal(lot)); };
    std::vector<double> sizes;
    for (int i = 0; i < 1500; ++i)
        if (const auto seen = traced(display, place, put(three)))
            sizes.push_back(1e3 * (*seen - place).norm());
    EXPECT_GT(sizes.size(), 1400U);
    return {CoincidencePart::KNOWN, base::percentile(sizes, 0.5), base::percentile(sizes, 0.95)};
}

/// Within 10 % or 0.3 mm.
void expectAlike(const CoincidencePart& figure, const CoincidencePart& truth)
{
    EXPECT_EQ(figure.state, CoincidencePart::KNOWN);
    EXPECT_NEAR(figure.median_mm, truth.median_mm, std::max(0.3, 0.1 * truth.median_mm));
    EXPECT_NEAR(figure.most_mm, truth.most_mm, std::max(0.3, 0.1 * truth.most_mm));
}

CoincidenceOptions seenBy(const Display& display)
{
    CoincidenceOptions options;
    options.seen.display = std::make_shared<const Display>(display);
    options.seen.head = displays::head(0.0);
    return options;
}

SeenObject resting(const Vector3d& place)
{
    SeenObject object;
    object.path = "Ball";
    object.place = place;
    object.motion.isKnown = true;
    return object;
}

const std::vector<Vector3d> kPlaces = {{0.0, 0.0, 0.15}, {0.03, -0.06, 0.13}, {-0.04, 0.05, 0.2}};

/// Where what is played with the phases \a phases sounds loudest, near \a place, by adding up
/// waves.
Vector3d loudest(const haptics::TransducerArray& array,
                 const Eigen::VectorXd& phases,
                 double wavelength_m,
                 Vector3d place)
{
    const double k = 2.0 * M_PI / wavelength_m;
    const auto loudness = [&](const Vector3d& at)
    {
        std::complex<double> sum = 0.0;
        for (Eigen::Index i = 0; i < array.size(); ++i)
        {
            const Vector3d way = at - array.positions.col(i);
            const double facing = array.normals.col(i).dot(way) / way.norm();
            if (facing > 0.0) sum += std::polar(facing / way.norm(), k * way.norm() + phases[i]);
        }
        return std::abs(sum);
    };
    for (double step_m = 1e-3; step_m > 1e-5;)
    {
        Vector3d best = place;
        double most = loudness(best);
        for (int axis = 0; axis < 3; ++axis)
            for (const double way : {-step_m, step_m})
            {
                const Vector3d tried = place + way * Vector3d::Unit(axis);
                const double loud = loudness(tried);
                if (loud > most) best = tried;
                most = std::max(most, loud);
            }
        if (best == place) step_m *= 0.5;
        place = best;
    }
    return place;
}

Vector3d heardShift(const haptics::TransducerArray& array, const Vector3d& focus, double faster)
{
    constexpr double kWavelength_m = 8.6e-3;
    Eigen::VectorXd phases(array.size());
    for (Eigen::Index i = 0; i < array.size(); ++i)
        phases[i] = -2.0 * M_PI / kWavelength_m * (focus - array.positions.col(i)).norm();
    // Without a warmer air the loudest place isn't quite the focus: nearer is louder.
    return loudest(array, phases, kWavelength_m * (1.0 + faster), focus) -
           loudest(array, phases, kWavelength_m, focus);
}

} // namespace

TEST(Coincidence, AnEyeThatIsOffMovesWhatIsBeforeThePicture)
{
    for (const Display& display : displaysForTwo())
        for (const Vector3d& place : kPlaces)
        {
            CoincidenceOptions options = seenBy(display);
            options.headError_m = 0.01;
            const CoincidenceFigures figures = coincidenceOf(options, resting(place));
            expectAlike(figures.eye,
                        truth(display,
                              place,
                              [](const auto& three)
                              {
                                  Injected errors;
                                  errors.eye = 0.01 / kMedianOfThree * three();
                                  return errors;
                              }));
        }
}

TEST(Coincidence, EyesFartherApartMoveItInDepth)
{
    for (const Display& display : displaysForTwo())
        for (const Vector3d& place : kPlaces)
            for (const double ipd_m : {-0.003, 0.003})
            {
                SightErrors errors;
                errors.ipd_m = ipd_m;
                Injected real;
                real.ipd_m = ipd_m;
                const auto seen = seenPlace(display, displays::head(0.0), place, errors);
                const auto truth = traced(display, place, real);
                ASSERT_TRUE(seen && truth);
                EXPECT_LT((*seen - *truth).norm(), 1e-6);
                EXPECT_NEAR((*seen - place).norm(), (*truth - place).norm(), 1e-6);
            }
}

// Of people whose distance was measured, and of any: 3.8 mm.
TEST(Coincidence, TheFigureOfTheEyesDistanceIsThatOfPeople)
{
    for (Display display : displaysForTwo())
        for (const Vector3d& place : kPlaces)
            for (const bool isGiven : {true, false})
            {
                display.isIpdGiven = isGiven;
                const CoincidenceFigures figures = coincidenceOf(seenBy(display), resting(place));
                expectAlike(figures.ipd,
                            truth(display,
                                  place,
                                  [isGiven](const auto& three)
                                  {
                                      Injected errors;
                                      errors.ipd_m = (isGiven ? 0.001 : 0.0038) * three().x();
                                      return errors;
                                  }));
            }
}

TEST(Coincidence, AScreenThatIsOffMovesIt)
{
    for (Display display : displaysForTwo())
        for (const Vector3d& place : kPlaces)
        {
            display.accuracy_m = 0.002;
            const CoincidenceFigures figures = coincidenceOf(seenBy(display), resting(place));
            expectAlike(figures.display,
                        truth(display,
                              place,
                              [](const auto& three)
                              {
                                  Injected errors;
                                  errors.screen = 0.002 / kMedianOfThree * three();
                                  return errors;
                              }));
        }
}

TEST(Coincidence, AScreenThatIsTurnedMovesIt)
{
    for (Display display : displaysForTwo())
        for (const Vector3d& place : kPlaces)
        {
            display.accuracy_m = 0.0;
            display.accuracy_rad = M_PI / 180.0;
            const CoincidenceFigures figures = coincidenceOf(seenBy(display), resting(place));
            expectAlike(figures.display,
                        truth(display,
                              place,
                              [](const auto& three)
                              {
                                  Injected errors;
                                  errors.turn = M_PI / 180.0 / kMedianOfThree * three();
                                  return errors;
                              }));
        }
}

// 5 K, at 20 C: 1.9 mm of a single board at 0.2 m.
TEST(Coincidence, WarmerAirMovesAFocus)
{
    const double faster = 0.5 * 5.0 / 293.15;
    const auto board = haptics::TransducerArray::load("board");
    const auto octagon = haptics::TransducerArray::octagonalPrism();
    const auto compare = [&](const haptics::TransducerArray& array, const Vector3d& focus)
    {
        const auto shift = airShift(array, focus, faster);
        ASSERT_TRUE(shift);
        const Vector3d heard = heardShift(array, focus, faster);
        EXPECT_LT((*shift - heard).norm(), std::max(3e-4, 0.1 * heard.norm()));
    };
    compare(board, {0.0, 0.0, 0.2});
    compare(board, {0.03, -0.02, 0.15});
    compare(octagon, {0.0, 0.0, 0.0});
    compare(octagon, {0.03, 0.02, 0.02});
    EXPECT_NEAR(airShift(board, {0.0, 0.0, 0.2}, faster)->z(), -1.9e-3, 2e-4);
    // By the speed of sound itself, in the figure.
    const double bySpeed = std::sqrt(298.15 / 293.15) - 1.0;
    for (const auto& [array, focus] : {std::pair(board, Vector3d(0.0, 0.0, 0.2)),
                                       std::pair(octagon, Vector3d(0.03, 0.02, 0.02))})
    {
        CoincidenceOptions warmer;
        warmer.array = std::make_shared<const haptics::TransducerArray>(array);
        warmer.airError_K = 5.0;
        const double median_mm = coincidenceOf(warmer, resting(focus)).air.median_mm;
        const double heard_mm = 1e3 * heardShift(array, focus, bySpeed).norm();
        EXPECT_NEAR(median_mm, heard_mm, std::max(0.3, 0.1 * heard_mm));
    }
    // As a figure: the median of a normal error of 5 K.
    CoincidenceOptions options;
    options.array = std::make_shared<const haptics::TransducerArray>(board);
    options.airError_K = 5.0;
    const CoincidenceFigures figures = coincidenceOf(options, resting({0.0, 0.0, 0.2}));
    EXPECT_NEAR(figures.air.median_mm, 1.9, 0.3);
    EXPECT_NEAR(figures.air.most_mm, 1.9 * 1.96 / 0.674, 0.6);
}

TEST(Coincidence, TheTotalIsOfAllAtOnce)
{
    Display display = displaysForTwo()[0];
    display.accuracy_m = 0.003;
    CoincidenceOptions options = seenBy(display);
    options.headError_m = 0.01;
    options.airError_K = 1e-6;
    options.array =
        std::make_shared<const haptics::TransducerArray>(haptics::TransducerArray::load("board"));
    const CoincidenceFigures figures = coincidenceOf(options, resting(kPlaces[0]));
    EXPECT_EQ(figures.unknown, "");
    EXPECT_EQ(figures.array.state, CoincidencePart::NONE) << "its frame is the world's";
    EXPECT_EQ(figures.tracker.state, CoincidencePart::NONE) << "nothing is felt by contacts";
    expectAlike(figures.total,
                truth(display,
                      kPlaces[0],
                      [](const auto& three)
                      {
                          Injected errors;
                          errors.eye = 0.01 / kMedianOfThree * three();
                          errors.screen = 0.003 / kMedianOfThree * three();
                          errors.ipd_m = 0.001 * three().x();
                          return errors;
                      }));
    EXPECT_EQ(figures.largest, "ipd");
}

TEST(Coincidence, WhatIsNotKnownIsUnknown)
{
    CoincidenceOptions options;
    options.airError_K = 1.0;
    options.array =
        std::make_shared<const haptics::TransducerArray>(haptics::TransducerArray::load("board"));
    CoincidenceFigures figures = coincidenceOf(options, resting({0.0, 0.0, 0.2}));
    EXPECT_EQ(figures.total.state, CoincidencePart::UNKNOWN);
    EXPECT_EQ(figures.display.state, CoincidencePart::UNKNOWN);
    EXPECT_EQ(figures.eye.state, CoincidencePart::UNKNOWN);
    EXPECT_EQ(figures.ipd.state, CoincidencePart::UNKNOWN);
    EXPECT_EQ(figures.air.state, CoincidencePart::KNOWN) << "what is known is told";
    EXPECT_EQ(figures.largest, "air");
    EXPECT_EQ(figures.unknown, "no display is known");
    options.airError_K.reset();
    options.seen.display = std::make_shared<const Display>(displaysForTwo()[1]);
    options.seen.head = displays::head(0.0);
    options.seen.lost = "the head is lost";
    options.worldToArray.translation().z() = 1e-3;
    SeenObject object = resting({0.0, 0.0, 0.15});
    object.isTouched = true;
    object.motion.isKnown = false;
    figures = coincidenceOf(options, object);
    EXPECT_EQ(figures.unknown,
              "arrayError isn't set; the head is lost; airError isn't set; its motion isn't known "
              "yet; trackerError isn't set");
    EXPECT_EQ(figures.largest, "");
    options.seen.lost.clear();
    figures = coincidenceOf(options, resting({0.0, 0.0, 0.15}));
    EXPECT_EQ(figures.unknown,
              "arrayError isn't set; the display's file has no accuracy_mm; headError isn't set; "
              "airError isn't set");
}

// Two eyes that see one picture see it in its plane.
TEST(Coincidence, WithoutStereoDepthIsThatOfThePicture)
{
    Display display = displays::window(); // at y = 0.25
    const CoincidenceFigures figures = coincidenceOf(seenBy(display), resting({0.0, 0.0, 0.15}));
    EXPECT_NEAR(figures.ipd.median_mm, 250.0, 10.0);
    display.stereo = StereoMode::LEFT_EYE;
    EXPECT_EQ(coincidenceOf(seenBy(display), resting({0.0, 0.0, 0.15})).ipd.state,
              CoincidencePart::NONE);
}

TEST(Coincidence, AnIpdThatNobodyHasMeasuredIsAnybodys)
{
    Display display = displaysForTwo()[0];
    const double measured = coincidenceOf(seenBy(display), resting(kPlaces[0])).ipd.median_mm;
    display.isIpdGiven = false;
    EXPECT_NEAR(
        coincidenceOf(seenBy(display), resting(kPlaces[0])).ipd.median_mm / measured, 3.8, 0.4);
}

} // namespace midair::bridge
