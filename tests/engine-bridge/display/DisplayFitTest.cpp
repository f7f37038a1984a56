#include "engine-bridge/display/DisplayFit.h"

#include "engine-bridge/display/Picture.h"
#include "haptics/base/InputError.h"
#include "tests/engine-bridge/display/CrossSimulation.h"

#include <algorithm>
#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace
{

using namespace midair::bridge;
using Eigen::Vector3d;

double share(std::vector<double> values, double of)
{
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(of * static_cast<double>(values.size() - 1))];
}

void expectNear(const std::vector<double>& errors_m, double median_mm, double most_mm)
{
    EXPECT_NEAR(1e3 * share(errors_m, 0.5), median_mm, 0.2 * median_mm);
    EXPECT_NEAR(1e3 * share(errors_m, 0.95), most_mm, 0.2 * most_mm);
}

} // namespace

TEST(DisplayFit, FindsEachScreenThroughItsOptics)
{
    for (const auto& [name, truth] : displays::all())
    {
        CrossSimulation simulation(truth, 1);
        const DisplayFit fit = fitTouches(guessedDisplay(truth), simulation.touches(0.0));
        EXPECT_TRUE(fit.usable) << name << ": " << fit.text();
        EXPECT_LT((fit.display.lowerLeft - truth.lowerLeft).norm(), 2e-6) << name;
        EXPECT_LT((fit.display.lowerRight - truth.lowerRight).norm(), 2e-6) << name;
        EXPECT_LT((fit.display.upperLeft - truth.upperLeft).norm(), 2e-6) << name;
        const DisplayFit sights = fitSights(guessedDisplay(truth),
                                            simulation.sights(simulation.heads(3, 0.12), 0.3, 0.0));
        EXPECT_TRUE(sights.usable) << name << ": " << sights.text();
        EXPECT_LT((sights.display.lowerLeft - truth.lowerLeft).norm(), 1e-5) << name;
    }
}

// Median (95 %) of the picture's middle, as prototypes of these methods had them.
TEST(DisplayFit, TouchesAreAsGoodAsTheTrackerAllows)
{
    const double expected[][3] = {{1e-3, 0.4, 0.8}, {2e-3, 0.9, 1.6}, {5e-3, 2.2, 4.1}};
    for (const auto& [sigma_m, median_mm, most_mm] : expected)
    {
        CrossSimulation simulation(displays::halfMirror(), 3);
        expectNear(simulation.errors(300,
                                     [noise_m = sigma_m](CrossSimulation& sim) {
                                         return fitTouches(guessedDisplay(displays::halfMirror()),
                                                           sim.touches(noise_m));
                                     }),
                   median_mm,
                   most_mm);
    }
}

TEST(DisplayFit, SightsFromThreePlacesAreGoodForScreensOutOfReach)
{
    CrossSimulation simulation(displays::window(), 3);
    expectNear(simulation.errors(300,
                                 [](CrossSimulation& sim)
                                 {
                                     return fitSights(guessedDisplay(displays::window()),
                                                      sim.sights(sim.heads(3, 0.2),
                                                                 kSightReach_m,
                                                                 kSightNoise_m));
                                 }),
               1.9,
               4.3);
}

TEST(DisplayFit, SightsFromSixPlacesFindTheEyeAsWell)
{
    CrossSimulation simulation(displays::window(), 3);
    DisplayFitOptions options;
    options.fitsEye = true;
    std::vector<double> eyes;
    expectNear(
        simulation.errors(300,
                          [&](CrossSimulation& sim)
                          {
                              const Vector3d off = 0.01 * sim.noise(1.0).normalized();
                              const DisplayFit fit = fitSights(
                                  guessedDisplay(displays::window()),
                                  sim.sights(sim.heads(6, 0.15), kSightReach_m, kSightNoise_m, off),
                                  options);
                              eyes.push_back((fit.eyeOffset - off).norm());
                              return fit;
                          }),
        2.2,
        5.3);
    EXPECT_LT(share(eyes, 0.5), 4e-3);
}

TEST(DisplayFit, ThePredictedErrorIsTheErrorThatItHas)
{
    CrossSimulation simulation(displays::plate(), 5);
    std::vector<double> errors, medians, most;
    for (int i = 0; i < 300; ++i)
    {
        DisplayFitOptions options;
        options.edge_m = 1e-4;
        const DisplayFit fit =
            fitTouches(guessedDisplay(displays::plate()), simulation.touches(2e-3), options);
        errors.push_back((fit.middle() - simulation.middle()).norm());
        medians.push_back(fit.errorMedian_m);
        most.push_back(fit.error95_m);
    }
    EXPECT_NEAR(share(medians, 0.5), share(errors, 0.5), 0.1 * share(errors, 0.5));
    EXPECT_NEAR(share(most, 0.5), share(errors, 0.95), 0.15 * share(errors, 0.95));
}

TEST(DisplayFit, OneTouchThatWasWrongIsLeftOutByName)
{
    CrossSimulation simulation(displays::halfMirror(), 7);
    auto touches = simulation.touches(1e-3);
    touches[4].tip.z() += 0.05;
    const DisplayFit fit = fitTouches(guessedDisplay(displays::halfMirror()), touches);
    EXPECT_TRUE(fit.usable);
    EXPECT_NE(fit.text().find("calibrated from 11 of 12 touched crosses\n"), std::string::npos)
        << fit.text();
    EXPECT_NE(fit.text().find("note: left out: cross 5\n"), std::string::npos) << fit.text();
    EXPECT_LT((fit.middle() - simulation.middle()).norm(), 2e-3);
}

