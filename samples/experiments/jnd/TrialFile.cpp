#include "samples/experiments/jnd/TrialFile.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Number.h"
#include "samples/shared/shards/Shards.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <sstream>
#include <utility>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr std::size_t kMostResults_bytes = std::size_t(1) << 24;
const std::string kMagic = "# midair-jnd 1";
const std::string kVoid = "# void ";
constexpr int kColumns = 10;

[[noreturn]] void refuse(const std::string& name, int line, const std::string& why)
{
    throw base::InputError(fmt::format("results \"{}\", line {}: {}", name, line, why));
}

std::string columnsOf(const LineExperiment& experiment)
{
    return fmt::format("trial,run,direction,value_{},answer,answer_s,line_s,rms,loudness,level_Pa",
                       experiment.unit);
}

SessionHead headOf(const std::string& line, const std::string& name)
{
    SessionHead head;
    try
    {
        nlohmann::json json =
            nlohmann::json::parse(line.substr(std::min<std::size_t>(2, line.size())));
        head.experiment = lineExperiment(json.at("experiment").get<std::string>());
        head.participant = json.at("participant").get<std::string>();
        head.staircase.maximum = json.at("maximum").get<double>();
        head.staircase.step = json.at("step").get<double>();
        head.staircase.times = json.at("times").get<int>();
        for (const char* key : {"experiment", "participant", "maximum", "step", "times"})
            json.erase(key);
        head.others = json;
    }
    catch (const nlohmann::json::exception& error)
    {
        refuse(name, 2, std::string("isn't the head of a session: ") + error.what());
    }
    const std::string problem = problemOf(head.staircase);
    if (!problem.empty()) refuse(name, 2, problem);
    return head;
}

Trial trialOf(const std::string& line, const std::string& name, int number)
{
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');)
        cells.push_back(cell);
    Trial trial;
    const std::array<double*, 6> numbers = {
        &trial.value, &trial.answer_s, &trial.line_s, &trial.rms, &trial.loudness, &trial.level_Pa};
    constexpr std::array<std::size_t, 6> kAt = {3, 5, 6, 7, 8, 9};
    bool isFine =
        cells.size() == kColumns && base::parseWhole(cells[0], trial.number) &&
        base::parseWhole(cells[1], trial.run) && (cells[2] == "down" || cells[2] == "up") &&
        (cells[4] == "yes" || cells[4] == "no") && (cells[2] == "down") == (trial.run % 2 == 1);
    for (std::size_t k = 0; isFine && k < numbers.size(); ++k)
        isFine = base::parseNumber(cells[kAt[k]], *numbers[k]) && *numbers[k] >= 0.0;
    if (!isFine) refuse(name, number, "\"" + line + "\" isn't a trial");
    trial.isFelt = cells[4] == "yes";
    return trial;
}

constexpr int kThresholds = 121;
constexpr int kSpreads = 25;

/// Answers at one value.
struct Answers
{
    int yes = 0, no = 0;
};

} // namespace

nlohmann::json SessionHead::toJson() const
{
    nlohmann::json json = others;
    json["experiment"] = experiment.name;
    json["participant"] = participant;
    json["maximum"] = staircase.maximum;
    json["step"] = staircase.step;
    json["times"] = staircase.times;
    return json;
}

std::string problemOfCode(const std::string& code)
{
    std::size_t letters = 0, digits = 0;
    while (letters < code.size() && code[letters] >= 'A' && code[letters] <= 'Z')
        ++letters;
    while (letters + digits < code.size() && code[letters + digits] >= '0' &&
           code[letters + digits] <= '9')
        ++digits;
    const bool isFine = letters >= 1 && letters <= 3 && digits >= 1 && digits <= 4 &&
                        letters + digits == code.size();
    if (isFine) return {};
    return "participant \"" + code +
           "\" should be a code, such as P07 (one to three capital letters and one to four "
           "digits): names aren't stored";
}

std::string headText(const SessionHead& head)
{
    return kMagic + "\n# " + head.toJson().dump() + "\n" + columnsOf(head.experiment) + "\n";
}

std::string lineOf(const Trial& trial)
{
    return fmt::format("{},{},{},{},{},{:.3f},{:.3f},{},{},{}\n",
                       trial.number,
                       trial.run,
                       trial.run % 2 == 1 ? "down" : "up",
                       base::exactNumber(trial.value),
                       trial.isFelt ? "yes" : "no",
                       trial.answer_s,
                       trial.line_s,
                       base::shortNumber(trial.rms),
                       base::shortNumber(trial.loudness),
                       base::shortNumber(trial.level_Pa));
}

std::string lineOfVoid(int trial, const std::string& why)
{
    std::string text = fmt::format("trial {} doesn't count: {}", trial, why);
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
    return kVoid + text + "\n";
}

