#include "samples/tools/tune/TuneCommands.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"
#include "haptics/tuning/FocusCheck.h"
#include "samples/shared/views/Plot.h"

#include <Eigen/Core>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using base::InputError;

constexpr std::size_t kMostPlanBytes = std::size_t(1) << 30;

std::string textOf(const std::string& path)
{
    return base::readRegularFile(path, kMostPlanBytes, "\"" + path + "\" ");
}

void writeFile(const std::string& path, const std::string& text)
{
    std::ofstream out(path, std::ios::binary);
    out << text;
    out.flush();
    if (!out) throw InputError("\"" + path + "\" can't be written");
}

/// A plan, and what identifies its file.
struct ReadPlan
{
    haptics::TuningPlan plan;
    std::string sum;
};

ReadPlan readPlan(const std::string& path)
{
    const std::string text = textOf(path);
    return {haptics::tuningPlanFromCsv(text, path), haptics::planSum(text)};
}

haptics::TuningReadings readReadings(const std::string& path, const ReadPlan& plan)
{
    haptics::TuningReadings readings = haptics::readingsFromCsv(textOf(path), path, plan.plan);
    if (!readings.planSum.empty() && readings.planSum != plan.sum)
        throw InputError(fmt::format(
            "readings \"{}\" are of plan {}, this one is {}", path, readings.planSum, plan.sum));
    return readings;
}

haptics::TuningMethod methodOf(const std::string& name)
{
    std::vector<std::string> known;
    for (const auto method : {haptics::TuningMethod::SINGLE,
                              haptics::TuningMethod::HADAMARD,
                              haptics::TuningMethod::LEVELS,
                              haptics::TuningMethod::FOCUS})
    {
        known.emplace_back(haptics::tuningMethodName(method));
        if (name == known.back()) return method;
    }
    throw InputError(fmt::format("method is \"{}\"; known are {}{}",
                                 name,
                                 fmt::join(known, ", "),
                                 base::didYouMean(name, known)));
}

std::string lineOf(std::complex<double> value, const haptics::TuningPlan& plan)
{
    const bool isLevel =
        plan.method == haptics::TuningMethod::LEVELS || plan.method == haptics::TuningMethod::FOCUS;
    return isLevel ? base::exactNumber(value.real())
                   : base::exactNumber(value.real()) + "," + base::exactNumber(value.imag());
}

using haptics::TransducerState;
using nlohmann::json;

std::string stateName(TransducerState state)
{
    switch (state)
    {
    case TransducerState::FINE:
        return "FINE";
    case TransducerState::REVERSED:
        return "REVERSED";
    case TransducerState::DEAD:
        return "DEAD";
    case TransducerState::UNSURE:
    case TransducerState::NOT_MEASURED:
        break;
    }
    return "UNKNOWN";
}

json rowOf(const Eigen::Vector3d& v)
{
    return {v.x(), v.y(), v.z()};
}

} // namespace

int planTuning(const TuneArguments& arguments)
{
    haptics::TuningPlanOptions options;
    options.method = methodOf(arguments.method);
    options.dutyLevel = arguments.dutyLevel;
    options.temperature_C = arguments.fit.prior.temperature_C;
    if (!arguments.placesFile.empty())
        options.places = haptics::placesFromCsv(textOf(arguments.placesFile), arguments.placesFile);
    const Eigen::Index before = options.places.cols();
    const auto more = static_cast<Eigen::Index>(arguments.mic_m.size() / 3);
    options.places.conservativeResize(3, before + more);
    for (Eigen::Index p = 0; p < 3 * more; ++p)
        options.places(p % 3, before + p / 3) = arguments.mic_m[static_cast<std::size_t>(p)];
    if (options.places.cols() == 0)
        throw InputError("say where the microphone stands: --mic X Y Z, or --places FILE");
    const haptics::TuningPlan plan =
        haptics::makeTuningPlan(haptics::TransducerArray::load(arguments.array), options);
    const std::string out = arguments.out.empty() ? "plan.csv" : arguments.out;
    writeFile(out, haptics::toCsv(plan));
    std::cout << fmt::format("{} rows for {} place{} written to {}\n",
                             plan.size(),
                             plan.places.cols(),
                             plan.places.cols() == 1 ? "" : "s",
                             out);
    return TUNED;
}

int runTuning(const TuneArguments& arguments)
{
    const ReadPlan read = readPlan(arguments.plan);
    const haptics::TransducerArray array = haptics::TransducerArray::load(arguments.array);
    if (array.size() != read.plan.transducers)
        throw InputError(
            fmt::format("plan \"{}\" is for {} transducers of array \"{}\", array \"{}\" "
                        "has {}",
                        arguments.plan,
                        read.plan.transducers,
                        read.plan.array,
                        array.name,
                        array.size()));
    RunOptions options = arguments.run;
    options.plan = arguments.plan;
    if (!arguments.out.empty()) options.out = arguments.out;
    return runPlan(options, read.plan, read.sum, array);
}

