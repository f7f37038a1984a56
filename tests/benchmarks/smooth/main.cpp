// How smooth outlines and surfaces can be made, and at what loudness: tables of what is asked and
// what is reached.
#include "haptics/base/simd/InstructionSet.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "haptics/sequence/FieldOrder.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/solvers/dense/OutlineHologram.h"
#include "haptics/surface/SurfaceSampler.h"
#include "tests/benchmarks/smooth/Patches.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

namespace
{

using namespace midair::haptics;

struct Cell
{
    std::string name;
    std::vector<Outline> outlines;
    double asked; // largest coefficient of variation; 0: as low as it goes
};

Eigen::Vector3d tilted(double degrees)
{
    const double t = degrees * M_PI / 180.0;
    return {0.0, std::cos(t), std::sin(t)};
}

Outline star(double radius_m)
{
    Outline outline;
    outline.closed = true;
    outline.vertices.resize(3, 10);
    for (int k = 0; k < 10; ++k)
    {
        const double r = k % 2 == 0 ? radius_m : 0.382 * radius_m;
        outline.vertices.col(k) =
            r * Eigen::Vector3d(std::sin(k * M_PI / 5.0), 0.0, std::cos(k * M_PI / 5.0));
    }
    return outline;
}

std::vector<Cell> outlineCells(bool quick)
{
    std::vector<Cell> cells;
    for (const double diameter_mm : {34.0, 100.0})
        for (const double off_mm : {0.0, 25.0})
            for (const double tilt : {0.0, 30.0, 60.0, 90.0})
            {
                if (quick && (diameter_mm > 50.0 || off_mm > 0.0)) continue;
                char name[80];
                std::snprintf(name,
                              sizeof name,
                              "circle %.0f mm, tilt %.0f, off %.0f mm",
                              diameter_mm,
                              tilt,
                              off_mm);
                const double asked =
                    tilt == 0.0 && off_mm == 0.0 ? 0.06 : (diameter_mm < 50.0 ? 0.2 : 0.4);
                cells.push_back(
                    {name,
                     {Outline::circle(
                         Eigen::Vector3d(off_mm * 1e-3, 0, 0), diameter_mm * 1e-3, tilted(tilt))},
                     asked});
            }
    const Eigen::Vector3d axes[] = {
        Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d(1, 1, 0).normalized()};
    const char* names[] = {"across", "along", "oblique"};
    for (const double length_mm : {34.0, 100.0})
        for (int k = 0; k < (quick ? 1 : 3); ++k)
        {
            char name[80];
            std::snprintf(name, sizeof name, "line %.0f mm, %s", length_mm, names[k]);
            const Eigen::Vector3d half = 0.5e-3 * length_mm * axes[k];
            cells.push_back({name, {Outline::line(-half, half)}, length_mm > 50.0 ? 0.35 : 0.0});
        }
    cells.push_back({"star, 25 mm tips", {star(0.025)}, 0.0});
    if (!quick) cells.push_back({"star, 50 mm tips", {star(0.05)}, 0.0});
    return cells;
}

void runOutlines(bool quick, const OutlineOptions& options, std::FILE* csv)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium;
    std::printf("Outlines, one stationary field, %g wavelengths apart, %d starts (%s)\n"
                "%-30s %6s %5s | %9s %6s | %9s %6s %6s  %s\n",
                options.spacing,
                options.starts,
                base::instructionSetName(base::instructionSet()),
                "",
                "points",
                "asked",
                "apart Pa",
                "cv",
                "mean Pa",
                "cv",
                "1 %",
                "start, time");
    for (const Cell& cell : outlineCells(quick))
    {
        OutlineHologram hologram(options);
        Eigen::VectorXcf q;
        const OutlineReport r = hologram.solve(cell.outlines, array, medium, q);
        char asked[16] = "low";
        if (cell.asked > 0.0) std::snprintf(asked, sizeof asked, "%.2f", cell.asked);
        std::printf("%-30s %6d %5s | %9.1f %6.3f | %9.1f %6.3f %6.3f  %s, %.0f ms%s\n",
                    cell.name.c_str(),
                    r.points,
                    asked,
                    r.apart.mean_Pa,
                    r.apart.coefficientOfVariation,
                    r.along.mean_Pa,
                    r.along.coefficientOfVariation,
                    r.along.percentile1,
                    r.starts[static_cast<std::size_t>(r.chosen)].name.c_str(),
                    r.solve_ms,
                    r.loudEnough ? "" : "  NOT LOUD ENOUGH");
        std::fflush(stdout);
        if (csv != nullptr)
            std::fprintf(csv,
                         "outline,\"%s\",1,%d,%g,%g,%g,%g,%g,,,%g\n",
                         cell.name.c_str(),
                         r.points,
                         cell.asked,
                         r.apart.mean_Pa,
                         r.along.mean_Pa,
                         r.along.coefficientOfVariation,
                         r.along.percentile1,
                         r.solve_ms);
    }
}

