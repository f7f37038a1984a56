// midair-paper: solves the scenes of Inoue, Makino, Shinoda (World Haptics 2015), prints the
// figures and draws the fields.

#include "device/drive/DriveEncoder.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/TriangleMesh.h"
#include "samples/views/FieldImage.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace
{

using namespace midair;
using Eigen::Vector3d;

/// Field that the array plays for some control points, and its report.
struct Field
{
    haptics::ControlPoints points;
    haptics::SolveReport report;
    Eigen::VectorXcf played;
    Eigen::VectorXd achieved_Pa;
};

/// The paper's array at 14.5 degrees Celsius, where the wavelength is the paper's 8.5 mm.
class PaperArray
{
public:
    PaperArray() : _array(haptics::TransducerArray::octagonalPrism())
    {
        _array.drive.amplitudeLevels = device::amplitudeLevels();
        _medium.temperature_C = 14.5;
    }

    /// \a phaseOnly: true: every transducer at full drive; false: duties are solved for as well, as
    /// in the paper.
    Field solve(const Eigen::Matrix3Xd& positions,
                const std::string& solverName,
                bool phaseOnly = false) const
    {
        Field field;
        field.points.positions = positions;
        field.points.normals = Vector3d::UnitZ().replicate(1, positions.cols());
        field.points.targets = Eigen::VectorXd::Ones(positions.cols());
        haptics::SolverOptions options;
        options.maxIterations = 1000;
        options.rmsTolerance = 0.0;
        options.phaseOnly = phaseOnly;
        Eigen::VectorXcf q;
        field.report =
            haptics::makeSolver(solverName, options)->solve(field.points, _array, _medium, q);
        device::DriveSignal signal;
        device::encode(q.data(), static_cast<int>(q.size()), signal);
        std::vector<std::complex<float>> played;
        device::decode(signal, played);
        field.played = Eigen::Map<Eigen::VectorXcf>(played.data(), q.size());
        field.achieved_Pa = pressure(positions, field);
        return field;
    }

    Eigen::VectorXd pressure(const Eigen::Matrix3Xd& points, const Field& field) const
    {
        return haptics::pressureAt(points, _array, _medium, field.played, 2)
            .cwiseAbs()
            .cast<double>();
    }

    /// Returns the full width at half pressure, metres, of the spot at \a centre along \a direction
    /// (unit length).
    double halfWidth_m(const Field& field, const Vector3d& centre, const Vector3d& direction) const
    {
        constexpr double kStep_m = 5e-5;
        constexpr int kSteps = 600;
        double width_m = 0.0;
        for (const double sign : {-1.0, 1.0})
        {
            Eigen::Matrix3Xd ray(3, kSteps);
            for (int i = 0; i < kSteps; ++i)
                ray.col(i) = centre + sign * i * kStep_m * direction;
            const Eigen::VectorXd p = pressure(ray, field);
            int i = 1;
            while (i < kSteps - 1 && p[i] > 0.5 * p[0])
                ++i;
            width_m += kStep_m * (i - 1 + (p[i - 1] - 0.5 * p[0]) / (p[i - 1] - p[i]));
        }
        return width_m;
    }

    /// Returns sum_i P0 D(theta_i) exp(-beta R_i) / R_i, the pressure at \a point if all waves
    /// arrive in phase.
    double inPhase_Pa(const Vector3d& point) const
    {
        return haptics::referencePropagationMatrix(point, _array, _medium).cwiseAbs().sum();
    }

    void draw(const Field& field, const std::string& title, const std::string& path) const
    {
        samples::FieldImage image;
        image.grid = samples::bestSlice(field.points, 0.03, 4e-4);
        image.pressure_Pa =
            haptics::pressureAt(image.grid.points(), _array, _medium, field.played, 2);
        image.points = field.points;
        image.achieved_Pa = field.achieved_Pa.cast<float>();
        image.level_Pa = field.report.level_Pa;
        image.title = title;
        std::string message;
        samples::writeFieldImage(path, image, &message);
        if (!message.empty()) std::fprintf(stderr, "midair-paper: %s\n", message.c_str());
    }

    double rms_Pa(double peak_Pa) const { return peak_Pa / std::sqrt(2.0); }
    const haptics::Medium& medium() const { return _medium; }

private:
    haptics::TransducerArray _array;
    haptics::Medium _medium;
};

void focus(const PaperArray& paper, const std::string& folder)
{
    const Field field = paper.solve(Vector3d::Zero(), haptics::solverNames().front(), true);
    const double level32 = base::dutyAmplitude(32);
    std::printf("One focus at the centre\n");
    std::printf("  full drive           %.2f kPa rms; all waves in phase: %.2f kPa\n",
                1e-3 * paper.rms_Pa(field.achieved_Pa[0]),
                1e-3 * paper.rms_Pa(paper.inPhase_Pa(Vector3d::Zero())));
    std::printf("  20 %% duty (level 32)  %.2f kPa rms (paper: 5.53)\n",
                1e-3 * level32 * paper.rms_Pa(field.achieved_Pa[0]));
    std::printf("  full width at half pressure  %.1f mm across the axis, %.1f mm along it\n",
                1e3 * paper.halfWidth_m(field, Vector3d::Zero(), Vector3d::UnitX()),
                1e3 * paper.halfWidth_m(field, Vector3d::Zero(), Vector3d::UnitY()));
    const double force_N =
        1e-4 * haptics::radiationPressure(27.7e3 * std::sqrt(2.0), paper.medium(), 2.0);
    std::printf("  27.7 kPa rms on 1 cm2, alpha 2  %.2f N (paper: 100 gw = 0.98 N)\n", force_N);
    paper.draw(field, "One focus", folder + "/paper_focus.png");
}

void line(const PaperArray& paper, const std::string& folder)
{
    Eigen::Matrix3Xd points(3, 5);
    for (int l = 0; l < 5; ++l)
        points.col(l) = Vector3d(-0.017 + 0.0085 * l, 0.0, 0.0);
    for (const std::string solver : {"gs", "sdp-bcd"})
    {
        const Field field = paper.solve(points, solver);
        double across_m = 0.0;
        double along_m = 0.0;
        for (int l = 0; l < 5; ++l)
        {
            across_m += paper.halfWidth_m(field, points.col(l), Vector3d::UnitZ()) / 5.0;
            along_m += paper.halfWidth_m(field, points.col(l), Vector3d::UnitY()) / 5.0;
        }
        std::printf("Line of 34 mm, 5 points, %s\n", solver.c_str());
        std::printf(
            "  rms error %.2f %%, width at half pressure %.1f mm across the axis, %.1f mm along it "
            "(paper: about 10 mm)\n",
            100.0 * field.report.rms,
            1e3 * across_m,
            1e3 * along_m);
        paper.draw(field, "Line of 34 mm, " + solver, folder + "/paper_line_" + solver + ".png");
    }
}

void star(const PaperArray& paper, const std::string& model, const std::string& folder)
{
    const Eigen::Matrix3Xd points = haptics::readObj(model).vertices;
    for (const std::string solver : {"gs", "sdp-bcd", "gauss-newton"})
    {
        const Field field = paper.solve(points, solver);
        std::printf(
            "Star of 11 points, %s, %d iterations\n", solver.c_str(), field.report.iterations);
        std::printf("  rms error %.2f %%, weakest point %.2f of the strongest, loudness E %.3f\n",
                    100.0 * field.report.rms,
                    field.achieved_Pa.minCoeff() / field.achieved_Pa.maxCoeff(),
                    field.report.loudness);
        paper.draw(field, "Star, " + solver, folder + "/paper_star_" + solver + ".png");
    }
}

} // namespace

int main(int argc, char** argv)
{
    std::string out = "out";
    std::string model = MIDAIR_STAR;
    CLI::App app("Solves the scenes of Inoue, Makino and Shinoda's paper anew.", "midair-paper");
    app.add_option("--out", out, "Folder for the pictures paper_*.png")->capture_default_str();
    app.add_option("--star", model, "OBJ file whose vertices are the star's points")
        ->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try
    {
        std::filesystem::create_directories(out);
        const PaperArray paper;
        focus(paper, out);
        line(paper, out);
        star(paper, model, out);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-paper: %s\n", error.what());
        return 2;
    }
    return 0;
}
