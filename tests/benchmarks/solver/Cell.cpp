#include "tests/benchmarks/solver/Cell.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/certificate/Certificate.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/SurfaceSampler.h"
#include "haptics/surface/TriangleMesh.h"
#include "tests/benchmarks/Timing.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace midair::bench
{

using namespace midair::haptics;

namespace
{

// n points along a polyline, evenly spaced, both ends of an open one included.
Eigen::Matrix3Xd along(const std::vector<Eigen::Vector3d>& corners, bool closed, int n)
{
    std::vector<double> length{0.0};
    const std::size_t edges = corners.size() - (closed ? 0 : 1);
    for (std::size_t k = 0; k < edges; ++k)
        length.push_back(length.back() + (corners[(k + 1) % corners.size()] - corners[k]).norm());
    Eigen::Matrix3Xd points(3, n);
    for (int l = 0; l < n; ++l)
    {
        const double at = length.back() * l / std::max(1, closed ? n : n - 1);
        std::size_t k = 0;
        while (k + 1 < edges && length[k + 1] < at)
            ++k;
        const double t = (at - length[k]) / (length[k + 1] - length[k]);
        points.col(l) = (1.0 - t) * corners[k] + t * corners[(k + 1) % corners.size()];
    }
    return points;
}

ControlPoints plain(const Eigen::Matrix3Xd& positions)
{
    ControlPoints points;
    points.positions = positions;
    points.normals = Eigen::Vector3d::UnitY().replicate(1, positions.cols());
    points.targets = Eigen::VectorXd::Ones(positions.cols());
    return points;
}

ControlPoints pointsOf(const Cell& cell, double wavelength_m)
{
    if (cell.kase == "sphere") return spherePoints(cell.points, cell.radius_m);
    if (cell.kase == "line")
        return plain(along({{-cell.radius_m, 0, 0}, {cell.radius_m, 0, 0}}, false, cell.points));
    if (cell.kase == "star")
    {
        std::vector<Eigen::Vector3d> corners;
        for (int k = 0; k < 10; ++k)
        {
            const double r = cell.radius_m * (k % 2 == 0 ? 1.0 : 0.381966);
            corners.emplace_back(r * std::sin(M_PI * k / 5), 0.0, r * std::cos(M_PI * k / 5));
        }
        return plain(along(corners, true, cell.points));
    }
    if (cell.kase.size() < 4 || cell.kase.substr(cell.kase.size() - 4) != ".obj")
        throw base::InputError("unknown case '" + cell.kase +
                               "'; known are sphere, star, line and a path that ends in .obj");
    SamplerOptions sampling;
    sampling.spacing_m = wavelength_m;
    const SurfaceSamples samples =
        sampleSurface(readObj(cell.kase).scaledTo(2.0 * cell.radius_m), sampling);
    ControlPoints points = plain(samples.positions);
    points.normals = samples.normals;
    return points;
}

// A path of steps of 1 mm in turning directions, with 1 degree about a turning axis.
void step(int k, Eigen::Matrix3d& rotation, Eigen::Vector3d& position)
{
    const double t = 0.05 * k;
    position += 1e-3 * Eigen::Vector3d(std::cos(t) * std::cos(2 * t),
                                       std::sin(t) * std::cos(2 * t),
                                       -std::sin(2 * t));
    const Eigen::Vector3d axis = Eigen::Vector3d(std::cos(3 * t), std::sin(t), 1.0).normalized();
    rotation = Eigen::AngleAxisd(M_PI / 180.0, axis) * rotation;
}

double roofline_ms(const ControlPoints& points, const TransducerArray& array, int repeats)
{
    PropagationMatrix G;
    G.bind(array, Medium{});
    base::AlignedBuffer<float> q, p;
    q.reserve(static_cast<std::size_t>(2 * G.paddedTransducers()));
    p.reserve(static_cast<std::size_t>(2 * points.size()));
    std::vector<double> times;
    for (int k = 0; k < repeats; ++k)
    {
        const double start = cpu_ms();
        G.build(points.positions);
        for (int b = 0; b < G.blocks(); ++b)
            G.forward(
                b, q.data(), q.data() + G.paddedTransducers(), p.data(), p.data() + points.size());
        times.push_back(cpu_ms() - start);
    }
    return median(times);
}

/// What a hand would find: of the sphere or the mesh samples of its surface, of star and line
/// points along them, a fifth of a wavelength apart or closer.
Eigen::Matrix3Xd surfaceOf(const Cell& cell, double wavelength_m)
{
    constexpr double kSpacing = 0.18; // wavelengths
    const auto dense = [&](double length)
    { return static_cast<int>(length / (kSpacing * wavelength_m)); };
    Cell samples = cell;
    if (cell.kase == "sphere")
    {
        const double side =
            kSpacing * wavelength_m; // Fibonacci points: about 1.1 sqrt(area / n) apart
        samples.points = static_cast<int>(4.8 * M_PI * std::pow(cell.radius_m / side, 2));
    }
    else if (cell.kase == "line")
        samples.points = dense(2.0 * cell.radius_m) + 2;
    else if (cell.kase == "star")
        samples.points = dense(10.0 * cell.radius_m); // a little longer than its outline
    else
    {
        SamplerOptions sampling;
        sampling.spacing_m = kSpacing * wavelength_m;
        sampling.maxPoints = 200000;
        return sampleSurface(readObj(cell.kase).scaledTo(2.0 * cell.radius_m), sampling).positions;
    }
    return pointsOf(samples, wavelength_m).positions;
}

void judge(const Cell& cell,
           const Eigen::Isometry3d& pose,
           const ControlPoints& points,
           const TransducerArray& array,
           const Eigen::VectorXcf& q,
           Result& result)
{
    const double wavelength_m = Medium{}.wavelength(array.frequency_Hz);
    result.last.surface =
        surfaceStatistics(pose * surfaceOf(cell, wavelength_m), array, Medium{}, {q});
    constexpr int kMostCertified = 400; // an n x n matrix and its factorisations
    if (points.size() > kMostCertified) return;
    CertificateOptions options;
    options.batches = 0; // the bound alone
    const Certificate certificate = Certifier(options).certify(points, array, Medium{}, q);
    result.objective = certificate.givenPhases;
    result.bound = certificate.bound;
    result.gap = certificate.gapOfPhases();
}

// The octagon with the reflectors of a cell, whose mode must be known.
TransducerArray arrayOf(const Cell& cell)
{
    if (cell.mode != "update" && cell.mode != "cold")
        throw base::InputError("unknown mode '" + cell.mode + "'; known are update, cold");
    TransducerArray array = TransducerArray::octagonalPrism();
    array.reflectors = cell.reflectors;
    return array;
}

} // namespace

Result run(const Cell& cell)
{
    const TransducerArray array = arrayOf(cell);
    const ControlPoints base = pointsOf(cell, Medium{}.wavelength(array.frequency_Hz));
    ControlPoints points = base;
    if (cell.unequal)
        for (int l = 0; l < points.size(); ++l)
            points.targets[l] = 0.3 + 0.7 * (l * 7919 % 100) / 99.0;

    SolverOptions options;
    options.loudness = cell.loudness;
    options.threads = cell.threads;
    options.maxIterations = cell.iterations;
    const bool cold = cell.mode == "cold";
    std::unique_ptr<HologramSolver> solver = makeSolver(cell.solver, options);
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::VectorXcf q;
    std::vector<double> wall, cpu, matrix, rms, max, loudness, steps, audible, iterations;
    Result result;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int k = cold ? 1 : 0; k <= cell.repeats; ++k)
    {
        points.positions = (rotation * base.positions).colwise() + position;
        if (cold) solver = makeSolver(cell.solver, options);
        const double wallStart = wall_ms(), cpuStart = cpu_ms();
        const SolveReport report = solver->solve(points, array, Medium{}, q);
        const double cpuEnd = cpu_ms(), wallEnd = wall_ms();
        pose.linear() = rotation;
        pose.translation() = position;
        step(k, rotation, position);
        if (k == 0) continue; // the first field is a cold one
        wall.push_back(wallEnd - wallStart);
        cpu.push_back(cpuEnd - cpuStart);
        matrix.push_back(report.matrix_ms);
        rms.push_back(report.rms);
        max.push_back(report.max);
        loudness.push_back(report.loudness);
        steps.push_back(report.meanPhaseStep_rad);
        audible.push_back(report.audibleChange);
        iterations.push_back(report.iterations);
        result.last = report;
    }
    result.cell = cell;
    result.points = base.size();
    result.transducers = array.size();
    result.time_ms = median(wall);
    result.cpu_ms = median(cpu);
    result.matrix_ms = median(matrix);
    result.rms = median(rms);
    result.max = median(max);
    result.loudness = median(loudness);
    result.worstRms = *std::max_element(rms.begin(), rms.end());
    result.leastLoudness = *std::min_element(loudness.begin(), loudness.end());
    result.phaseStep_rad = median(steps);
    result.audibleChange = median(audible);
    if (cell.surface) judge(cell, pose, points, array, q, result);
    result.iterations = static_cast<int>(median(iterations));
    result.roofline_ms = roofline_ms(base, array, std::min(cell.repeats, 15));
    return result;
}

} // namespace midair::bench
