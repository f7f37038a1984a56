// midair-paper: solves the scenes of Inoue, Makino, Shinoda (World Haptics 2015), prints the
// figures and draws the fields.

#include "haptics/base/DutyLaw.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/surface/ObjReader.h"
#include "haptics/surface/TriangleMesh.h"
#include "samples/experiments/paper/PaperFigures.h"
#include "samples/shared/ToolOptions.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace
{

using namespace midair;
using Eigen::Vector3d;
using samples::PaperArray;
using samples::PaperField;

double rms_Pa(double peak_Pa)
{
    return peak_Pa / std::sqrt(2.0);
}

void focus(const PaperArray& paper, const std::string& folder)
{
    const PaperField field = paper.solve(Vector3d::Zero(), {haptics::solverNames().front(), true});
    const double level32 = base::dutyAmplitude(32);
    std::printf("One focus at the centre\n");
    std::printf("  full drive           %.2f kPa rms; all waves in phase: %.2f kPa\n",
                1e-3 * rms_Pa(field.achieved_Pa[0]),
                1e-3 * rms_Pa(paper.inPhase_Pa(Vector3d::Zero())));
    std::printf("  20 %% duty (level 32)  %.2f kPa rms (paper: 5.53)\n",
                1e-3 * level32 * rms_Pa(field.achieved_Pa[0]));
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
        const PaperField field = paper.solve(points, {solver});
        double across_m = 0.0;
        double along_m = 0.0;
        for (int l = 0; l < 5; ++l)
        {
            across_m += paper.halfWidth_m(field, points.col(l), Vector3d::UnitZ()) / 5.0;
            along_m += paper.halfWidth_m(field, points.col(l), Vector3d::UnitY()) / 5.0;
        }
        std::printf("Line of 34 mm, 5 points, %s\n", solver.c_str());
        std::printf("  rms error %.2f %%, mean width at half pressure %.1f mm across the axis, "
                    "%.1f mm along it "
                    "(paper: about 10 mm)\n",
                    100.0 * field.report.rms,
                    1e3 * across_m,
                    1e3 * along_m);
        paper.draw(
            field, "Line of 34 mm, " + solver, fmt::format("{}/paper_line_{}.png", folder, solver));
    }
}

void star(const PaperArray& paper, const std::string& model, const std::string& folder)
{
    const Eigen::Matrix3Xd points = haptics::readObj(model).vertices;
    for (const std::string solver : {"gs", "sdp-bcd", "gauss-newton"})
    {
        const PaperField field = paper.solve(points, {solver});
        std::printf(
            "Star of 11 points, %s, %d iterations\n", solver.c_str(), field.report.iterations);
        std::printf("  rms error %.2f %%, weakest point %.2f of the strongest, loudness E %.3f\n",
                    100.0 * field.report.rms,
                    field.evenness(),
                    field.report.loudness);
        paper.draw(field, "Star, " + solver, fmt::format("{}/paper_star_{}.png", folder, solver));
    }
}

int run(int argc, char** argv)
{
    std::string out = "out";
    std::string model = MIDAIR_STAR;
    CLI::App app("Solves the scenes of Inoue, Makino and Shinoda's paper and draws their fields.",
                 "midair-paper");
    app.add_option("--out", out, "Folder for the pictures paper_*.png")->capture_default_str();
    app.add_option("--star", model, "OBJ file whose vertices are the star's points")
        ->capture_default_str();
    int starts = 200;
    app.add_option("--starts",
                   starts,
                   "Random starts of each solver for the flat stars; 0: skip them and the figures")
        ->check(CLI::Range(0, 100000))
        ->capture_default_str();
    int status = samples::EXIT_DONE;
    if (!samples::parseTool(app, argc, argv, status)) return status;
    std::filesystem::create_directories(out);
    const PaperArray paper;
    focus(paper, out);
    line(paper, out);
    star(paper, model, out);
    if (starts == 0) return samples::EXIT_DONE;
    samples::drawPaperFigures(paper, starts, out);
    samples::printStarStarts(paper, starts);
    return samples::EXIT_DONE;
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
        std::fprintf(stderr, "midair-paper: %s\n", error.what());
        return 2;
    }
}
