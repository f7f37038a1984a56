#include "samples/tools/solve/SolveTolerance.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Quantity.h"
#include "samples/shared/SettingOptions.h"

#include <cmath>
#include <cstdio>
#include <fstream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace midair::samples
{

void addToleranceOptions(CLI::App& app, SolveArguments& arguments)
{
    auto* study = app.add_flag(
        "--tolerance",
        arguments.hasTolerance,
        "What is left of the field where the array and the air are not as they were meant (Monte "
        "Carlo): tolerance.csv and tolerance.png");
    haptics::ToleranceOptions& options = arguments.tolerance;
    const auto addValues =
        [&](const char* name, std::vector<double>& values, const char* unit, const char* what)
    {
        app.add_option(name, values, what)
            ->transform(inUnit(unit, base::parseQuantity))
            ->delimiter(',')
            ->needs(study)
            ->capture_default_str();
    };
    addValues("--tolerance-position",
              options.position_m,
              "m",
              "Boards displaced as wholes, rms in each of x, y and z, metres");
    addValues("--tolerance-tilt",
              options.tilt_deg,
              "deg",
              "Boards turned about their middles, rms about each of x, y and z, degrees");
    addValues("--tolerance-phase", options.phase_deg, "deg", "Phases off, rms, degrees");
    addValues("--tolerance-temperature", options.temperature_K, "", "Air warmer by, K");
    addValues("--tolerance-dead", options.dead, "", "Share of transducers that are silent");
    app.add_option("--tolerance-draws", options.draws, "Random arrays for each of these values")
        ->check(CLI::Range(1, 10000))
        ->needs(study)
        ->capture_default_str();
    app.add_option("--tolerance-seed",
                   options.seed,
                   "The same seed draws the same arrays; another one others")
        ->needs(study)
        ->capture_default_str();
}

namespace
{

std::string orEmpty(double value)
{
    return std::isnan(value) ? std::string() : fmt::format("{:.6g}", value);
}

std::string lineOf(const haptics::ToleranceRow& row, const char* name, const char* unit)
{
    return fmt::format("{},{:.6g},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{}\n",
                       name,
                       row.value,
                       unit,
                       row.draws,
                       row.rms,
                       row.rms90,
                       row.loudness,
                       row.loudness10,
                       row.focus,
                       row.focus10,
                       orEmpty(row.expectedRms),
                       orEmpty(row.expectedFocus));
}

void printLine(const std::string& what, const haptics::ToleranceRow& row)
{
    std::printf("%-12s%-18s rms %.2f %%, loudness E %.3f, focus %.3f\n",
                "",
                what.c_str(),
                100.0 * row.rms,
                row.loudness,
                row.focus);
}

} // namespace

void writeTolerance(const std::string& path, const haptics::ToleranceStudy& study)
{
    std::ofstream file(path);
    file << "deviation,value,unit,draws,rms,rms_p90,loudness,loudness_p10,focus,focus_p10,"
            "expected_rms,expected_focus\n"
         << lineOf(study.nominal, "nominal", "");
    for (const haptics::ToleranceRow& row : study.rows)
        file << lineOf(
            row, haptics::deviationName(row.deviation), haptics::deviationUnit(row.deviation));
    file.close();
    if (!file) throw base::InputError("could not write " + path + ": is the disk full?");
}

void printTolerance(const haptics::ToleranceStudy& study)
{
    std::printf("tolerance   %d arrays played in %.1f s of the processor; medians of %d a value:\n",
                study.arrays,
                study.cpu_s,
                study.draws);
    printLine("as meant", study.nominal);
    const auto shownValue = [](const haptics::ToleranceRow& row)
    {
        using haptics::Deviation;
        const std::string name = haptics::deviationName(row.deviation);
        if (row.deviation == Deviation::POSITION)
            return fmt::format("{} {:g} mm", name, 1e3 * row.value);
        if (row.deviation == Deviation::DEAD)
            return fmt::format("{} {:g} %", name, 100.0 * row.value);
        return fmt::format("{} {:g} {}", name, row.value, haptics::deviationUnit(row.deviation));
    };
    for (const haptics::ToleranceRow& row : study.rows)
        printLine(shownValue(row), row);
}

} // namespace midair::samples
