// midair-touching-bench: a ball that rolls over a plate, touching it and lifted off it. Where the
// two touch, points of one are too near those of the other, so the set of points changes from
// update to update. Times of updates on one core, and how exact they are.

#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/Units.h"
#include "tests/benchmarks/Timing.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/haptics/surface/SampleMeshes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include <CLI/CLI.hpp>

using midair::bench::cpu_ms;

namespace
{

constexpr double kRadius_m = 0.025, kPlate_m = 0.13, kLift_m = 0.02;
constexpr double kSpeed_m_s = 0.2, kFrames_Hz = 60.0;

midair::bridge::SceneSnapshot ballOnPlate()
{
    midair::bridge::SceneSnapshot snapshot;
    snapshot.objects.resize(2);
    midair::bridge::HapticObject &plate = snapshot.objects[0], &ball = snapshot.objects[1];
    plate.id = plate.meshId = 1;
    plate.path = "plate";
    plate.mesh = squareMesh(kPlate_m);
    plate.pose.translation().y() = -0.02;
    ball.id = ball.meshId = 2;
    ball.path = "ball";
    ball.mesh = std::make_shared<const midair::haptics::TriangleMesh>(
        midair::haptics::test::sphere(kRadius_m, 4));
    return snapshot;
}

/// Rolls the ball \a gap_m above the plate; prints what the updates took. Returns the median, ms.
double roll(const char* name, double gap_m, int updates)
{
    midair::bridge::HologramOptions options;
    options.array = midair::haptics::TransducerArray::octagonalPrism();
    options.deviceUri = "null:";
    midair::bridge::HologramPipeline pipeline(options);
    midair::bridge::SceneSnapshot snapshot = ballOnPlate();
    constexpr double kCircle_m = 0.03;
    std::vector<double> times_ms;
    double worstRms = 0.0, sumRms = 0.0;
    int changes = 0, last = 0;
    for (int i = 0; i <= updates; ++i)
    {
        const double angle = i * kSpeed_m_s / kFrames_Hz / kCircle_m;
        snapshot.frame = static_cast<std::uint64_t>(i);
        snapshot.objects[1].pose.translation() =
            Eigen::Vector3d(kCircle_m * std::cos(angle),
                            snapshot.objects[0].pose.translation().y() + kRadius_m + gap_m,
                            kCircle_m * std::sin(angle));
        const double start_ms = cpu_ms();
        const auto result = pipeline.process(snapshot);
        if (i == 0) continue; // the first field starts from nothing
        times_ms.push_back(cpu_ms() - start_ms);
        worstRms = std::max(worstRms, result->report().rms);
        sumRms += result->report().rms;
        changes += result->report().points != last;
        last = result->report().points;
    }
    const double median_ms = midair::bench::median(times_ms);
    std::sort(times_ms.begin(), times_ms.end());
    std::printf("%-9s %4d points: median %6.2f ms, p99 %6.2f ms, longest %6.2f ms; rms %.4f %%, "
                "at worst %.4f %%; another number of points in %d of %d\n",
                name,
                last,
                median_ms,
                times_ms[times_ms.size() * 99 / 100],
                times_ms.back(),
                100.0 * sumRms / updates,
                100.0 * worstRms,
                changes,
                updates);
    return median_ms;
}

} // namespace

int main(int argc, char** argv)
{
    int updates = 600;
    CLI::App app("A ball that touches a plate: times of updates on one core");
    app.add_option("--updates", updates, "for each line")->check(CLI::Range(10, 100000));
    CLI11_PARSE(app, argc, argv);
    const double lifted_ms = roll("lifted", kLift_m, updates);
    const double touching_ms = roll("touching", 0.0, updates);
    std::printf("touching takes %.2f times as long as lifted\n", touching_ms / lifted_ms);
    return 0;
}
