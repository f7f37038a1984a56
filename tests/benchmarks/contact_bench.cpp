// midair-contact-bench: what foci that circle where a finger touches give, against the field of the
// whole object: mean radiation pressure over the patch and the turn, at full drive; and how long an
// update of contacts takes.

#include "engine-bridge/contact/ContactField.h"
#include "engine-bridge/contact/ContactTracker.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/Units.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/propagation/PressureField.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>

using namespace midair;
using Eigen::Vector3d;

namespace
{

constexpr double kObject_m = 0.03, kFinger_m = 8e-3, kDepth_m = 1.27e-3, kField_s = 1e-3;
constexpr int kContacts = 12, kPoints = 100;

/// \a n places spread evenly over a unit sphere.
Eigen::Matrix3Xd spiral(int n)
{
    Eigen::Matrix3Xd places(3, n);
    for (int i = 0; i < n; ++i)
    {
        const double z = 1.0 - (2.0 * i + 1.0) / n, angle = i * base::kPi * (3.0 - std::sqrt(5.0));
        const double r = std::sqrt(1.0 - z * z);
        places.col(i) = Vector3d(r * std::cos(angle), r * std::sin(angle), z);
    }
    return places;
}

bridge::HapticObject object()
{
    bridge::HapticObject result;
    result.id = result.meshId = 1;
    result.mesh = sphere(kObject_m, 20);
    return result;
}

/// Adds the ball of a finger that touches the object from \a way, \a depth_m deep.
void addFinger(bridge::Hand& hand, bridge::HandJointName tip, const Vector3d& way, double depth_m)
{
    for (std::size_t joint = static_cast<std::size_t>(tip) - 1; joint <= tip; ++joint)
        hand.joints[joint] = {(kObject_m + kFinger_m - depth_m) * way,
                              Eigen::Quaterniond::Identity(),
                              kFinger_m,
                              true,
                              true};
}

bridge::HandFrame finger(const Vector3d& way)
{
    bridge::HandFrame frame;
    frame.hands.resize(1);
    addFinger(frame.hands[0], bridge::INDEX_TIP, way, kDepth_m);
    return frame;
}

/// Places spread evenly over the skin that is in the object.
Eigen::Matrix3Xd skinOf(const bridge::ContactPatch& patch)
{
    constexpr int kRings = 8;
    std::vector<Vector3d> places;
    for (int i = 0; i < kRings; ++i)
        for (int j = 0; j < 6 * i + 3; ++j)
        {
            const double r = (i + 0.5) / kRings, angle = base::kTwoPi * j / (6 * i + 3);
            places.push_back(bridge::skinUnder(
                patch,
                patch.centre + r * (patch.semiMajor_m * std::cos(angle) * patch.major +
                                    patch.semiMinor_m * std::sin(angle) * patch.minor)));
        }
    return Eigen::Map<const Eigen::Matrix3Xd>(
        places.front().data(), 3, static_cast<Eigen::Index>(places.size()));
}

/// The field of the whole object, as loud as the array can.
Eigen::VectorXcf wholeObject(const haptics::TransducerArray& array)
{
    haptics::ControlPoints points;
    points.positions = kObject_m * spiral(kPoints);
    points.normals = spiral(kPoints);
    points.targets = Eigen::VectorXd::Ones(kPoints);
    Eigen::VectorXcf q;
    const auto solver = haptics::makeSolver(haptics::solverNames().front());
    const haptics::SolveReport report = solver->solve(points, array, {}, q);
    std::printf("whole object: %d points, loudness E %.3f, rms error %.3f %%\n",
                kPoints,
                report.loudness,
                100.0 * report.rms);
    return q;
}

/// Fields of one turn, \a foci of them on a circle of \a path_m.
std::vector<Eigen::VectorXcf>
turn(bridge::ContactField& field, const bridge::ContactPatch& patch, int foci, double path_m)
{
    bridge::ContactPathOptions options;
    // The number of foci and the radius are given here, not found.
    options.focusSize_m = std::clamp(patch.semiMajor_m - path_m, 0.0, 0.02);
    options.focusEach_m = foci > 1 ? base::kTwoPi * path_m / foci : 1.0;
    bridge::ContactPath path(options, patch);
    std::vector<Eigen::VectorXcf> fields;
    for (int step = 0; step < 40; ++step)
    {
        std::vector<bridge::ContactFocus> played;
        for (std::size_t j = 0; j < path.foci().size(); ++j)
            played.push_back({path.foci()[j].position,
                              1.0,
                              1,
                              static_cast<int>(j),
                              0,
                              patch.centre,
                              patch.normal});
        fields.emplace_back();
        std::string error;
        if (!field.solve(played, fields.back(), &error)) std::printf("%s\n", error.c_str());
        for (int i = 0; i < 5; ++i) // 40 times 5 ms is a turn
            path.advance(kField_s);
    }
    return fields;
}

void pressures(const haptics::TransducerArray& array)
{
    const Eigen::VectorXcf whole = wholeObject(array);
    const Eigen::Matrix3Xd ways = spiral(kContacts);
    struct Case
    {
        int foci;
        double path_m;
    };
    std::printf("mean radiation pressure over the skin in the object and the turn, over the whole "
                "object's; %d contacts, finger of %.0f mm\n%6s %8s %6s %12s %10s %10s\n",
                kContacts,
                1e3 * kFinger_m,
                "foci",
                "path/mm",
                "mask",
                "patch/mm",
                "median",
                "least");
    for (const Case& one : {Case{1, 1.4e-3}, Case{1, 3e-3}, Case{4, 3e-3}})
        for (const bool mask : {false, true})
        {
            std::vector<double> ratios;
            double radius = 0.0;
            for (int i = 0; i < kContacts; ++i)
            {
                bridge::ContactFinder finder;
                finder.update({object()}, finger(ways.col(i)));
                if (finder.patches().size() != 1) continue;
                const bridge::ContactPatch& patch = finder.patches()[0];
                bridge::ContactFieldOptions options;
                options.absolute = false;
                options.mask = mask;
                bridge::ContactField field(array, {}, options);
                const Eigen::Matrix3Xd skin = skinOf(patch);
                const auto fields = turn(field, patch, one.foci, one.path_m);
                ratios.push_back(haptics::meanSquarePressure(skin, array, {}, fields).mean() /
                                 haptics::meanSquarePressure(skin, array, {}, {whole}).mean());
                radius = std::max(radius, patch.semiMajor_m);
            }
            std::printf("%6d %8.1f %6s %12.2f %10.1f %10.1f\n",
                        one.foci,
                        1e3 * one.path_m,
                        mask ? "yes" : "no",
                        1e3 * radius,
                        bench::median(ratios),
                        ratios.empty() ? 0.0 : *std::min_element(ratios.begin(), ratios.end()));
        }
}

/// Processor time of frames of hands (finding patches) and of fields (foci and activations).
void times(const haptics::TransducerArray& array, int contacts, bool mask, int updates)
{
    const std::vector<bridge::HandJointName> tips = {
        bridge::INDEX_TIP, bridge::MIDDLE_TIP, bridge::RING_TIP, bridge::THUMB_TIP};
    bridge::ContactTracker tracker;
    bridge::ContactFieldOptions options;
    options.mask = mask;
    bridge::ContactField field(array, {}, options);
    const bridge::HapticObject touched = object();
    Eigen::VectorXcf q;
    std::vector<double> frame_ms, field_ms;
    std::size_t foci = 0;
    double frame_s = 0.0;
    for (int i = 0; i < updates + 100; ++i)
    {
        const double time = i * kField_s;
        if (time >= frame_s)
        {
            bridge::HandFrame hands;
            hands.hands.resize(1);
            for (int f = 0; f < contacts; ++f)
            {
                const double angle = 1.2 * f + 2.0 * time; // 60 mm/s
                addFinger(hands.hands[0],
                          tips[static_cast<std::size_t>(f)],
                          Vector3d(std::cos(angle), std::sin(angle), 0.0),
                          3e-3);
            }
            const double start = bench::cpu_ms();
            tracker.update({touched}, hands, time);
            frame_ms.push_back(bench::cpu_ms() - start);
            frame_s += 1.0 / 90.0;
        }
        const double start = bench::cpu_ms();
        tracker.advance(kField_s);
        field.solve(tracker.foci(), q, nullptr);
        if (i < 100) continue; // contacts begin
        field_ms.push_back(bench::cpu_ms() - start);
        foci = std::max(foci, tracker.foci().size());
    }
    std::printf("%8zu %6zu %6s %14.3f %14.3f %14.3f %14.3f\n",
                tracker.contacts().size(),
                foci,
                mask ? "yes" : "no",
                bench::median(frame_ms),
                *std::max_element(frame_ms.begin(), frame_ms.end()),
                bench::median(field_ms),
                *std::max_element(field_ms.begin(), field_ms.end()));
}

/// What the whole pipeline takes while a finger slides: frames, fields with their caps, figures.
void played(const haptics::TransducerArray& array, double maxPressure_Pa, double earLimit_dB)
{
    constexpr double kTime_s = 3.0;
    bridge::HologramOptions options;
    options.array = array;
    options.contacts.shares.render = bridge::Render::CONTACT;
    options.maxPressure = maxPressure_Pa;
    options.earLimit = earLimit_dB;
    bridge::HologramPipeline pipeline(options);
    const double begin_s = base::steadySeconds();
    double frame_s = 0.0, cpu_ms = bench::cpu_ms();
    std::uint64_t before = 0;
    for (double now_s = 0.0; now_s < kTime_s; now_s = base::steadySeconds() - begin_s)
    {
        if (now_s >= frame_s)
        {
            bridge::SceneSnapshot snapshot;
            snapshot.time_s = base::steadySeconds();
            snapshot.objects = {object()};
            snapshot.hands.hands.resize(1);
            addFinger(snapshot.hands.hands[0],
                      bridge::INDEX_TIP,
                      Vector3d(std::cos(2.0 * now_s), std::sin(2.0 * now_s), 0.0),
                      kDepth_m);
            pipeline.process(snapshot);
            frame_s = now_s + 1.0 / 60.0;
            if (before == 0) // the first one makes the solver and the mesh's tree
            {
                cpu_ms = bench::cpu_ms();
                before = pipeline.counters().contactFields;
            }
        }
        pipeline.attend();
        std::this_thread::sleep_for(std::chrono::duration<double>(
            std::min(pipeline.rest_s(), std::max(frame_s - now_s, 0.0))));
    }
    const auto fields = static_cast<double>(pipeline.counters().contactFields - before);
    std::printf("%14.0f %14.0f %12.0f %12.3f %12.1f\n",
                maxPressure_Pa,
                earLimit_dB,
                fields / kTime_s,
                (bench::cpu_ms() - cpu_ms) / fields,
                (bench::cpu_ms() - cpu_ms) / (10.0 * kTime_s));
}

void printAll(int updates)
{
    const haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    pressures(array);
    std::printf("\nprocessor time of one thread; fingers slide at 60 mm/s, 3 mm deep\n"
                "%8s %6s %6s %14s %14s %14s %14s\n",
                "contacts",
                "foci",
                "mask",
                "frame ms",
                "longest ms",
                "field ms",
                "longest ms");
    for (const bool mask : {false, true})
        for (const int contacts : {1, 4})
            times(array, contacts, mask, updates);
    std::printf("\na finger slides, 60 frames and at most 1000 fields a second: all that the "
                "pipeline does\n%14s %14s %12s %12s %12s\n",
                "MaxPressure/Pa",
                "EarLimit/dB",
                "fields/s",
                "ms a field",
                "% of a core");
    played(array, 0.0, 0.0);
    played(array, 2000.0, 0.0);
    played(array, 0.0, 110.0);
}

} // namespace

int main(int argc, char** argv)
{
    int updates = 2000;
    try
    {
        CLI::App app("Pressures and update times of foci that circle at a touching finger");
        app.add_option("--updates", updates, "fields per line of times")
            ->check(CLI::Range(10, 100000));
        CLI11_PARSE(app, argc, argv);
        printAll(updates);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-contact-bench: %s\n", error.what());
        return 2;
    }
    return 0;
}