int fitArray(const TuneArguments& arguments)
{
    const ReadPlan read = readPlan(arguments.plan);
    const haptics::TransducerArray array = haptics::TransducerArray::load(arguments.array);
    const haptics::TuningFit fit =
        haptics::fitTuning(array, read.plan, readReadings(arguments.readings, read), arguments.fit);
    std::cout << fit.text();
    if (!fit.usable()) return REFUSED;
    const std::string out = arguments.out.empty() ? "tuned.json" : arguments.out;
    fit.array.save(out);
    const std::string picture = arguments.picture.empty()
                                    ? std::filesystem::path(out).replace_extension(".svg").string()
                                    : arguments.picture;
    std::cout << "written to  " << out << std::endl;
    const std::string problem = drawTuning(fit, picture);
    if (problem.empty())
        std::cout << "picture     " << picture << "\n";
    else
        std::cerr << "midair-tune: " << problem << "\n";
    return TUNED;
}

int checkArray(const TuneArguments& arguments)
{
    const ReadPlan read = readPlan(arguments.plan);
    const haptics::FocusCheck check =
        haptics::checkFocus(haptics::TransducerArray::load(arguments.array),
                            read.plan,
                            readReadings(arguments.readings, read));
    std::cout << check.text();
    if (check.refusal.empty())
        std::cout << (check.passes()
                          ? "passed      each focus has 0.9 or more of its predicted level\n"
                          : "failed      a focus has less than 0.9 of its predicted level\n");
    return check.passes() ? TUNED : REFUSED;
}

int rehearse(const TuneArguments& arguments)
{
    const ReadPlan read = readPlan(arguments.plan);
    haptics::RehearsedInstrument instrument(
        haptics::TransducerArray::load(arguments.array), read.plan, arguments.rehearsal);
    if (!arguments.truth.empty()) instrument.truth().save(arguments.truth);
    haptics::TransducerArray tuned;
    if (!arguments.tuned.empty()) tuned = haptics::TransducerArray::load(arguments.tuned);
    const haptics::TransducerArray* foci = arguments.tuned.empty() ? nullptr : &tuned;
    if (read.plan.method == haptics::TuningMethod::FOCUS && foci == nullptr)
        throw InputError("the plan is one of foci: say with --tuned which array file makes them");
    if (!arguments.serves)
    {
        for (int row = 0; row < read.plan.size(); ++row)
            std::cout << lineOf(instrument.reading(row, foci), read.plan) << "\n";
        return TUNED;
    }
    for (std::string line; std::getline(std::cin, line);)
    {
        const std::vector<std::string> words = base::splitColumns(line);
        int row = -1;
        if (words.empty() || !base::parseWhole(words[0], row) || row < 0 || row >= read.plan.size())
            throw InputError("request \"" + line + "\"; it should begin with a row of the plan");
        std::cout << lineOf(instrument.reading(row, foci), read.plan) << std::endl;
    }
    return TUNED;
}

std::string drawTuning(const haptics::TuningFit& fit, const std::string& path)
{
    const haptics::TransducerArray& array = fit.array;
    json positions = json::array(), normals = json::array(), states = json::array(),
         phases = json::array(), gains = json::array();
    for (int i = 0; i < array.size(); ++i)
    {
        positions.push_back(rowOf(array.positions.col(i)));
        normals.push_back(rowOf(array.normals.col(i)));
        states.push_back(stateName(fit.states[static_cast<std::size_t>(i)]));
        const double phase_deg = base::toDegrees(array.phaseOffset_rad[i]);
        phases.push_back(phase_deg - 180.0 * std::round(phase_deg / 180.0));
        gains.push_back(array.gain[i]);
    }
    const std::size_t fine = fit.of(TransducerState::FINE).size(),
                      reversed = fit.of(TransducerState::REVERSED).size();
    return drawPlot(
        path,
        {{"kind", "tuning"},
         {"title",
          fmt::format("{}: {} of {} transducers play, {} of them reversed; {} dead",
                      array.name,
                      fine + reversed,
                      array.size(),
                      reversed,
                      fit.of(TransducerState::DEAD).size())},
         {"caption",
          fmt::format(
              "phases spread {:.1f} degrees (polarity aside), gains {:.1f} %; sides are seen "
              "from where they emit to",
              base::toDegrees(fit.phaseSpread_rad),
              100.0 * fit.gainSpread)},
         {"positions_m", positions},
         {"normals", normals},
         {"states", states},
         {"phase_deg", phases},
         {"gain", gains}});
}

} // namespace midair::samples
