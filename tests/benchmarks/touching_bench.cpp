// midair-touching-bench: a ball that rolls over a plate, touching it and lifted off it. Where the
// two touch, points of one are too near those of the other, so the set of points changes from
// update to update. Times of updates on one core, and how exact they are.

#include "haptics/base/Units.h"
#include "tests/benchmarks/Updates.h"
#include "tests/engine-bridge/pipeline/Fakes.h"
#include "tests/haptics/surface/SampleMeshes.h"

#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include <CLI/CLI.hpp>

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
    midair::bridge::SceneSnapshot snapshot = ballOnPlate();
    constexpr double kCircle_m = 0.03;
    return midair::bench::timeUpdates(
        name,
        updates,
        snapshot,
        [&](int i)
        {
            const double angle = i * kSpeed_m_s / kFrames_Hz / kCircle_m;
            snapshot.objects[1].pose.translation() =
                Eigen::Vector3d(kCircle_m * std::cos(angle),
                                snapshot.objects[0].pose.translation().y() + kRadius_m + gap_m,
                                kCircle_m * std::sin(angle));
        });
}

} // namespace

int main(int argc, char** argv)
{
    int updates = 600;
    CLI::App app("Times updates of a ball that touches a plate, on one core");
    app.add_option("--updates", updates, "updates per line")->check(CLI::Range(10, 100000));
    CLI11_PARSE(app, argc, argv);
    const double lifted_ms = roll("lifted", kLift_m, updates);
    const double touching_ms = roll("touching", 0.0, updates);
    std::printf("touching takes %.2f times as long as lifted\n", touching_ms / lifted_ms);
    return 0;
}
