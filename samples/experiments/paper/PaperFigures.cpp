#include "samples/experiments/paper/PaperFigures.h"

#include "device/drive/DriveEncoder.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "samples/shared/views/CurvePlot.h"
#include "samples/shared/views/FieldImage.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <random>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using Eigen::Vector3d;

haptics::ControlPoints equalTargets(const Eigen::Matrix3Xd& positions)
{
    haptics::ControlPoints points;
    points.positions = positions;
    points.normals = Vector3d::UnitZ().replicate(1, positions.cols());
    points.targets = Eigen::VectorXd::Ones(positions.cols());
    return points;
}

struct Row
{
    double equal = 0.0;           // evenness from equal phases
    std::vector<double> evenness; // for each random start
    std::vector<double> loudness;
};

Row solveAll(const PaperArray& paper, const Eigen::Matrix3Xd& points, PaperSolve how, int starts)
{
    Row row;
    how.start = 0;
    row.equal = paper.solve(points, how).evenness();
    for (int start = 1; start <= starts; ++start)
    {
        how.start = static_cast<std::uint64_t>(start);
        const PaperField field = paper.solve(points, how);
        row.evenness.push_back(field.evenness());
        row.loudness.push_back(field.report.loudness);
    }
    return row;
}

void print(const PaperSolve& how, const Row& row)
{
    char lambda[16] = "-"; // the default solver has none
    if (how.solver != haptics::solverNames().front())
        std::snprintf(lambda, sizeof lambda, "%g", how.lambda);
    std::printf("    %-12s %6s    %.2f  %.2f %.2f %.2f %.2f %.2f   %.2f\n",
                how.solver.c_str(),
                lambda,
                row.equal,
                base::percentile(row.evenness, 0.0),
                base::percentile(row.evenness, 0.1),
                base::percentile(row.evenness, 0.5),
                base::percentile(row.evenness, 0.9),
                base::percentile(row.evenness, 1.0),
                base::percentile(row.loudness, 0.5));
    std::fflush(stdout);
}

constexpr double kStarWidth_m = 0.034;
constexpr double kPaperFocus_kPa = 5.53; // rms at 20 % of full duty
constexpr double kPaperLine_mm = 10.0;   // "about"
constexpr int kPaperLevel = 32;          // of duty, 20 %

// The random start, 1 .. starts, with the median evenness, and those of all starts.
struct TypicalStart
{
    std::uint64_t start = 1;
    double least = 0.0, median = 0.0, most = 0.0;
};

TypicalStart
typicalStart(const PaperArray& paper, const Eigen::Matrix3Xd& points, PaperSolve how, int starts)
{
    std::vector<std::pair<double, std::uint64_t>> found;
    for (how.start = 1; how.start <= static_cast<std::uint64_t>(starts); ++how.start)
        found.emplace_back(paper.solve(points, how).evenness(), how.start);
    std::sort(found.begin(), found.end());
    const auto& [median, start] = found[(found.size() - 1) / 2];
    return {start, found.front().first, median, found.back().first};
}

void drawStar(const PaperArray& paper,
              int figure,
              const std::string& solver,
              const std::string& name,
              int starts,
              const std::string& folder)
{
    const Eigen::Matrix3Xd points = flatStar(kStarWidth_m);
    PaperSolve how{solver, true, 1e-3};
    const TypicalStart typical = typicalStart(paper, points, how, starts);
    how.start = typical.start;
    const PaperField field = paper.solve(points, how);
    std::printf("Figure %d: flat star of 34 mm, %s, phases only, lambda 0.001, %d iterations\n"
                "  weakest point over strongest: %.2f (median of %d random starts; %.2f .. %.2f)\n",
                figure,
                name.c_str(),
                field.report.iterations,
                typical.median,
                starts,
                typical.least,
                typical.most);
    paper.draw(field,
               fmt::format("Figure {}: star, {}: weakest point {:.2f} of strongest",
                           figure,
                           name,
                           field.evenness()),
               fmt::format("{}/paper_figure{}.png", folder, figure));
}

// Returns the rms pressure in kPa along a line through a place, from -20 to 20 mm.
Curve profileOf(const PaperArray& paper,
                const PaperField& field,
                const Vector3d& centre,
                const Vector3d& direction,
                double factor,
                const std::string& name)
{
    Curve curve;
    curve.x = Eigen::VectorXd::LinSpaced(801, -20.0, 20.0);
    Eigen::Matrix3Xd places(3, curve.x.size());
    for (Eigen::Index k = 0; k < curve.x.size(); ++k)
        places.col(k) = centre + 1e-3 * curve.x[k] * direction;
    curve.y = factor * 1e-3 / std::sqrt(2.0) * paper.pressure(places, field);
    curve.name = name;
    return curve;
}