TrialFile TrialFile::parse(const std::string& text, const std::string& name)
{
    std::istringstream in(text.substr(0, text.rfind('\n') + 1));
    std::string line;
    if (!std::getline(in, line) || line != kMagic)
        refuse(name, 1, "isn't \"" + kMagic + "\", so these are no results of midair-jnd");
    TrialFile file;
    if (!std::getline(in, line)) refuse(name, 2, "the head of the session is missing");
    file.head = headOf(line, name);
    file.staircase = Staircase(file.head.staircase);
    if (!std::getline(in, line) || line != columnsOf(file.head.experiment))
        refuse(name, 3, "should be \"" + columnsOf(file.head.experiment) + "\"");
    for (int number = 4; std::getline(in, line); ++number)
    {
        if (line.rfind(kVoid, 0) == 0)
        {
            file.voided.push_back(line.substr(kVoid.size()));
            continue;
        }
        const Trial trial = trialOf(line, name, number);
        const Staircase& asks = file.staircase;
        if (asks.isFinished()) refuse(name, number, "follows the last trial of the staircase");
        if (trial.number != asks.trials() + 1 || trial.run != asks.run() ||
            std::abs(trial.value - asks.value()) > 1e-9 * file.head.staircase.maximum)
            refuse(name,
                   number,
                   fmt::format("is trial {} of run {} at {}, where the staircase asks for trial {} "
                               "of run {} at {}",
                               trial.number,
                               trial.run,
                               base::exactNumber(trial.value),
                               asks.trials() + 1,
                               asks.run(),
                               base::exactNumber(asks.value())));
        file.staircase.answer(trial.isFelt);
        file.trials.push_back(trial);
    }
    return file;
}

TrialFile TrialFile::load(const std::string& path)
{
    return parse(base::readRegularFile(path, kMostResults_bytes, "results \"" + path + "\": "),
                 path);
}

TrialLog::TrialLog(const std::string& path, const SessionHead& head) :
    _path(path),
    _file(path, "results", 0600)
{
    const std::string begin = headText(head);
    const std::string& text = _file.text();
    if (text.size() < begin.size() && begin.compare(0, text.size(), text) == 0)
    {
        if (!text.empty())
            _dropped = fmt::format("results \"{}\" have an incomplete head; starting anew", path);
        _file.replace(begin);
        _results = TrialFile::parse(begin, path);
        return;
    }
    _results = TrialFile::parse(text, path);
    const std::string other = differenceOf(_results.head.toJson(), head.toJson());
    if (!other.empty())
        throw base::InputError(
            fmt::format("results \"{}\" belong to another session and are not changed: {} (there "
                        "and here); choose another file with --results",
                        path,
                        other));
    const std::string torn = _file.tornLine();
    if (torn.empty()) return;
    _dropped = fmt::format(
        "results \"{}\": the incomplete last line, \"{}\", is dropped; its trial is repeated",
        path,
        torn);
    _file.cutTornLine();
}

void TrialLog::add(bool isFelt, const Trial& played)
{
    Trial trial = played;
    Staircase& staircase = _results.staircase;
    trial.number = staircase.trials() + 1;
    trial.run = staircase.run();
    trial.value = staircase.value();
    trial.isFelt = isFelt;
    _file.append(lineOf(trial));
    _file.sync();
    staircase.answer(isFelt);
    _results.trials.push_back(trial);
}

void TrialLog::addVoid(const std::string& why)
{
    const std::string line = lineOfVoid(_results.staircase.trials() + 1, why);
    _file.append(line);
    _file.sync();
    _results.voided.push_back(line);
}

PsychometricFit fitTrials(const std::vector<Trial>& trials, const StaircaseSettings& settings)
{
    std::map<double, Answers> answers;
    for (const Trial& trial : trials)
        ++(trial.isFelt ? answers[trial.value].yes : answers[trial.value].no);
    const double least = 0.25 * settings.step;
    const double ratio = std::max(1.0, 0.25 * settings.maximum / least);
    std::vector<double> logs;
    std::vector<std::pair<double, double>> places; // threshold and logarithm of the spread
    double most = -INFINITY;
    for (int s = 0; s < kSpreads; ++s)
        for (int t = 0; t < kThresholds; ++t)
        {
            SimulatedParticipant person;
            person.lapse = kFitLapse;
            person.spread = least * std::pow(ratio, s / (kSpreads - 1.0));
            person.threshold = settings.maximum * t / (kThresholds - 1.0);
            double sum = 0.0;
            for (const auto& [value, count] : answers)
            {
                const double chance = person.chance(value);
                sum += count.yes * std::log(chance) + count.no * std::log(1.0 - chance);
            }
            logs.push_back(sum);
            places.emplace_back(person.threshold, std::log(person.spread));
            most = std::max(most, sum);
        }
    double weight = 0.0, mean = 0.0, square = 0.0, logSpread = 0.0;
    for (std::size_t k = 0; k < logs.size(); ++k)
    {
        const double w = std::exp(logs[k] - most);
        weight += w;
        mean += w * places[k].first;
        square += w * places[k].first * places[k].first;
        logSpread += w * places[k].second;
    }
    mean /= weight;
    return {mean,
            std::sqrt(std::max(0.0, square / weight - mean * mean)),
            std::exp(logSpread / weight)};
}

} // namespace midair::samples
