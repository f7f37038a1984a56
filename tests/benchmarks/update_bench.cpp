// midair-update-bench: what a frame costs the hologram's thread, where something changes that the
// field doesn't depend on, and where the field has to be solved again: processor time of this
// thread, and how many fields the device was sent. With --objects, what update() costs the thread
// of a program's own loop.
#include "device/drive/DriveEncoder.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "tests/benchmarks/Timing.h"
#include "tests/benchmarks/update/Frames.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <exception>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

using namespace midair;
using namespace midair::bridge;

namespace
{

constexpr double kNotBinding_Pa = 1e5;

/// Takes fields and does nothing, so that what is timed is the thread that makes them.
class CountingDevice : public device::ArrayDevice
{
public:
    explicit CountingDevice(long& sends, int transducers) :
        _sends(sends),
        _played(static_cast<std::size_t>(transducers))
    {
    }
    bool send(const device::DriveSignal& signal) override
    {
        ++_sends;
        device::decode(signal, _played);
        return true;
    }
    void silence() override { std::fill(_played.begin(), _played.end(), 0.0f); }
    std::string status() const override { return "counts"; }
    device::DeviceReport report() const override { return {}; }
    std::vector<std::complex<float>> played() const override { return _played; }

private:
    long& _sends;
    std::vector<std::complex<float>> _played;
};

HapticObject objectOf(std::uint64_t id, std::shared_ptr<const haptics::TriangleMesh> mesh)
{
    HapticObject object;
    object.id = id;
    object.path = "Scene/" + std::to_string(id);
    object.meshId = id;
    object.topologyId = id;
    object.mesh = std::move(mesh);
    return object;
}

/// A sphere of about 110 points in the middle of the octagon.
SceneSnapshot scene()
{
    SceneSnapshot snapshot;
    snapshot.objects.push_back(objectOf(1, sphere(0.031, 12)));
    return snapshot;
}

std::string processor()
{
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
    return "unknown processor";
}

/// Times \a change, which is made to the snapshot before each frame.
struct Row
{
    const char* name;
    double cap_Pa;
    std::function<void(SceneSnapshot&, int)> change;
    bool isOtherAir = false; ///< 0.1 K more, by other options, before each frame
};

void time(const Row& row, int frames)
{
    long sends = 0;
    HologramOptions options;
    options.array = haptics::TransducerArray::octagonalPrism();
    options.maxPressure = row.cap_Pa;
    options.deviceFactory = [&sends](const std::string&, const device::DeviceLayout& layout)
    { return std::make_unique<CountingDevice>(sends, layout.transducers); };
    HologramPipeline pipeline(options);
    SceneSnapshot snapshot = scene();
    row.change(snapshot, 0);
    pipeline.process(snapshot);
    std::vector<double> times_ms, solves_ms;
    const long before = sends;
    std::shared_ptr<const HologramResult> result;
    for (int frame = 1; frame <= frames; ++frame)
    {
        row.change(snapshot, frame);
        if (row.isOtherAir) options.medium.temperature_C += frame % 2 == 0 ? 0.1 : -0.1;
        const double begin_ms = bench::cpu_ms();
        if (row.isOtherAir) pipeline.reconfigure(options);
        result = pipeline.process(snapshot);
        times_ms.push_back(bench::cpu_ms() - begin_ms);
        solves_ms.push_back(result->report().matrix_ms + result->report().solve_ms);
    }
    std::printf("%-42s %4d %8.3f %8.3f %10.3f %7.2f\n",
                row.name,
                static_cast<int>(result->points.size()),
                *std::min_element(times_ms.begin(), times_ms.end()),
                bench::median(times_ms),
                bench::median(solves_ms),
                static_cast<double>(sends - before) / frames);
}

/// A hand of twenty bones, its middle at \a x_m.
std::vector<HandCapsule> handAt(double x_m)
{
    std::vector<HandCapsule> hand;
    for (int bone = 0; bone < 20; ++bone)
    {
        const int row = bone / 5;
        HandCapsule one;
        one.bone = bone;
        one.shape.a = Eigen::Vector3d(x_m + 0.01 * (bone % 5), 0.02 * row, 0.0);
        one.shape.b = one.shape.a + Eigen::Vector3d(0.0, 0.02, 0.0);
        one.shape.radius_m = 0.008;
        hand.push_back(one);
    }
    return hand;
}

std::vector<Row> allRows()
{
    const auto still = [](SceneSnapshot&, int) {};
    const auto farMoves = [](SceneSnapshot& s, int frame)
    {
        if (s.objects.size() < 2) s.objects.push_back(objectOf(2, sphere(0.02, 8)));
        s.objects[1].pose.translation() << 3.0 + 1e-3 * frame, 0.0, 0.0;
    };
    const auto moves = [](SceneSnapshot& s, int frame)
    { s.objects[0].pose.translation() << 0.01 * std::sin(0.1 * frame), 0.0, 0.0; };
    return {
        {"still", 0.0, still},
        {"what is 3 m away moves", 0.0, farMoves},
        {"the same, a cap that doesn't bind", kNotBinding_Pa, farMoves},
        {"another priority",
         0.0,
         [](SceneSnapshot& s, int frame) { s.objects[0].properties.priority = frame % 2; }},
        {"another material, where it is felt as a whole",
         0.0,
         [](SceneSnapshot& s, int frame)
         { s.objects[0].properties.material.mostForce_N = 0.1 + 0.01 * (frame % 2); }},
        {"the same vertices again",
         0.0,
         [](SceneSnapshot& s, int frame)
         { s.objects[0].meshId = 10 + static_cast<std::uint64_t>(frame); }},
        {"a far hand with shadows moves",
         0.0,
         [](SceneSnapshot& s, int frame)
         {
             s.around.shadows = true;
             s.around.hands = handAt(3.0 + 1e-2 * frame);
         }},
        {"an update", 0.0, moves},
        {"an update under a cap that doesn't bind", kNotBinding_Pa, moves},
        {"an update under a cap that binds", 300.0, moves},
        {"0.1 K of air", 0.0, still, true},
    };
}

/// The row called \a only, or all whose name has this in it.
void timeRows(int frames, const std::string& only)
{
    const std::vector<Row> rows = allRows();
    std::printf("%s; octagon, %d frames\n%-42s %4s %8s %8s %10s %7s\n",
                processor().c_str(),
                frames,
                "",
                "n",
                "least/ms",
                "median",
                "solve/ms",
                "sends");
    const bool isName =
        std::any_of(rows.begin(), rows.end(), [&](const Row& row) { return row.name == only; });
    for (const Row& row : rows)
        if (isName ? row.name == only : std::string(row.name).find(only) != std::string::npos)
            time(row, frames);
}

int run(int argc, char** argv)
{
    int frames = 200;
    int objects = 0;
    std::string only;
    CLI::App app("Measures the cost of a frame on the hologram thread, ms of processor time");
    app.add_option("--frames", frames, "frames per row")->check(CLI::Range(2, 100000));
    app.add_option("--only", only, "the row with this name, or all rows whose names contain it");
    app.add_option(
           "--objects",
           objects,
           "number of new, moving and resting objects in a separate loop, instead of the rows")
        ->check(CLI::Range(1, 100000));
    CLI11_PARSE(app, argc, argv);
    if (objects > 0)
        bench::printFrames(objects);
    else
        timeRows(frames, only);
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    try
    {
        return run(argc, argv);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-update-bench: %s\n", error.what());
        return 1;
    }
}