void write(const CurvePlot& plot, const std::string& path)
{
    const std::string problem = drawCurves(path, plot);
    if (!problem.empty()) throw base::InputError(problem);
}

void drawFocus(const PaperArray& paper, const std::string& folder)
{
    const PaperField field = paper.solve(Vector3d::Zero(), {haptics::solverNames().front(), true});
    const double factor = base::dutyAmplitude(kPaperLevel);
    CurvePanel panel;
    panel.xName = "distance from the centre (mm)";
    panel.yName = "pressure (kPa, rms)";
    panel.xLow = -20.0;
    panel.xHigh = 20.0;
    panel.yHigh = 6.5;
    const Vector3d centre = Vector3d::Zero();
    panel.curves = {
        profileOf(paper, field, centre, Vector3d::UnitX(), factor, "across the axis (x)"),
        profileOf(paper, field, centre, Vector3d::UnitY(), factor, "along the axis (y)")};
    const double peak_kPa = panel.curves[0].y.maxCoeff();
    CurveBand band;
    band.low = band.high = band.middle = kPaperFocus_kPa;
    band.name = fmt::format("paper: {} kPa", kPaperFocus_kPa);
    band.color = 2;
    panel.bands = {band};
    std::printf("Figure 6: focus at the centre, duty level %d of 255 (20 %%)\n"
                "  %.2f kPa rms (paper: %.2f)\n",
                kPaperLevel,
                peak_kPa,
                kPaperFocus_kPa);
    write({"Figure 6: focus of all 3984 transducers at 20 %",
           fmt::format("highest here: {:.2f} kPa; the array's source amplitude is fitted to the "
                       "paper's value",
                       peak_kPa),
           {panel}},
          folder + "/paper_figure6.png");
}

void drawLine(const PaperArray& paper, const std::string& folder)
{
    Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, 5);
    points.row(0).setLinSpaced(-0.017, 0.017);
    const PaperField field = paper.solve(points, {"sdp-bcd"});
    const Vector3d middle = points.col(2);
    const double along_mm = 1e3 * paper.halfWidth_m(field, middle, Vector3d::UnitY());
    const double across_mm = 1e3 * paper.halfWidth_m(field, middle, Vector3d::UnitZ());
    CurvePanel panel;
    panel.xName = "distance from the line's middle (mm)";
    panel.yName = "pressure (kPa, rms)";
    panel.xLow = -20.0;
    panel.xHigh = 20.0;
    panel.curves = {profileOf(paper, field, middle, Vector3d::UnitX(), 1.0, "along the line (x)"),
                    profileOf(paper, field, middle, Vector3d::UnitZ(), 1.0, "across it (z)"),
                    profileOf(paper, field, middle, Vector3d::UnitY(), 1.0, "across it (y)")};
    CurveBand band;
    band.low = -0.5 * kPaperLine_mm;
    band.high = 0.5 * kPaperLine_mm;
    band.name = "paper: about 10 mm wide";
    band.isOfX = true;
    band.color = 3;
    panel.bands = {band};
    std::printf(
        "Figure 7: line of 34 mm, 5 points, SDP relaxation\n"
        "  width at half pressure in the middle: %.1f mm across the axis (z), %.1f mm along "
        "it (y) (paper: about %.0f)\n",
        across_mm,
        along_mm,
        kPaperLine_mm);
    write({"Figure 7: line of 34 mm, 5 control points, SDP relaxation, full drive",
           fmt::format("width at half pressure: {:.1f} mm along z, {:.1f} mm along y, the prism's "
                       "axis",
                       across_mm,
                       along_mm),
           {panel}},
          folder + "/paper_figure7.png");
}

} // namespace

double PaperField::evenness() const
{
    return achieved_Pa.minCoeff() / achieved_Pa.maxCoeff();
}

PaperArray::PaperArray() : _array(haptics::TransducerArray::octagonalPrism())
{
    _array.drive.amplitudeLevels = device::amplitudeLevels();
    _medium.temperature_C = 14.5;
}

