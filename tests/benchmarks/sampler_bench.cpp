// How long a mesh takes to sample, and how well the samples keep what the sampler promises.
#include "haptics/InputError.h"
#include "haptics/PointGrid.h"
#include "haptics/SurfaceSampler.h"
#include "tests/haptics/SampleMeshes.h"

#include <algorithm>
#include <chrono>
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

double median_ms(int repeats, const TriangleMesh& mesh, const SamplerOptions& options)
{
    std::vector<double> times;
    for (int i = 0; i < repeats; ++i)
    {
        const auto start = std::chrono::steady_clock::now();
        const SurfaceSamples samples = sampleSurface(mesh, options);
        const std::chrono::duration<double, std::milli> passed =
            std::chrono::steady_clock::now() - start;
        times.push_back(passed.count());
    }
    std::nth_element(times.begin(), times.begin() + repeats / 2, times.end());
    return times[static_cast<std::size_t>(repeats) / 2];
}

/// A finer mesh of the same surface and exactly \a triangles (or a few more) triangles: the largest are halved.
TriangleMesh refined(TriangleMesh mesh, Eigen::Index triangles)
{
    while (4 * mesh.triangles.cols() <= triangles)
        mesh = test::subdivided(mesh);
    if (mesh.triangles.cols() >= triangles) return mesh;
    // A quarter of the missing ones come of each triangle cut in four.
    const Eigen::Index cut = (triangles - mesh.triangles.cols() + 2) / 3;
    TriangleMesh part = mesh;
    part.triangles = mesh.triangles.leftCols(cut);
    const TriangleMesh fine = test::subdivided(part);
    const Eigen::Index rest = mesh.triangles.cols() - cut;
    mesh.vertices = fine.vertices;
    const Eigen::Matrix3Xi kept = mesh.triangles.rightCols(rest);
    mesh.triangles.resize(3, fine.triangles.cols() + rest);
    mesh.triangles << fine.triangles, kept;
    return mesh;
}

void report(const std::string& name,
            const TriangleMesh& mesh,
            const SamplerOptions& options,
            int repeats)
{
    const SurfaceSamples samples = sampleSurface(mesh, options);
    std::printf("%-14s %9ld %7d %10.2f %13.6f %13.4f\n",
                name.c_str(),
                static_cast<long>(mesh.triangles.cols()),
                samples.size(),
                median_ms(repeats, mesh, options),
                test::smallestDistance(samples.positions) / options.spacing_m,
                largestGap(mesh, samples, options.spacing_m) / options.spacing_m);
}

} // namespace

int main(int argc, char** argv)
{
    CLI::App app("Times the surface sampler: each mesh as it is, and refined to many triangles");
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
        std::printf("%-14s %9s %7s %10s %13s %13s\n",
                    "mesh",
                    "triangles",
                    "points",
                    "median_ms",
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
    catch (const InputError& error)
    {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
