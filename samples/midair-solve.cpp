// midair-solve: a model (or a list of points) in, the drive of the array and the field it makes out; needs no scene.

#include "device/DriveEncoder.h"
#include "engine-bridge/PressureCap.h"
#include "haptics/Certificate.h"
#include "haptics/ControlPointSelector.h"
#include "haptics/HologramSolver.h"
#include "haptics/InputError.h"
#include "haptics/PressureField.h"
#include "haptics/PropagationMatrix.h"
#include "haptics/SurfaceSampler.h"
#include "haptics/TriangleMesh.h"
#include "samples/FieldImage.h"
#include "samples/SolveFiles.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace
{

using namespace midair;
using namespace midair::samples;
using haptics::InputError;

/// What the command line asks for; every length in metres.
struct Arguments
{
    std::string model;
    std::string pointsFile;
    std::string array = "octagon";
    std::string directivity;
    std::string solver;
    std::string out = "out";
    std::vector<double> position{0.0, 0.0, 0.0};
    std::vector<double> rotation_deg{0.0, 0.0, 0.0};
    double size_m = 0.0;
    double spacing_m = 0.0;
    double pressure_Pa = 0.0;
    double maxPressure_Pa = 0.0;
    double temperature_C = 20.0;
    bool certify = false;
    haptics::Sampling sampling = haptics::Sampling::SURFACE;
};

void addOptions(CLI::App& app, Arguments& arguments)
{
    static const std::map<std::string, haptics::Sampling> kSamplings{
        {"surface", haptics::Sampling::SURFACE},
        {"edges", haptics::Sampling::EDGES},
        {"vertices", haptics::Sampling::VERTICES}};
    std::string solvers;
    for (const std::string& name : haptics::solverNames())
        solvers += (solvers.empty() ? "" : ", ") + name;

    auto* model = app.add_option("MODEL", arguments.model, "Wavefront OBJ file");
    app.add_option("--points-file",
                   arguments.pointsFile,
                   "CSV instead of a model: x_m,y_m,z_m,nx,ny,nz and target_Pa (absolute) or "
                   "target (relative)")
        ->excludes(model);
    app.add_option("--size",
                   arguments.size_m,
                   "Largest extent of the model in metres (default: as in the file)")
        ->check(CLI::PositiveNumber);
    app.add_option("--position", arguments.position, "Where the model's centre goes, metres")
        ->expected(3);
    app.add_option("--rotation-deg",
                   arguments.rotation_deg,
                   "Rotation about x, then y, then z of the array frame")
        ->expected(3);
    app.add_option(
           "--array", arguments.array, "octagon, board, a shipped array's name, or FILE.json")
        ->capture_default_str();
    app.add_option("--spacing",
                   arguments.spacing_m,
                   "Between control points, metres (default: one wavelength)")
        ->check(CLI::PositiveNumber);
    app.add_option(
           "--sampling", arguments.sampling, "surface, edges or vertices (default: surface)")
        ->transform(CLI::CheckedTransformer(kSamplings).description(""));
    app.add_option("--pressure",
                   arguments.pressure_Pa,
                   "Peak pressure at every point in Pa (default: as loud as it accurately can)")
        ->check(CLI::PositiveNumber);
    app.add_option("--max-pressure",
                   arguments.maxPressure_Pa,
                   "Peak Pa that no point gets more than: the drive is scaled down to that "
                   "(default: no cap)")
        ->check(CLI::Range(1.0, 1e6));
    app.add_option("--solver", arguments.solver, "One of " + solvers + " (default: the first)");
    app.add_option(
           "--temperature", arguments.temperature_C, "Of the air, degrees Celsius, -40 to 60")
        ->capture_default_str();
    app.add_option(
        "--directivity", arguments.directivity, "t4010a1-harmonics, t4010a1-table or point");
    app.add_flag(
        "--certify",
        arguments.certify,
        "Bound from below what any phases could reach, and tell how far this field is from it");
    app.add_option("--out",
                   arguments.out,
                   "Folder for control_points.csv, drive.csv, summary.json and field.png")
        ->capture_default_str();
}

Eigen::Isometry3d poseOf(const Arguments& arguments)
{
    const auto angle = [&](int axis)
    { return arguments.rotation_deg[static_cast<std::size_t>(axis)] * M_PI / 180.0; };
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(
        Eigen::Vector3d(arguments.position[0], arguments.position[1], arguments.position[2]));
    pose.rotate(Eigen::AngleAxisd(angle(2), Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(angle(1), Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(angle(0), Eigen::Vector3d::UnitX()));
    return pose;
}

/// Everything that is written, kept together until the files are.
struct Solution
{
    haptics::TransducerArray array;
    haptics::Medium medium;
    haptics::TriangleMesh mesh; ///< empty where the points came from a file
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    haptics::ControlPoints points;
    bool absolute = false;  ///< targets are in Pa
    double capFactor = 1.0; ///< what the cap took off all amplitudes
    haptics::SolveReport report;
    device::DriveSignal signal;
    Eigen::VectorXcf played;     ///< m, what the encoded drive plays
    Eigen::VectorXd achieved_Pa; ///< n, in double from the encoded drive
    Eigen::VectorXd target_Pa;   ///< n
    std::optional<haptics::Certificate> certificate;
};

/// The model's samples in the array frame; every target 1, or the pressure asked for.
haptics::PosedObject sampleModel(const Arguments& arguments, Solution& solution)
{
    solution.mesh = haptics::readObj(arguments.model);
    if (arguments.size_m > 0.0) solution.mesh = solution.mesh.scaledTo(arguments.size_m);
    solution.pose = poseOf(arguments);
    haptics::SamplerOptions options;
    options.spacing_m = arguments.spacing_m > 0.0
                            ? arguments.spacing_m
                            : solution.medium.wavelength(solution.array.frequency_Hz);
    options.sampling = arguments.sampling;
    solution.absolute = arguments.pressure_Pa > 0.0;

    haptics::PosedObject object;
    object.pose(haptics::sampleSurface(solution.mesh, options), solution.pose);
    object.spacing_m = options.spacing_m;
    if (solution.absolute) object.target = arguments.pressure_Pa;
    return object;
}

/// Points that the user lists are taken as they are, but for doubles.
haptics::PosedObject readPoints(const Arguments& arguments, Solution& solution)
{
    const haptics::ControlPoints points =
        readControlPoints(arguments.pointsFile, solution.absolute);
    haptics::PosedObject object;
    object.positions = points.positions;
    object.normals = points.normals;
    object.intensity = points.targets.cast<float>();
    object.spacing_m = 1e-6;
    return object;
}

/// Leaves out what the array can't reach, and says so.
void selectPoints(const haptics::PosedObject& object, Solution& solution)
{
    haptics::SelectorOptions options;
    options.maxPoints = 2000;
    const haptics::Workspace workspace(
        solution.array, solution.medium.wavelength(solution.array.frequency_Hz), options);
    haptics::Selection selection = haptics::selectControlPoints({object}, workspace, options);
    solution.points = std::move(selection.points);
    const std::string left = selection.report.summary();
    if (!left.empty()) std::fprintf(stderr, "midair-solve: solves for %s\n", left.c_str());
}

/// What the array makes of a drive: its amplitudes are rounded to the levels that it has.
Eigen::VectorXcf playedBy(const haptics::TransducerArray& array, const device::DriveSignal& signal)
{
    std::vector<std::complex<float>> played;
    device::decode(signal, played);
    const std::vector<float>& levels = array.drive.amplitudeLevels;
    for (std::complex<float>& q : played)
    {
        const float amplitude = std::abs(q);
        if (levels.empty() || !(amplitude > 0.0f)) continue;
        const auto above = std::lower_bound(levels.begin(), levels.end(), amplitude);
        float nearest = above == levels.end() ? levels.back() : *above;
        if (above != levels.end() && above != levels.begin() &&
            amplitude - *(above - 1) < *above - amplitude)
            nearest = *(above - 1);
        q *= nearest / amplitude;
    }
    return Eigen::Map<Eigen::VectorXcf>(played.data(), static_cast<Eigen::Index>(played.size()));
}

void holdToCap(double max_Pa, Solution& solution)
{
    bridge::CappedField field = bridge::PressureCap(max_Pa).hold(
        solution.points.positions,
        {&solution.array},
        solution.medium,
        [&](const device::DriveSignal& signal) { return playedBy(solution.array, signal); },
        solution.signal,
        2);
    solution.capFactor = field.factor;
    if (field.factor >= 1.0) return;
    solution.played = std::move(field.played);
    device::encode(
        solution.played.data(), static_cast<int>(solution.played.size()), solution.signal);
    bridge::rate(solution.points, field.achieved_Pa, solution.absolute, solution.report);
}

void solve(const Arguments& arguments, Solution& solution)
{
    haptics::SolverOptions options;
    options.absoluteTargets = solution.absolute;
    options.threads = 2;
    const std::string name =
        arguments.solver.empty() ? haptics::solverNames().front() : arguments.solver;
    const auto solver = haptics::makeSolver(name, options);
    Eigen::VectorXcf q;
    solution.report = solver->solve(solution.points, solution.array, solution.medium, q);

    device::encode(q.data(), static_cast<int>(q.size()), solution.signal);
    solution.played = playedBy(solution.array, solution.signal);
    if (arguments.maxPressure_Pa > 0.0) holdToCap(arguments.maxPressure_Pa, solution);
    const Eigen::MatrixXcd G = haptics::referencePropagationMatrix(
        solution.points.positions, solution.array, solution.medium);
    solution.achieved_Pa = (G * solution.played.cast<std::complex<double>>()).cwiseAbs();
    const Eigen::VectorXd& a = solution.points.targets;
    const bool relative = !solution.absolute && a.size() > 0;
    solution.target_Pa = relative ? a * (solution.achieved_Pa.dot(a) / a.squaredNorm()) : a;
}

Solution solveAll(const Arguments& arguments)
{
    Solution solution;
    solution.array = haptics::TransducerArray::load(arguments.array);
    if (solution.array.drive.amplitudeLevels.empty())
        solution.array.drive.amplitudeLevels = device::amplitudeLevels();
    if (!arguments.directivity.empty())
        solution.array.directivity = haptics::directivityFromName(arguments.directivity);
    solution.medium.temperature_C = arguments.temperature_C;
    std::string error;
    if (!solution.medium.isValid(&error)) throw InputError(error);

    selectPoints(arguments.pointsFile.empty() ? sampleModel(arguments, solution)
                                              : readPoints(arguments, solution),
                 solution);
    solve(arguments, solution);
    const bool solved = solution.report.level_Pa > 0.0;
    if (arguments.certify && solved)
        solution.certificate = haptics::Certifier().certify(
            solution.points, solution.array, solution.medium, solution.played);
    return solution;
}

void writeField(const Solution& solution, const std::string& title, const std::string& path)
{
    FieldImage image;
    image.grid = bestSlice(solution.points, 0.02, 4e-4);
    image.pressure_Pa = haptics::pressureAt(
        image.grid.points(), solution.array, solution.medium, solution.played, 2);
    image.points = solution.points;
    image.achieved_Pa = solution.achieved_Pa.cast<float>();
    image.level_Pa = solution.target_Pa.size() > 0 ? solution.target_Pa.maxCoeff() : 0.0;
    if (solution.mesh.triangles.cols() > 0)
        image.outline = outlineInPlane(solution.mesh, solution.pose, image.grid);
    image.title = title;
    char caption[160];
    std::snprintf(caption,
                  sizeof caption,
                  "%s, %d points, rms %.2f %%, %.0f Pa peak",
                  solution.report.solver.c_str(),
                  solution.report.points,
                  100.0 * solution.report.rms,
                  solution.report.level_Pa);
    image.caption = caption;
    std::string message;
    writeFieldImage(path, image, &message);
    if (!message.empty()) std::fprintf(stderr, "midair-solve: %s\n", message.c_str());
}

void writeAll(const Solution& solution, const std::string& title, const std::string& folder)
{
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw InputError("cannot make the folder " + folder + ": " + error.message());
    writeControlPoints(
        folder + "/control_points.csv", solution.points, solution.target_Pa, solution.achieved_Pa);
    writeDrive(folder + "/drive.csv", solution.array, solution.signal);
    writeSummary(folder + "/summary.json",
                 solution.array,
                 solution.medium,
                 solution.report,
                 solution.capFactor,
                 solution.certificate ? &*solution.certificate : nullptr);
    writeField(solution, title, folder + "/field.png");
}

void printSummary(const Solution& solution, const std::string& folder)
{
    const haptics::SolveReport& report = solution.report;
    std::printf("array       %s, %d transducers, %.1f kHz\n",
                solution.array.name.c_str(),
                solution.array.size(),
                solution.array.frequency_Hz * 1e-3);
    std::printf("air         %.1f C, wavelength %.3f mm\n",
                solution.medium.temperature_C,
                solution.medium.wavelength(solution.array.frequency_Hz) * 1e3);
    std::printf("points      %d\n", report.points);
    std::printf("solver      %s, %d iterations, %s, %.2f ms + %.2f ms matrix\n",
                report.solver.c_str(),
                report.iterations,
                haptics::stopReasonName(report.stop),
                report.solve_ms,
                report.matrix_ms);
    std::printf(
        "error       rms %.3f %%, largest %.3f %%\n", 100.0 * report.rms, 100.0 * report.max);
    std::printf("level       %.0f Pa peak, loudness E %.3f\n", report.level_Pa, report.loudness);
    if (solution.capFactor < 1.0)
        std::printf("cap         held down to %.4f of the amplitude%s\n",
                    solution.capFactor,
                    solution.capFactor > 0.0 ? "" : ": the array's levels can't keep to it");
    if (solution.certificate)
        std::printf("certificate misfit and power of the field %.1f %%, of its phases %.2f %%, of "
                    "the best phases "
                    "found %.2f %% over the bound (%.1f ms)\n",
                    100.0 * solution.certificate->gapOfField(),
                    100.0 * solution.certificate->gapOfPhases(),
                    100.0 * solution.certificate->gap(),
                    solution.certificate->total_ms);
    if (!report.message.empty()) std::printf("note        %s\n", report.message.c_str());
    std::printf("written to  %s\n", folder.c_str());
}

} // namespace

int main(int argc, char** argv)
{
    Arguments arguments;
    CLI::App app("Solves the field that makes MODEL touchable in mid-air, and writes the drive of "
                 "the array.\n"
                 "Array frame: metres, right-handed, origin at the centre of the workspace, y "
                 "along the prism's axis.",
                 "midair-solve");
    addOptions(app, arguments);
    CLI11_PARSE(app, argc, argv);
    if (arguments.model.empty() && arguments.pointsFile.empty())
    {
        std::fprintf(
            stderr,
            "midair-solve: name a MODEL.obj or --points-file FILE.csv; --help lists the options\n");
        return 2;
    }
    try
    {
        const Solution solution = solveAll(arguments);
        const std::string& source =
            arguments.model.empty() ? arguments.pointsFile : arguments.model;
        writeAll(solution, std::filesystem::path(source).filename().string(), arguments.out);
        printSummary(solution, arguments.out);
        return solution.report.stop == haptics::StopReason::REFUSED ||
                       solution.report.stop == haptics::StopReason::NOTHING_TO_DO
                   ? 1
                   : 0;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-solve: %s\n", error.what());
        return 2;
    }
}
