// midair-solve: computes the drive of the array and its field for a model or a list of points,
// without a scene.

#include "haptics/base/InputError.h"
#include "haptics/probe/PressureProbe.h"
#include "samples/shared/ToolOptions.h"
#include "samples/tools/solve/Picture.h"
#include "samples/tools/solve/Solution.h"
#include "samples/tools/solve/SolveOptions.h"
#include "samples/tools/solve/SolveScatterer.h"

#include <cstdio>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace
{

using namespace midair;
using namespace midair::samples;
using base::InputError;

void writeAll(const Solution& solution,
              const std::string& title,
              const std::string& folder,
              bool hasEars)
{
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
        throw midair::base::InputError("cannot make the folder " + folder + ": " + error.message());
    writeControlPoints(
        folder + "/control_points.csv", solution.points, solution.target_Pa, solution.achieved_Pa);
    if (solution.signals.size() < 2)
        writeDrive(folder + "/drive.csv", solution.scene.array, solution.signals.front());
    for (std::size_t k = 0; k < solution.signals.size() && solution.signals.size() > 1; ++k)
        writeDrive(fmt::format("{}/drive_{:02}.csv", folder, k + 1),
                   solution.scene.array,
                   solution.signals[k]);
    writeSummary(folder + "/summary.json",
                 solution.scene.array,
                 solution.scene.medium,
                 solution.sequence.report,
                 solution.parts);
    if (solution.parts.scatterer) writeScattering(folder + "/scatterer.csv", solution);
    if (solution.tolerance) writeTolerance(folder + "/tolerance.csv", *solution.tolerance);
    if (solution.probe) writeProbe(folder, *solution.probe, solution.scene.medium);
    if (hasEars) solution.ears->write(folder + "/exposure.csv", solution.sequence.fields);
    const std::string problem = drawPictures(solution, title, folder);
    if (!problem.empty()) std::fprintf(stderr, "midair-solve: %s\n", problem.c_str());
}

// Prints the effect of ringing. A field that doesn't change has none.
void printRinging(const Solution& solution)
{
    const haptics::SolveReport& report = solution.sequence.report;
    if (!solution.sequence.changes() || solution.scene.array.ringing_s == 0.0) return;
    std::printf("ringing     %.0f us: %.3f of the power is radiated",
                1e6 * solution.scene.array.ringing_s,
                report.ringingShare);
    if (solution.sequence.modulation.amplitudeRate_Hz > 0.0)
        std::printf(", %.3f of the modulation", report.ringingModulation);
    if (solution.parts.ringing)
        std::printf("; rms %.3f %%, level %.0f Pa peak",
                    100.0 * solution.parts.ringing->rms,
                    solution.parts.ringing->level_Pa);
    if (report.surface.samples > 0 && solution.parts.fields > 1)
        std::printf(
            "; surface %.1f Pa, cv %.3f, percentile 1 at %.2f, contrast %.2f, vibration %.3f",
            report.surface.ringingMean_Pa,
            report.surface.ringingCoefficientOfVariation,
            report.surface.ringingPercentile1,
            report.surface.ringingContrast,
            report.surface.vibration);
    std::printf("\n");
}

void printProbes(const ProbeTraces& traces, const haptics::Medium& medium)
{
    double mean_Pa = 0.0;
    for (const Eigen::VectorXcd& p_Pa : traces.pressure_Pa)
        mean_Pa += haptics::radiationOf(p_Pa, medium).mean();
    const auto count = static_cast<double>(traces.pressure_Pa.size());
    std::printf(
        "probes      %zu of %td samples: %.1f Pa mean radiation pressure, %.1f Pa of the steady "
        "fields\n",
        traces.pressure_Pa.size(),
        traces.pressure_Pa.front().size(),
        mean_Pa / count,
        traces.steadyMean_Pa.mean());
}

// Prints what reflectors do to the drives, and whether these are solved for them.
void printReflectors(const Solution& solution)
{
    if (!solution.parts.reflectors) return;
    const SolvedReflectors& some = *solution.parts.reflectors;
    std::printf(
        "reflectors  %d, %s: rms %.3f %%, largest %.3f %%, level %.0f Pa; rms %.3f %%, level "
        "%.0f Pa in free air\n",
        some.count,
        some.isCorrected ? "solved for" : "not solved for",
        100.0 * some.played.rms,
        100.0 * some.played.worst,
        some.played.level_Pa,
        100.0 * some.played.freeRms,
        some.played.freeLevel_Pa);
    std::printf("            rms %.3f %% is expected where they are as accurate as they say",
                100.0 * some.played.expectedRms);
    if (some.other.level_Pa > 0.0 && some.isCorrected)
        std::printf("; %.3f %% without a correction", 100.0 * some.other.expectedRms);
    else if (some.other.level_Pa > 0.0)
        std::printf("; a correction would not gain: %.3f %%", 100.0 * some.other.expectedRms);
    std::printf("\n");
    std::printf("            %.1f dB at ears, %.1f dB without them\n",
                solution.parts.exposure.level_dB,
                some.freeEars_dB);
    if (some.hidden > haptics::kToldHidden * solution.scene.array.size())
        std::printf(
            "            %d of %d transducers are hidden from the points; list them as dead "
            "to leave them out\n",
            some.hidden,
            solution.scene.array.size());
}

void printEarsAndCertificate(const Solution& solution)
{
    const haptics::ExposureFigures& heard = solution.parts.exposure;
    std::printf("at ears     %.1f dB re 20 uPa (rms) at the loudest of %d places, (%.2f, %.2f, "
                "%.2f) m, including %.0f dB for a head\n",
                heard.level_dB,
                heard.places,
                heard.x_m,
                heard.y_m,
                heard.z_m,
                heard.head_dB);
    if (solution.parts.certificate)
        std::printf("certificate misfit and power above the bound: the field %.1f %%, its phases "
                    "%.2f %%, the best phases found %.2f %% (%.1f ms)\n",
                    100.0 * solution.parts.certificate->gapOfField(),
                    100.0 * solution.parts.certificate->gapOfPhases(),
                    100.0 * solution.parts.certificate->gap(),
                    solution.parts.certificate->total_ms);
}

// Prints what is played: one field that was evened out, or several in turn.
void printTurns(const Solution& solution)
{
    const haptics::SolveReport& report = solution.sequence.report;
    if (solution.parts.fields == 1 && solution.parts.evened)
        std::printf(
            "evened out  the surface between the points counts, not the points: their error "
            "is larger, and their level lower, than of a field that is not\n");
    if (solution.parts.fields > 1)
        std::printf(
            "in turn     %d fields at %.0f/s: mean phase step %.2f rad, audible change %.2f "
            "of the drive%s\n",
            solution.parts.fields,
            solution.parts.fieldRate_Hz,
            report.meanPhaseStep_rad,
            report.audibleChange,
            solution.parts.evened ? "; evened out: figures rate all fields together" : "");
}

void printSummary(const Solution& solution, const std::string& folder)
{
    const haptics::SolveReport& report = solution.sequence.report;
    std::printf("array       %s, %d transducers, %.1f kHz\n",
                solution.scene.array.name.c_str(),
                solution.scene.array.size(),
                solution.scene.array.frequency_Hz * 1e-3);
    std::printf("air         %.1f C, wavelength %.3f mm\n",
                solution.scene.medium.temperature_C,
                solution.scene.medium.wavelength(solution.scene.array.frequency_Hz) * 1e3);
    std::printf("points      %d\n", report.points);
    std::printf("solver      %s, %d iterations, %s, %.2f ms + %.2f ms matrix\n",
                report.solver.c_str(),
                report.iterations,
                haptics::stopReasonName(report.stop),
                report.solve_ms,
                report.matrix_ms);
    std::printf(
        "error       rms %.3f %%, largest %.3f %%\n", 100.0 * report.rms, 100.0 * report.max);
    std::printf("level       %.0f Pa peak, loudness E %.3f; %s on a fingertip: %s\n",
                report.level_Pa,
                report.loudness,
                haptics::forceText(solution.parts.fingertip.force_N).c_str(),
                solution.parts.fingertip.feeling());
    if (report.kelvinLevel > 0.0)
        std::printf("air         1 K warmer: rms %.3f %%, level %.1f %%\n",
                    100.0 * report.kelvinRms,
                    100.0 * report.kelvinLevel);
    printTurns(solution);
    if (report.surface.samples > 0)
        std::printf("surface     %.1f Pa mean radiation pressure, cv %.3f, percentiles 1 and 10 at "
                    "%.2f and %.2f of the mean, contrast %.2f +- %.2f\n",
                    report.surface.mean_Pa,
                    report.surface.coefficientOfVariation,
                    report.surface.percentile1,
                    report.surface.percentile10,
                    report.surface.contrast,
                    report.surface.contrastError);
    printRinging(solution);
    if (solution.sequence.report.capFactor < 1.0)
        std::printf(
            "cap         lowered to %.4f of the amplitude, %.0f Pa at the strongest point\n",
            solution.sequence.report.capFactor,
            solution.achieved_Pa.maxCoeff());
    printReflectors(solution);
    if (solution.parts.scatterer) printScattering(*solution.parts.scatterer);
    printEarsAndCertificate(solution);
    if (solution.tolerance) printTolerance(*solution.tolerance);
    if (solution.probe) printProbes(*solution.probe, solution.scene.medium);
    if (!report.message.empty()) std::printf("note        %s\n", report.message.c_str());
    std::printf("written to  %s\n", folder.c_str());
}

bool isSilent(haptics::StopReason stop)
{
    return stop == haptics::StopReason::REFUSED || stop == haptics::StopReason::NOTHING_TO_DO ||
           stop == haptics::StopReason::SILENCED;
}

int run(int argc, char** argv)
{
    SolveArguments arguments;
    CLI::App app("Computes the field that makes MODEL touchable in mid-air and writes the array's "
                 "drive to files.\n"
                 "Example: midair-solve model.obj --size 8cm --pressure 4000 --out result\n"
                 "Array frame: metres, right-handed, origin at the centre of the workspace, y "
                 "along the prism's axis.\n"
                 "Exit code: 0 done, 1 the field is silent, 2 a wrong option or file.",
                 "midair-solve");
    addOptions(app, arguments);
    int status = EXIT_DONE;
    if (!parseTool(app, argc, argv, status)) return status;
    if (arguments.model.empty() && arguments.pointsFile.empty())
    {
        std::fprintf(
            stderr,
            "midair-solve: name a MODEL.obj or --points-file FILE.csv; --help lists the options\n");
        return EXIT_WRONG;
    }
    const Solution solution = solveAll(arguments);
    const std::string& source = arguments.model.empty() ? arguments.pointsFile : arguments.model;
    writeAll(solution,
             std::filesystem::path(source).filename().string(),
             arguments.out,
             !arguments.earsFile.empty());
    printSummary(solution, arguments.out);
    return isSilent(solution.sequence.report.stop) ? EXIT_PROBLEM : EXIT_DONE;
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
        std::fprintf(stderr, "midair-solve: %s\n", error.what());
        return EXIT_WRONG;
    }
}
