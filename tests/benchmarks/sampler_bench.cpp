// How long a mesh takes to sample, and how well the samples keep what the sampler promises.
#include "haptics/base/InputError.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/PointGrid.h"
#include "haptics/surface/SurfaceSampler.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/surface/SampleMeshes.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

using namespace midair::haptics;

namespace
{

/// m; as test::largestGap, with a grid, for meshes of any size.
double largestGap(const TriangleMesh& mesh, const SurfaceSamples& samples, double spacing)
{
    PointGrid grid(spacing);
    for (const auto& point : samples.positions.colwise())
        grid.insert(point);
    const double step = spacing / 20.0;
    double largest = 0.0;
    for (const auto& t : mesh.triangles.colwise())
    {
        const Eigen::Vector3d a = mesh.vertices.col(t[0]);
        const Eigen::Vector3d ab = mesh.vertices.col(t[1]) - a;
        const Eigen::Vector3d ac = mesh.vertices.col(t[2]) - a;
        const int rows = std::max(1, static_cast<int>(std::ceil(ab.norm() / step)));
        const int columns = std::max(1, static_cast<int>(std::ceil(ac.norm() / step)));
        for (int i = 0; i <= rows; ++i)
        {
            for (int j = 0; j <= columns; ++j)
            {
                const double u = static_cast<double>(i) / rows;
                double distance2 = 0.0;
                grid.nearest(a + u * ab + (1.0 - u) * j / columns * ac, 3.0 * spacing, &distance2);
                largest = std::max(largest, distance2);
            }
        }
    }
    return std::sqrt(largest);
}

struct Times
{
    double wall_ms;
    double thread_ms; ///< what the thread got of its core: the same on an idle machine
};

Times median(int repeats, const TriangleMesh& mesh, const SamplerOptions& options)
{
    std::vector<double> wall;
    std::vector<double> thread;
    for (int i = 0; i < repeats; ++i)
    {
        const double wallStart = midair::bench::wall_ms();
        const double threadStart = midair::bench::cpu_ms();
        const SurfaceSamples samples = sampleSurface(mesh, options);
        wall.push_back(midair::bench::wall_ms() - wallStart);
        thread.push_back(midair::bench::cpu_ms() - threadStart);
    }
    return {midair::bench::median(wall), midair::bench::median(thread)};
}

/// A finer mesh of the same surface, of \a triangles triangles or a few more: all cut in four as
/// often as that fits, then so many as are missing cut in three at their middle, which leaves no
/// vertex on an edge.
TriangleMesh refined(TriangleMesh mesh, Eigen::Index triangles)
{
    while (4 * mesh.triangles.cols() <= triangles)
        mesh = test::subdivided(mesh);
    while (mesh.triangles.cols() < triangles)
    {
        const Eigen::Index before = mesh.triangles.cols();
        const Eigen::Index cuts = std::min(before, (triangles - before + 1) / 2);
        const Eigen::Index vertices = mesh.vertices.cols();
        mesh.vertices.conservativeResize(3, vertices + cuts);
        mesh.triangles.conservativeResize(3, before + 2 * cuts);
        for (Eigen::Index i = 0; i < cuts; ++i)
        {
            const Eigen::Vector3i t = mesh.triangles.col(i);
            const int middle = static_cast<int>(vertices + i);
            mesh.vertices.col(middle) =
                (mesh.vertices.col(t[0]) + mesh.vertices.col(t[1]) + mesh.vertices.col(t[2])) / 3.0;
            mesh.triangles.col(i) << t[0], t[1], middle;
            mesh.triangles.col(before + 2 * i) << t[1], t[2], middle;
            mesh.triangles.col(before + 2 * i + 1) << t[2], t[0], middle;
        }
    }
    return mesh;
}

void report(const std::string& name,
            const TriangleMesh& mesh,
            const SamplerOptions& options,
            int repeats)
{
    const SurfaceSamples samples = sampleSurface(mesh, options);
    const Times times = median(repeats, mesh, options);
    std::printf("%-14s %9ld %7d %10.2f %10.2f %13.6f %13.4f\n",
                name.c_str(),
                static_cast<long>(mesh.triangles.cols()),
                samples.size(),
                times.wall_ms,
                times.thread_ms,
                test::smallestDistance(samples.positions) / options.spacing_m,
                largestGap(mesh, samples, options.spacing_m) / options.spacing_m);
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app("Times the surface sampler for each mesh, original and refined to many triangles");
    std::vector<std::string> models;
    double size_m = 0.08;
    SamplerOptions options;
    int triangles = 70000;
    int repeats = 15;
    app.add_option(
        "model", models, "OBJ files; without any the star, a sphere and the shared meshes");
    app.add_option("--size", size_m, "largest extent, m")->capture_default_str();
    app.add_option("--spacing", options.spacing_m, "m")->capture_default_str();
    app.add_option("--triangles", triangles, "refine to this many")->capture_default_str();
    app.add_option("--repeats", repeats, "timings; the median is printed")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
    CLI11_PARSE(app, argc, argv);
    try
    {
        std::printf("%-14s %9s %7s %10s %10s %13s %13s\n",
                    "mesh",
                    "triangles",
                    "points",
                    "median_ms",
                    "thread_ms",
                    "nearest/space",
                    "largest_gap");
        if (models.empty())
        {
            models.emplace_back(MIDAIR_ROOT "/samples/models/star.obj");
            const std::filesystem::path shared = MIDAIR_ROOT "/../shared/meshes";
            std::error_code none;
            for (const auto& file : std::filesystem::directory_iterator(shared, none))
            {
                models.push_back(file.path().string());
            }
            std::sort(models.begin() + 1, models.end());
            report("sphere", test::sphere(0.5 * size_m, 6), options, repeats);
        }
        for (const std::string& model : models)
        {
            const std::string name = std::filesystem::path(model).stem().string();
            const TriangleMesh mesh = readObj(model).scaledTo(size_m);
            report(name, mesh, options, repeats);
            report(name + "+", refined(mesh, triangles), options, repeats);
        }
    }
    catch (const midair::base::InputError& error)
    {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
