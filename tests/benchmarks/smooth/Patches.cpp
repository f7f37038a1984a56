#include "tests/benchmarks/smooth/Patches.h"

#include "haptics/propagation/PressureField.h"
#include "haptics/sequence/SequenceComposer.h"
#include "haptics/solvers/dense/LevenbergMarquardt.h"
#include "haptics/surface/SurfaceSampler.h"
#include "tests/benchmarks/Timing.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>
#include <vector>

namespace midair::bench
{

using namespace midair::haptics;

namespace
{

TriangleMesh patchMesh(double side_m, const Eigen::Vector3d& normal)
{
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitY(), normal);
    TriangleMesh mesh;
    mesh.vertices.resize(3, 4);
    mesh.triangles.resize(3, 2);
    const double h = 0.5 * side_m;
    mesh.vertices << -h, h, h, -h, 0, 0, 0, 0, -h, -h, h, h;
    mesh.vertices = (turn.toRotationMatrix() * mesh.vertices).eval();
    mesh.triangles << 0, 0, 1, 2, 2, 3;
    return mesh;
}

struct Patch
{
    const char* name;
    double side_m;
    Eigen::Vector3d normal;
};

Eigen::Matrix3Xd samplesOf(const TriangleMesh& mesh, double spacing_m)
{
    SamplerOptions sampling;
    sampling.spacing_m = spacing_m;
    return sampleSurface(mesh, sampling).positions;
}

ControlPoints pointsAt(const Eigen::Matrix3Xd& positions)
{
    ControlPoints points;
    points.positions = positions;
    points.normals.setZero(3, positions.cols());
    points.targets = Eigen::VectorXd::Ones(positions.cols());
    return points;
}

void printPatch(const Patch& patch,
                const char* kind,
                double spacing,
                int points,
                const SurfaceStatistics& s,
                double ms)
{
    std::printf("%-18s %-22s %5.3f %5d | %8.1f %6.3f %6.3f | %.0f\n",
                patch.name,
                kind,
                spacing,
                points,
                s.mean_Pa,
                s.coefficientOfVariation,
                s.percentile1,
                ms);
    std::fflush(stdout);
}

} // namespace

void runPatches(bool quick)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium;
    const double wavelength_m = medium.wavelength(array.frequency_Hz);
    std::printf("Flat patches\n%-18s %-22s %5s %5s | %8s %6s %6s | %s\n",
                "",
                "",
                "step",
                "n",
                "mean Pa",
                "cv",
                "1 %",
                "ms");
    std::vector<Patch> patches{{"30 mm, across", 0.03, {0, 1, 0}},
                               {"30 mm, along", 0.03, {1, 0, 0}},
                               {"60 mm, across", 0.06, {0, 1, 0}}};
    if (quick) patches.resize(1);
    for (const Patch& patch : patches)
    {
        const TriangleMesh mesh = patchMesh(patch.side_m, patch.normal);
        const Eigen::Matrix3Xd fine = samplesOf(mesh, 0.18 * wavelength_m);
        const auto judge = [&](const std::vector<Eigen::VectorXcf>& fields) {
            return statisticsOf(meanRadiationPressure(fine, array, medium, fields),
                                Eigen::VectorXd());
        };
        double level =
            0.0; // mean |p|^2 a wavelength apart, which is what the evened field is to keep
        for (const double step : {1.0, 0.7, 0.5, 0.35, 0.25})
        {
            if (quick && step < 0.5) continue;
            const ControlPoints points = pointsAt(samplesOf(mesh, step * wavelength_m));
            Eigen::VectorXcf q;
            SolverOptions solving;
            solving.maxIterations = 60;
            const SolveReport report =
                makeSolver(solverNames().front(), solving)->solve(points, array, medium, q);
            const SurfaceStatistics found = judge({q});
            if (step == 1.0) level = found.mean_Pa / radiationPressure(1.0, medium);
            printPatch(patch, "one field", step, points.size(), found, report.solve_ms);
            if (step > 0.5) continue;
            FieldProblem field(1);
            std::vector<int> all(static_cast<std::size_t>(points.size()));
            for (std::size_t l = 0; l < all.size(); ++l)
                all[l] = static_cast<int>(l);
            field.start();
            field.assign(points, all, array, medium, 0.0);
            field.build();
            setPhases(field, q);
            LevenbergMarquardt even;
            even.fit(field, std::sqrt(1.03 * level), {});
            printPatch(patch,
                       "one field, evened out",
                       step,
                       points.size(),
                       judge({playedPhases(field)}),
                       field.elapsed_ms());
        }
        SamplerOptions sampling;
        sampling.spacing_m = wavelength_m;
        for (const int K : {4, 8, 16})
        {
            if (quick && K > 4) continue;
            std::vector<ControlPoints> sets;
            for (const SurfaceSamples& samples : sampleSurfaceSets(mesh, sampling, K))
                sets.push_back(pointsAt(samples.positions));
            base::MessageLog messages;
            const double start_ms = wall_ms();
            const FieldSequence cycle =
                SequenceComposer(ComposerOptions(), messages).composeCycle(sets, {}, array, medium);
            const double passed_ms = wall_ms() - start_ms;
            char kind[32];
            std::snprintf(kind, sizeof kind, "%d fields in turn", K);
            printPatch(patch, kind, 1.0, cycle.report.points, judge(cycle.fields), passed_ms);
        }
    }
}

} // namespace midair::bench
