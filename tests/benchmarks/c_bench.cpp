// midair-c-bench: what the C interface adds to a solve, against the same solve in C++, turn by
// turn, so that both have the same machine, by the processor time of this thread.
#include "engine-bridge/pipeline/PointAssembler.h"
#include "engine-bridge/solving/ArrayLevels.h"
#include "engine-bridge/solving/OneSolve.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/surface/ObjReader.h"
#include "tests/benchmarks/Timing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <midair.h>

using namespace midair;

namespace
{

const std::string kStar = MIDAIR_ROOT "/samples/models/star.obj";

void check(midair_status status)
{
    if (status >= 0) return;
    std::fprintf(stderr, "midair-c-bench: %s\n", midair_last_error());
    std::exit(1);
}

/// Times of the same work in C++ and in C, us.
struct Pairs
{
    std::vector<double> cpp_us;
    std::vector<double> c_us;

    template<typename Cpp, typename C>
    void add(const Cpp& cpp, const C& c, bool cFirst)
    {
        for (const bool isC : {cFirst, !cFirst})
        {
            const double begin_ms = bench::cpu_ms();
            isC ? c() : cpp();
            (isC ? c_us : cpp_us).push_back(1e3 * (bench::cpu_ms() - begin_ms));
        }
    }

    void print(const char* what) const
    {
        std::vector<double> difference_us;
        for (std::size_t i = 0; i < c_us.size(); ++i)
            difference_us.push_back(c_us[i] - cpp_us[i]);
        std::sort(difference_us.begin(), difference_us.end());
        const std::size_t n = difference_us.size();
        std::printf("%-34s %9.1f %9.1f %+9.1f   %+.1f .. %+.1f\n",
                    what,
                    bench::median(cpp_us),
                    bench::median(c_us),
                    bench::median(difference_us),
                    difference_us[n / 4],
                    difference_us[3 * n / 4]);
    }
};

/// n points on a ring that turns from solve to solve.
haptics::ControlPoints ring(int n, int turn)
{
    haptics::ControlPoints points;
    points.positions.resize(3, n);
    points.normals.setZero(3, n);
    points.targets.setOnes(n);
    for (int l = 0; l < n; ++l)
    {
        const double angle = 2 * M_PI * l / n + 0.01 * turn;
        points.positions.col(l) << 0.04 * std::cos(angle), 0.0, 0.04 * std::sin(angle);
    }
    return points;
}

/// midair_solver_solve() against HologramSolver::solve(): warm starts.
void benchSolver(midair_array* array, midair_scene* scene, int n, int repeats)
{
    haptics::TransducerArray octagon = haptics::TransducerArray::load("octagon");
    bridge::keepToSignal(octagon.drive);
    const haptics::Medium air;
    const auto solver = haptics::makeSolver(haptics::solverNames().front(), {});
    midair_solver* handle = nullptr;
    check(midair_solver_open(scene, &handle));
    std::size_t m = 0;
    check(midair_array_size(array, &m));
    std::vector<float> ofC(2 * m);
    Eigen::VectorXcf ofCpp;
    Pairs pairs;
    for (int k = 0; k < repeats; ++k)
    {
        const haptics::ControlPoints points = ring(n, k);
        pairs.add([&] { solver->solve(points, octagon, air, ofCpp); },
                  [&]
                  {
                      check(midair_solver_solve(handle,
                                                points.positions.data(),
                                                points.targets.data(),
                                                static_cast<std::size_t>(n),
                                                0,
                                                ofC.data(),
                                                m));
                  },
                  k % 2 == 0);
        const auto* q = reinterpret_cast<const std::complex<float>*>(ofC.data());
        if (!std::equal(q, q + m, ofCpp.data()))
        {
            std::fprintf(stderr, "midair-c-bench: C and C++ find other fields\n");
            std::exit(1);
        }
    }
    check(midair_solver_close(handle));
    pairs.print(("solver, " + std::to_string(n) + " points, warm").c_str());
}

/// The parts of midair_solve() in C++.
Eigen::VectorXcf solveOnce(const haptics::TransducerArray& array,
                           const bridge::SceneSnapshot& snapshot)
{
    base::MessageLog messages;
    const haptics::Medium air;
    haptics::FieldSettings settings;
    settings.maxPoints = 2000;
    bridge::PointAssembler::Options options;
    options.wavelength_m = air.wavelength(array.frequency_Hz);
    options.maxPoints = settings.maxPoints;
    bridge::PointAssembler assembler(array, options, messages);
    bridge::SolveTask task{array, air, settings};
    task.sets = {assembler.assemble(snapshot).points};
    task.sets.front().identity.clear();
    bridge::SolvedFields solved = bridge::solveOnce(task);
    haptics::rateRinging(solved.sequence, array.ringing_s);
    return solved.sequence.fields.front();
}

/// midair_solve() of what is in \a scene against the same of \a mesh in C++: each one cold.
void benchScene(const char* what,
                const char* name,
                midair_scene* scene,
                haptics::TriangleMesh mesh,
                haptics::Sampling sampling,
                int repeats)
{
    haptics::TransducerArray array = haptics::TransducerArray::load(name);
    bridge::keepToSignal(array.drive);
    bridge::SceneSnapshot snapshot;
    bridge::HapticObject& object = snapshot.objects.emplace_back();
    object.id = 1;
    object.meshId = 1;
    object.mesh = std::make_shared<const haptics::TriangleMesh>(std::move(mesh));
    object.properties.sampling = sampling;
    Eigen::VectorXcf ofCpp;
    std::vector<float> ofC(2 * static_cast<std::size_t>(array.size()));
    Pairs pairs;
    for (int k = 0; k < repeats; ++k)
        pairs.add([&] { ofCpp = solveOnce(array, snapshot); },
                  [&]
                  {
                      midair_field* field = nullptr;
                      check(midair_solve(scene, &field));
                      check(midair_field_activations(field, 0, ofC.data(), ofC.size() / 2));
                      check(midair_field_close(field));
                  },
                  k % 2 == 0);
    const auto* q = reinterpret_cast<const std::complex<float>*>(ofC.data());
    if (!std::equal(q, q + ofCpp.size(), ofCpp.data()))
    {
        std::fprintf(stderr, "midair-c-bench: C and C++ find other fields\n");
        std::exit(1);
    }
    pairs.print(what);
}

void benchScenes(midair_scene* octagon, int repeats)
{
    midair_array* array = nullptr;
    midair_scene* board = nullptr;
    midair_object object = 0;
    check(midair_array_load("board", &array));
    check(midair_scene_make(array, &board));
    haptics::TriangleMesh point;
    point.vertices = Eigen::Vector3d(0.0, 0.0, 0.15);
    point.triangles = Eigen::Vector3i::Zero();
    check(midair_add_points(board, point.vertices.data(), nullptr, 1, 0, &object));
    benchScene(
        "scene, a point over 249, cold", "board", board, point, haptics::Sampling::POINTS, repeats);
    check(midair_scene_close(board));
    check(midair_array_close(array));
    check(midair_add_file(octagon, kStar.c_str(), 0.08, &object));
    benchScene("scene, the star, cold",
               "octagon",
               octagon,
               haptics::readObj(kStar).scaledTo(0.08),
               haptics::Sampling::SURFACE,
               std::max(4, repeats / 4));
}

/// All figures of one field after the other: the first asks what listens round the array.
void benchFigures(midair_scene* scene)
{
    std::vector<double> times_ms;
    for (int k = 0; k < 8; ++k)
    {
        midair_field* field = nullptr;
        double level_dB = 0.0;
        check(midair_solve(scene, &field));
        const double begin_ms = bench::cpu_ms();
        check(midair_field_figure(field, "exposure.level_dB", &level_dB));
        times_ms.push_back(bench::cpu_ms() - begin_ms);
        check(midair_field_close(field));
    }
    std::printf("figures of a field: %.2f ms of the first, then %.2f ms\n",
                times_ms.front(),
                bench::median({times_ms.begin() + 1, times_ms.end()}));
}

/// What a call costs that does nothing but look a handle up.
void benchCalls(midair_scene* scene)
{
    constexpr int kCalls = 200000;
    midair_array* array = nullptr;
    check(midair_array_load("board", &array));
    std::size_t size = 0;
    double begin_ms = bench::cpu_ms();
    for (int k = 0; k < kCalls; ++k)
        check(midair_array_size(array, &size));
    std::printf("a call: %.3f us", 1e3 * (bench::cpu_ms() - begin_ms) / kCalls);
    begin_ms = bench::cpu_ms();
    for (int k = 0; k < kCalls / 10; ++k)
        check(midair_set(scene, "temperature", "20"));
    std::printf(", a setting: %.2f us", 1e4 * (bench::cpu_ms() - begin_ms) / kCalls);
    check(midair_array_close(array));
    begin_ms = bench::cpu_ms();
    for (int k = 0; k < kCalls / 10; ++k)
        midair_array_size(array, &size);
    std::printf(", an error: %.2f us\n", 1e4 * (bench::cpu_ms() - begin_ms) / kCalls);
}

} // namespace

int main(int argc, char** argv)
{
    int repeats = 200;
    CLI::App app(
        "Measures the overhead of the C interface in a solve: medians of processor time, us");
    app.add_option("--repeats", repeats, "pairs of solves")->check(CLI::Range(4, 100000));
    CLI11_PARSE(app, argc, argv);
    midair_array* array = nullptr;
    midair_scene* scene = nullptr;
    check(midair_array_load("octagon", &array));
    check(midair_scene_make(array, &scene));
    std::printf(
        "octagon, 3984 transducers; %d pairs   C++/us      C/us    C adds   its quartiles\n",
        repeats);
    for (const int n : {1, 11, 40})
        benchSolver(array, scene, n, repeats);
    benchScenes(scene, repeats);
    benchFigures(scene);
    benchCalls(scene);
    check(midair_scene_close(scene));
    check(midair_array_close(array));
    return 0;
}