TriangleMesh sphereMesh(double radius_m, int rings)
{
    const int around = 2 * rings;
    TriangleMesh mesh;
    mesh.vertices.resize(3, (rings - 1) * around + 2);
    mesh.triangles.resize(3, 2 * around * (rings - 1));
    for (int r = 1; r < rings; ++r)
        for (int k = 0; k < around; ++k)
        {
            const double polar = M_PI * r / rings, turn = 2.0 * M_PI * k / around;
            mesh.vertices.col((r - 1) * around + k) =
                radius_m * Eigen::Vector3d(std::sin(polar) * std::cos(turn),
                                           std::cos(polar),
                                           std::sin(polar) * std::sin(turn));
        }
    const int top = (rings - 1) * around, bottom = top + 1;
    mesh.vertices.col(top) = Eigen::Vector3d(0, radius_m, 0);
    mesh.vertices.col(bottom) = Eigen::Vector3d(0, -radius_m, 0);
    int t = 0;
    for (int k = 0; k < around; ++k)
    {
        const int next = (k + 1) % around;
        mesh.triangles.col(t++) = Eigen::Vector3i(top, next, k);
        for (int r = 0; r + 2 < rings; ++r)
        {
            const int a = r * around, b = a + around;
            mesh.triangles.col(t++) = Eigen::Vector3i(a + k, a + next, b + next);
            mesh.triangles.col(t++) = Eigen::Vector3i(a + k, b + next, b + k);
        }
        const int last = (rings - 2) * around;
        mesh.triangles.col(t++) = Eigen::Vector3i(bottom, last + k, last + next);
    }
    return mesh;
}

Eigen::Matrix3Xd fibonacciSphere(int n, double radius_m)
{
    Eigen::Matrix3Xd points(3, n);
    for (int l = 0; l < n; ++l)
    {
        const double y = 1.0 - 2.0 * (l + 0.5) / n, r = std::sqrt(1.0 - y * y);
        const double turn = l * M_PI * (3.0 - std::sqrt(5.0));
        points.col(l) = radius_m * Eigen::Vector3d(r * std::cos(turn), y, r * std::sin(turn));
    }
    return points;
}

// Mean radiation pressure of the quietest and of the loudest of the fields, each alone. That of the
// cycle is their mean.
std::pair<double, double> rangeAlone_Pa(const Eigen::Matrix3Xd& surface,
                                        const TransducerArray& array,
                                        const Medium& medium,
                                        const std::vector<Eigen::VectorXcf>& fields)
{
    std::pair<double, double> range(1e30, 0.0);
    for (const Eigen::VectorXcf& q : fields)
    {
        const double mean_Pa = meanRadiationPressure(surface, array, medium, {q}).mean();
        range = {std::min(range.first, mean_Pa), std::max(range.second, mean_Pa)};
    }
    return range;
}

