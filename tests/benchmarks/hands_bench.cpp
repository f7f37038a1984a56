// What hands cost a frame: touch against meshes of several sizes, reach, and shadows over the
// array. And how far predicted hands are off, also those of recordings.

#include "engine-bridge/hands/HandProximity.h"
#include "engine-bridge/hands/Obstacles.h"
#include "haptics/base/InputError.h"
#include "tests/benchmarks/Timing.h"
#include "tests/benchmarks/hands/Prediction.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

using namespace midair;
using Eigen::Vector3d;

namespace
{

template<class Work>
double median_us(int runs, const Work& work)
{
    return 1e3 * bench::median_ms(runs, work);
}

/// Two hands, the index fingers' tips \a height over the sphere's poles along z.
bridge::HandFrame twoHands(double height)
{
    bridge::HandFrame frame;
    const Eigen::Quaterniond down(Eigen::AngleAxisd(-M_PI / 3, Vector3d::UnitX()));
    frame.hands.push_back(bridge::openHandWithIndexTipAt(0, Vector3d(0, 0, 0.037 + height), down));
    frame.hands.push_back(bridge::openHandWithIndexTipAt(1, Vector3d(0, -0.037 - height, 0), down));
    return frame;
}

void touch()
{
    std::printf("touch: two hands of 24 bones against a sphere of 30 mm, median of 200 frames\n");
    std::printf("%10s %14s %12s %12s %12s\n",
                "triangles",
                "hierarchy/us",
                "20 mm/us",
                "3 mm/us",
                "-3 mm/us");
    for (const int rings : {10, 35, 112})
    {
        bridge::HapticObject object;
        object.mesh = sphere(0.03, rings);
        object.meshId = 1;
        const double build =
            median_us(5,
                      [&]
                      {
                          const bridge::MeshDistance distance(object.mesh.get());
                          distance.nearest({Vector3d::Zero(), Vector3d::Zero(), 0.01}, 0.001);
                      });
        std::printf("%10d %14.0f", static_cast<int>(object.mesh->triangles.cols()), build);
        for (const double height : {0.02, 0.003, -0.003})
        {
            bridge::HandProximity proximity;
            const bridge::HandFrame hands = twoHands(height);
            double time = 0.0;
            std::printf(" %12.0f",
                        median_us(200, [&] { proximity.update({object}, hands, time += 0.01); }));
        }
        std::printf("\n");
    }
}

Eigen::Matrix3Xd randomPoints(int n)
{
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    Eigen::Matrix3Xd points(3, n);
    for (int l = 0; l < n; ++l)
        points.col(l) =
            0.03 * Vector3d(normal(random), normal(random), normal(random)).normalized();
    return points;
}

void reach()
{
    std::printf(
        "\nreach: points within 20 mm of two hands\n%10s %12s %12s\n", "points", "within", "us");
    const auto capsules = bridge::handCapsules(twoHands(0.003));
    for (const int n : {100, 400, 4000})
    {
        const Eigen::Matrix3Xd points = randomPoints(n);
        std::vector<bool> within;
        const double time =
            median_us(100, [&] { within = bridge::withinReach(points, capsules, 0.02); });
        std::printf("%10d %12ld %12.0f\n", n, std::count(within.begin(), within.end(), true), time);
    }
}

void shadows()
{
    std::printf("\nshadows: two hands before the octagon's 3984 transducers\n%10s %10s %8s %12s "
                "%12s %12s\n",
                "points",
                "budget",
                "spots",
                "ways",
                "tested",
                "us");
    const haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    std::vector<bridge::Capsule> obstacles;
    for (const bridge::HandCapsule& capsule : bridge::handCapsules(twoHands(0.003)))
        obstacles.push_back(capsule.shape);
    for (const int n : {1, 100})
        for (const int budget : {5000, 20000, 100000})
        {
            bridge::ShadowOptions options;
            options.maxTests = budget;
            bridge::ShadowCounters counters;
            const Eigen::Matrix3Xd points = randomPoints(n);
            const double time = median_us(
                20, [&] { bridge::shadowGains(points, array, obstacles, options, &counters); });
            std::printf("%10d %10d %8d %12ld %12ld %12.0f\n",
                        n,
                        budget,
                        counters.spots,
                        counters.pairs,
                        counters.tested,
                        time);
        }
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app("Measures the cost of hands per frame, and the errors of predicted hands.");
    bool onlyPrediction = false;
    double ahead_ms = 50.0;
    double noise_mm = 1.0;
    std::vector<std::string> recordings;
    app.add_flag("--prediction", onlyPrediction, "measure predictions alone");
    app.add_option("--ahead", ahead_ms, "horizon in ms")->check(CLI::Range(0.0, 250.0));
    app.add_option("--noise", noise_mm, "noise that is added to recordings, mm")
        ->check(CLI::Range(0.0, 100.0));
    app.add_option("RECORDING", recordings, "recordings of hands to predict, too");
    CLI11_PARSE(app, argc, argv);
    if (!onlyPrediction)
    {
        touch();
        reach();
        shadows();
    }
    bench::printPredictions(ahead_ms);
    try
    {
        for (const std::string& recording : recordings)
            bench::printRecording(recording, ahead_ms, noise_mm);
    }
    catch (const base::InputError& error)
    {
        std::fprintf(stderr, "midair-hands-bench: %s\n", error.what());
        return 1;
    }
    return 0;
}