// A solver starts from the phases of its last field at the new points. So first solve with a copy
// of the array with random phase errors: played by the real array, that field is speckle, whose
// phases at points half a wavelength apart or more are random.
void PaperArray::randomise(haptics::HologramSolver& solver, std::uint64_t seed) const
{
    haptics::TransducerArray other = _array;
    other.phaseOffset_rad.resize(other.size());
    std::mt19937_64 random(seed);
    for (double& phase : other.phaseOffset_rad)
        phase = base::kTwoPi * static_cast<double>(random() >> 11U) * 0x1p-53;
    Eigen::VectorXcf q;
    solver.solve(equalTargets(Vector3d::Zero()), other, _medium, q);
}

PaperField PaperArray::solve(const Eigen::Matrix3Xd& positions, const PaperSolve& how) const
{
    PaperField field;
    field.points = equalTargets(positions);
    haptics::SolverOptions options;
    options.maxIterations = 1000;
    options.rmsTolerance = 0.0;
    options.phaseOnly = how.phaseOnly;
    options.lambda = how.lambda;
    options.seed += how.start;
    const auto solver = haptics::makeSolver(how.solver, options);
    if (how.start > 0) randomise(*solver, how.start);
    Eigen::VectorXcf q;
    field.report = solver->solve(field.points, _array, _medium, q);
    device::DriveSignal signal;
    device::encode(q.data(), static_cast<int>(q.size()), signal);
    std::vector<std::complex<float>> played;
    device::decode(signal, played);
    field.played = Eigen::Map<Eigen::VectorXcf>(played.data(), q.size());
    field.achieved_Pa = pressure(positions, field);
    return field;
}

Eigen::VectorXd PaperArray::pressure(const Eigen::Matrix3Xd& points, const PaperField& field) const
{
    return haptics::pressureAt(points, _array, _medium, field.played, 2).cwiseAbs().cast<double>();
}

double PaperArray::halfWidth_m(const PaperField& field,
                               const Vector3d& centre,
                               const Vector3d& direction) const
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

double PaperArray::inPhase_Pa(const Vector3d& point) const
{
    return haptics::referencePropagationMatrix(point, _array, _medium).cwiseAbs().sum();
}

void PaperArray::draw(const PaperField& field,
                      const std::string& title,
                      const std::string& path) const
{
    const haptics::FieldGrid grid = bestSlice(field.points, 0.03, 4e-4);
    osgMidair::FieldPicture picture = fieldPicture(grid,
                                                   pressure(grid.points(), field).cast<float>(),
                                                   field.points,
                                                   field.achieved_Pa,
                                                   field.report.level_Pa);
    picture.title = title;
    std::string message;
    writeFieldPicture(path, picture, message);
    if (!message.empty()) std::fprintf(stderr, "midair-paper: %s\n", message.c_str());
}

Eigen::Matrix3Xd flatStar(double width_m)
{
    const double outer_m = 0.5 * width_m / std::sin(0.4 * base::kPi);
    const double inner_m = outer_m * 0.5 * (3.0 - std::sqrt(5.0)); // the pentagram's notches
    Eigen::Matrix3Xd points(3, 11);
    for (int k = 0; k < 10; ++k)
    {
        const double r = k % 2 == 0 ? outer_m : inner_m;
        const double angle = base::kPi * k / 5.0;
        points.col(k) = Eigen::Vector3d(r * std::sin(angle), 0.0, r * std::cos(angle));
    }
    points.col(10).setZero();
    return points;
}

void printStarStarts(const PaperArray& paper, int starts)
{
    std::printf("Flat star of 11 points in the cross-section, equal start and %d random starts:\n"
                "weakest point over strongest (and median loudness E)\n"
                "    solver       lambda   equal   min  10%%  50%%  90%%  max      E\n",
                starts);
    for (const double width_m : {0.034, 0.12})
        for (const bool phaseOnly : {true, false})
        {
            std::printf(
                "  %.0f mm, %s\n", 1e3 * width_m, phaseOnly ? "phases only" : "clipped amplitudes");
            for (const PaperSolve& how : {PaperSolve{"gs", phaseOnly, 1e-3},
                                          PaperSolve{"sdp-bcd", phaseOnly, 1e-3},
                                          PaperSolve{"gs", phaseOnly, 0.1},
                                          PaperSolve{"sdp-bcd", phaseOnly, 0.1},
                                          PaperSolve{"gauss-newton", phaseOnly}})
                print(how, solveAll(paper, flatStar(width_m), how, starts));
        }
}

void drawPaperFigures(const PaperArray& paper, int starts, const std::string& folder)
{
    drawStar(paper, 3, "gs", "GS", starts, folder);
    drawStar(paper, 4, "sdp-bcd", "SDP relaxation", starts, folder);
    drawFocus(paper, folder);
    drawLine(paper, folder);
}

} // namespace midair::samples
