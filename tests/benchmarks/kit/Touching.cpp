#include "tests/benchmarks/kit/Touching.h"

#include "engine-bridge/hands/HandProximity.h"
#include "tests/benchmarks/Timing.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>
#include <vector>

namespace midair::bench
{

namespace
{

using bridge::HapticObject;
using bridge::SharedMesh;
using Eigen::Vector3d;

constexpr int kSide = 256; // vertices
constexpr double kEdge_m = 0.2;
constexpr int kFrames = 120;

/// A cloth of 200 mm with waves of 2 mm, which run on with \a phase.
haptics::TriangleMesh cloth(double phase)
{
    haptics::TriangleMesh mesh;
    mesh.vertices.resize(3, kSide * kSide);
    mesh.triangles.resize(3, 2 * (kSide - 1) * (kSide - 1));
    for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i)
            mesh.vertices.col(j * kSide + i) =
                Vector3d(kEdge_m * (i / (kSide - 1.0) - 0.5),
                         kEdge_m * (j / (kSide - 1.0) - 0.5),
                         2e-3 * std::sin(phase + 0.1 * i) * std::cos(0.07 * j));
    int t = 0;
    for (int j = 0; j + 1 < kSide; ++j)
        for (int i = 0; i + 1 < kSide; ++i)
        {
            const int corner = j * kSide + i;
            mesh.triangles.col(t++) = Eigen::Vector3i(corner, corner + 1, corner + kSide + 1);
            mesh.triangles.col(t++) = Eigen::Vector3i(corner, corner + kSide + 1, corner + kSide);
        }
    return mesh;
}

/// Two hands, palms down, the index fingers' tips \a height_m over the cloth.
bridge::HandFrame twoHands(double height_m)
{
    const Eigen::Quaterniond palmDown(Eigen::AngleAxisd(M_PI / 2.0, Vector3d::UnitX()));
    bridge::HandFrame frame;
    for (const int id : {0, 1})
        frame.hands.push_back(bridge::openHandWithIndexTipAt(
            id, Vector3d(id - 0.5, 0.0, 10.0 * height_m) * 0.1, palmDown));
    return frame;
}

/// Runs frames at 60 a second and prints the times of touch in them.
void touch(const char* what, double height_m, bool deforms)
{
    HapticObject object;
    object.id = object.meshId = object.topologyId = 1;
    constexpr std::size_t kBytes = 12UL * kSide * kSide;
    object.mesh = SharedMesh::later([] { return cloth(0.0); }, kBytes);
    const bridge::HandFrame hands = twoHands(height_m);
    bridge::HandProximity proximity;
    std::vector<double> times;
    std::size_t contacts = 0;
    auto next = std::chrono::steady_clock::now();
    for (int frame = 0; frame < kFrames + 30; ++frame)
    {
        if (deforms)
        {
            ++object.meshId;
            object.mesh = SharedMesh::later([frame] { return cloth(0.1 * frame); }, kBytes);
        }
        const double start_us = midair::bench::cpu_us();
        proximity.update({object}, hands, 0.017 * frame);
        if (frame >= 30) times.push_back(midair::bench::cpu_us() - start_us);
        contacts = std::max(contacts, proximity.contacts().size());
        next += std::chrono::microseconds(16667);
        std::this_thread::sleep_until(next);
    }
    std::sort(times.begin(), times.end());
    std::printf("touch, cloth of %d vertices, %s, hands at %3.0f mm: median %7.0f us, p99 %7.0f us "
                "a frame; %zu contacts\n",
                kSide * kSide,
                what,
                1e3 * height_m,
                times[times.size() / 2],
                times[times.size() * 99 / 100],
                contacts);
}

} // namespace

void printTouching()
{
    for (const double height_m : {0.02, 0.003, -0.003})
    {
        touch("still", height_m, false);
        touch("deforming", height_m, true);
    }
}

} // namespace midair::bench