TEST(DisplayFit, RefusesByNameWhatLeavesThePlaceOpen)
{
    CrossSimulation simulation(displays::window(), 9);
    const auto problemOf = [](const DisplayFit& fit)
    {
        EXPECT_FALSE(fit.usable);
        return fit.problems.empty() ? std::string() : fit.problems.front();
    };
    auto line = simulation.touches(1e-3);
    line.resize(4); // the upper row
    EXPECT_EQ(problemOf(fitTouches(displays::window(), line)),
              "the crosses lie on one line, so the rotation about it is undetermined: touch "
              "crosses of all rows and columns");
    EXPECT_EQ(
        problemOf(fitTouches(displays::window(), {line[0], line[1], line[0]})),
        "2 different crosses; touch at least three that are not on one line, better all twelve");
    EXPECT_EQ(
        problemOf(fitSights(displays::window(),
                            simulation.sights(simulation.heads(1, 0.12), kSightReach_m, 1e-3))),
        "the head was at one place, but at least three are needed, 0.1 m apart, to find the "
        "picture's distance");
    EXPECT_EQ(
        problemOf(fitSights(displays::window(),
                            simulation.sights(simulation.heads(2, 0.12), kSightReach_m, 1e-3))),
        "the head was at 2 places, but at least three are needed, 0.1 m apart, to find the "
        "picture's distance");
}

TEST(DisplayFit, RefusesMirroredCrossesAWrongSizeAndALargeError)
{
    CrossSimulation simulation(displays::halfMirror(), 9);
    auto mirrored = simulation.touches(1e-3);
    for (CrossTouch& touch : mirrored)
        touch.cross = touch.cross / 4 * 4 + 3 - touch.cross % 4;
    const DisplayFit turned = fitTouches(displays::halfMirror(), mirrored);
    EXPECT_FALSE(turned.usable);
    EXPECT_NE(turned.text().find("crosses are mirrored, left and right or upper and lower ones "
                                 "exchanged"),
              std::string::npos)
        << turned.text();

    Display small = displays::halfMirror();
    small.lowerRight = small.lowerLeft + 0.9 * (small.lowerRight - small.lowerLeft);
    small.upperLeft = small.lowerLeft + 0.9 * (small.upperLeft - small.lowerLeft);
    const DisplayFit size = fitTouches(small, simulation.touches(1e-3));
    EXPECT_FALSE(size.usable);
    EXPECT_NE(size.text().find("times as far apart as on a picture of 0.468 x 0.270 m, which the "
                               "file says"),
              std::string::npos)
        << size.text();

    const DisplayFit noisy = fitTouches(displays::halfMirror(), simulation.touches(20e-3));
    EXPECT_FALSE(noisy.usable);
    EXPECT_NE(noisy.text().find("is over 5.0 mm: take more"), std::string::npos) << noisy.text();
}

TEST(DisplayFit, ReadsWhatItWrites)
{
    CrossSimulation simulation(displays::window(), 2);
    for (const bool areSights : {false, true})
    {
        const auto touches = simulation.sights({simulation.head(0.1)}, 0.4, 1e-3);
        std::string text = "cross,x,y,z\n";
        for (const CrossTouch& touch : touches)
            text += touchLine(touch, areSights);
        std::istringstream in(text);
        const auto read = readTouches(in, "file", areSights);
        ASSERT_EQ(read.size(), touches.size());
        EXPECT_EQ(read[7].cross, touches[7].cross);
        EXPECT_LT((read[7].tip - touches[7].tip).norm(), 2e-5);
        EXPECT_TRUE(!areSights || read[7].head.isApprox(touches[7].head, 1e-4));
    }
    const auto errorOf = [](const std::string& text)
    {
        std::istringstream in(text);
        try
        {
            readTouches(in, "t.csv", false);
        }
        catch (const midair::base::InputError& error)
        {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_EQ(errorOf("1,0,0,0\n13,0,0,0\n"),
              "t.csv, line 2: \"13\" is not a cross; crosses are 1 .. 12");
    EXPECT_EQ(errorOf("1,0,0\n"),
              "t.csv, line 1: 3 columns; a touch has four: cross, x, y, z of the fingertip");
    EXPECT_EQ(errorOf("1,0,nan,0\n"), "t.csv, line 1: \"nan\" in column 3 is not a finite number");
}

TEST(DisplayFit, AFileKeepsAllButItsCorners)
{
    const std::string text = R"({"about": "mine", "screen": {"lowerLeft_m": [0, 0, 0],
        "lowerRight_m": [0.4, 0, 0], "upperLeft_m": [0, 0, 0.3], "upperRight_m": [0.4, 0, 0.3],
        "pixels": [800, 600]}, "eye": "osc:", "stereo": "anaglyph"})";
    Display moved = readDisplay(text, "f");
    for (Vector3d* corner : {&moved.lowerLeft, &moved.lowerRight, &moved.upperLeft})
        *corner += Vector3d(0.1, 0.2, -0.3);
    const std::string written = withScreen(text, "f", moved);
    const Display read = readDisplay(written, "f");
    EXPECT_LT((read.lowerRight - Vector3d(0.5, 0.2, -0.3)).norm(), 1e-6);
    EXPECT_EQ(read.eye, "osc:");
    EXPECT_EQ(read.stereo, StereoMode::ANAGLYPH);
    EXPECT_NE(written.find("\"about\": \"mine\""), std::string::npos);
}
