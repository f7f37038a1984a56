#include "samples/tools/calibrate/BoardCalibration.h"

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/boards/BoardFit.h"

#include <cstdio>
#include <fstream>
#include <iostream>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using base::InputError;

constexpr std::size_t kMostBytes = std::size_t(16) << 20U;

std::string readAll(const std::string& file)
{
    if (file != "-")
        return base::readRegularFile(file, kMostBytes, "measurements \"" + file + "\": ");
    std::string text(kMostBytes + 1, '\0');
    std::cin.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(std::cin.gcount()));
    if (text.size() > kMostBytes)
        throw InputError("stdin has over 16 MiB, should have at most as much");
    return text;
}

// A template to fill in: each distance as it should be, behind a comment sign.
std::string textOf(const haptics::BoardPlan& plan, const haptics::TransducerArray& array)
{
    std::string text = fmt::format(
        "# {} distances between corners of the boards of \"{}\", from the middle of a transducer "
        "to "
        "the middle of the other.\n"
        "# N:a is the transducer of board N at its first column and row, b at the last column of "
        "that row, c opposite a, d opposite b.\n"
        "# Write what you measure in place of the ?, as 0.1512, 151.2mm or 5.95in; a line that you "
        "can't measure you leave out.\n",
        plan.distances.size(),
        array.name);
    for (const haptics::PlannedDistance& one : plan.distances)
        text += fmt::format("{} {} ?   # transducers {} and {}, about {:.1f} mm\n",
                            one.from,
                            one.to,
                            one.fromTransducer,
                            one.toTransducer,
                            1e3 * one.distance_m);
    return text;
}

int printPlan(const BoardSettings& settings, const haptics::TransducerArray& array)
{
    haptics::BoardPlanOptions options;
    options.longest_m = settings.longest_m;
    options.sigma_m = settings.sigma_m;
    options.count = settings.count;
    const haptics::BoardPlan plan = haptics::planBoards(array, options);
    const std::string text = textOf(plan, array);
    if (settings.plan.empty())
        std::fputs(text.c_str(), stdout);
    else
    {
        std::ofstream file(settings.plan);
        file << text;
        file.close();
        if (!file) throw InputError("can't write the plan to \"" + settings.plan + "\"");
    }
    for (const std::string& problem : plan.problems)
        std::fprintf(stderr, "midair-calibrate: %s\n", problem.c_str());
    if (!plan.problems.empty())
    {
        std::fprintf(
            stderr,
            "midair-calibrate: these distances are not enough: a longer tape "
            "(--longest), more of them (--count), or a place off to the side, \"place hook "
            "about x y z\", that the boards are measured to\n");
        return 1;
    }
    std::fprintf(stderr,
                 "midair-calibrate: with %.2f mm a distance all boards are known to %.2f mm\n",
                 1e3 * settings.sigma_m,
                 1e3 * plan.uncertain_m);
    return 0;
}

void printReport(const haptics::BoardFitReport& report,
                 const haptics::BoardMeasurements& measurements)
{
    for (std::size_t k = 0; k < measurements.all.size(); ++k)
        if (report.residuals_m.size() > 0)
            std::printf("%-24s %+8.2f mm%s\n",
                        measurements.all[k].name().c_str(),
                        1e3 * report.residuals_m[static_cast<Eigen::Index>(k)],
                        report.leftOut[k] ? "  left out" : "");
    for (const haptics::BoardPose& board : report.boards)
        std::printf("board %3d  moved %6.2f mm, turned %5.2f degrees; known to %.2f mm, %.2f "
                    "degrees, from %d measurements\n",
                    board.board,
                    1e3 * board.moved_m,
                    board.turned_deg,
                    1e3 * board.uncertain_m,
                    board.uncertain_deg,
                    board.measurements);
    for (const haptics::MeasuredPlace& place : report.places)
        std::printf("place %s is at (%.4f, %.4f, %.4f) m\n",
                    place.name.c_str(),
                    place.position.x(),
                    place.position.y(),
                    place.position.z());
    if (report.delay_s != 0.0) std::printf("times have a delay of %.1f us\n", 1e6 * report.delay_s);
    std::printf("noise: %.2f mm a measurement\n", 1e3 * report.noise_m);
    for (const std::string& note : report.notes)
        std::printf("note: %s\n", note.c_str());
    for (const std::string& problem : report.problems)
        std::printf("not usable: %s\n", problem.c_str());
}

} // namespace

int calibrateBoards(const BoardSettings& settings)
{
    const haptics::TransducerArray array = haptics::TransducerArray::load(settings.array);
    if (settings.measurements.empty()) return printPlan(settings, array);
    const haptics::BoardMeasurements measurements = haptics::readBoardMeasurements(
        readAll(settings.measurements),
        settings.measurements == "-" ? "stdin" : settings.measurements,
        array);
    if (measurements.all.empty()) throw InputError("there are no measurements");
    haptics::Medium medium;
    medium.temperature_C = settings.temperature_C;
    std::string error;
    if (!medium.isValid(&error)) throw InputError(error);
    haptics::BoardFitOptions options;
    options.sigma_m = settings.sigma_m;
    options.mostUncertain_m = 5.0 * settings.sigma_m;
    options.soundSpeed_m_s = medium.soundSpeed();
    const haptics::BoardFitReport report = haptics::fitBoards(array, measurements, options);
    printReport(report, measurements);
    if (!report.usable) return 1;
    if (settings.out.empty()) return 0;
    report.array.save(settings.out);
    std::printf("array written to %s\n", settings.out.c_str());
    return 0;
}

} // namespace midair::samples