// The 30 mm sphere with about 100 points a field: fields in turn, then the same evened out
// together.
void runSurfaces(bool quick, int passes, double spacing_m, std::FILE* csv)
{
    constexpr double kRadius_m = 0.03;
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium;
    SamplerOptions sampling;
    sampling.spacing_m = spacing_m;
    const Eigen::Matrix3Xd fine =
        fibonacciSphere(4000, kRadius_m); // 1.7 mm, a fifth of a wavelength
    std::printf("Sphere of 30 mm, fields in turn; 'one' is the first of them alone\n"
                "%-9s %4s %7s | %8s %6s %-15s | %8s %6s %6s | %6s %6s  %s\n",
                "",
                "K",
                "points",
                "one, Pa",
                "cv",
                "others",
                "mean Pa",
                "cv",
                "1 %",
                "step",
                "change",
                "ms");
    const TriangleMesh mesh = sphereMesh(kRadius_m, 40);
    ControlPoints places;
    places.positions = fibonacciSphere(2500, kRadius_m); // 2.1 mm, a quarter of a wavelength
    places.targets = Eigen::VectorXd::Ones(places.size());
    // What each field lacks in accuracy at its own points is not felt where fields take turns:
    // louder is better.
    constexpr double kLouder = 1.5;
    for (const std::string mode : {"apart", "louder", "evened"})
        for (const int K : {1, 2, 4, 8, 16, 32})
        {
            const bool evened = mode == "evened";
            if (K > (quick ? 8 : (evened ? 16 : 32)) || (evened && (passes == 0 || quick)))
                continue;
            std::vector<ControlPoints> sets;
            for (const SurfaceSamples& samples : sampleSurfaceSets(mesh, sampling, K))
            {
                ControlPoints points;
                points.positions = samples.positions;
                points.normals = samples.normals;
                points.targets = Eigen::VectorXd::Ones(samples.size());
                sets.push_back(points);
            }
            ComposerOptions options;
            options.even = evened ? passes : 0;
            if (mode == "louder") options.solverOptions.loudness = kLouder;
            midair::base::MessageLog messages;
            const double start_s = midair::base::steadySeconds();
            const FieldSequence cycle =
                SequenceComposer(options, messages).composeCycle(sets, places, array, medium);
            const double passed_ms = 1e3 * (midair::base::steadySeconds() - start_s);
            for (const int steps : {0, 3})
            {
                if (steps > 0 && (mode == "louder" || K < 2)) continue;
                const std::vector<Eigen::VectorXcf> fields =
                    smoothedFields(cycle.fields, steps, array.drive);
                const SurfaceStatistics on = statisticsOf(
                    meanRadiationPressure(fine, array, medium, fields), Eigen::VectorXd());
                const SurfaceStatistics one = statisticsOf(
                    meanRadiationPressure(fine, array, medium, {fields[0]}), Eigen::VectorXd());
                const auto [least_Pa, most_Pa] = rangeAlone_Pa(fine, array, medium, fields);
                const CycleSteps change = cycleSteps(fields);
                const std::string kind = steps > 0 ? mode + " +3" : mode;
                std::printf("%-9s %4d %7d | %8.1f %6.3f %6.1f .. %5.1f | %8.1f %6.3f %6.3f | %6.3f "
                            "%6.3f  %.0f\n",
                            kind.c_str(),
                            K,
                            cycle.report.points,
                            one.mean_Pa,
                            one.coefficientOfVariation,
                            least_Pa,
                            most_Pa,
                            on.mean_Pa,
                            on.coefficientOfVariation,
                            on.percentile1,
                            change.meanPhaseStep_rad,
                            change.driveChange,
                            passed_ms);
                std::fflush(stdout);
                if (csv != nullptr)
                    std::fprintf(csv,
                                 "sphere,%s,%d,%d,%g,%g,%g,%g,%g,%g,%g,%g\n",
                                 kind.c_str(),
                                 K,
                                 cycle.report.points,
                                 evened ? 0.0 : (K == 8 ? 0.35 : (K == 16 ? 0.25 : 0.0)),
                                 one.mean_Pa,
                                 on.mean_Pa,
                                 on.coefficientOfVariation,
                                 on.percentile1,
                                 change.meanPhaseStep_rad,
                                 change.driveChange,
                                 passed_ms);
            }
        }
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app("Smoothness of outlines and surfaces against loudness");
    bool quick = false;
    int passes = ComposerOptions().even;
    double spacing_mm = 9.0;
    std::string only;
    std::string csvPath;
    OutlineOptions options;
    app.add_flag("--quick", quick, "fewer cases");
    app.add_option("--only", only, "outlines, surfaces or patches")
        ->check(CLI::IsMember({"outlines", "surfaces", "patches"}));
    app.add_option("--even", passes, "passes of fields evened out together; 0: none");
    app.add_option("--spacing-mm", spacing_mm, "between the points of one field on the sphere");
    app.add_option("--csv", csvPath, "write the figures to a file");
    app.add_option("--starts", options.starts, "starting phases that are tried");
    app.add_option("--finalists", options.finalists, "of them followed to the end");
    app.add_option("--corrections", options.corrections, "of each of those");
    app.add_option(
        "--loudness", options.loudness, "mean pressure over that of points a wavelength apart");
    CLI11_PARSE(app, argc, argv);
    std::FILE* csv = csvPath.empty() ? nullptr : std::fopen(csvPath.c_str(), "w");
    if (!csvPath.empty() && csv == nullptr)
    {
        std::fprintf(stderr, "midair-smooth-bench: can't write %s\n", csvPath.c_str());
        return 1;
    }
    if (csv != nullptr)
        std::fputs("kind,case,fields,points,asked_cv,reference_mean_Pa,mean_Pa,cv,percentile1,"
                   "phase_step_rad,drive_change,time_ms\n",
                   csv);
    try
    {
        if (only.empty() || only == "outlines") runOutlines(quick, options, csv);
        if (only.empty() || only == "surfaces") runSurfaces(quick, passes, spacing_mm * 1e-3, csv);
        if (only.empty() || only == "patches") midair::bench::runPatches(quick);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-smooth-bench: %s\n", error.what());
        return 1;
    }
    if (csv != nullptr) std::fclose(csv);
    return 0;
}
