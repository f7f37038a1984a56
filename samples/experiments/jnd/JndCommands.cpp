#include "samples/experiments/jnd/JndCommands.h"

#include "haptics/base/InputError.h"
#include "samples/experiments/jnd/JndPlot.h"
#include "samples/experiments/jnd/PsychometricFit.h"
#include "samples/experiments/jnd/Rehearsal.h"
#include "samples/shared/shards/PartFile.h"

#include <cstdio>
#include <exception>
#include <set>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace midair::samples
{

namespace
{

void draw(const CurvePlot& plot, const std::string& path)
{
    const std::string problem = drawCurves(path, plot);
    if (!problem.empty()) throw base::InputError(problem);
    std::printf("%s\n", path.c_str());
}

void printRow(double threshold, double spread, const Rehearsal& found)
{
    std::printf("  %6.1f  %6.1f   %5.1f  %+5.2f ± %.2f  %5.2f  %5.1f %%  %5.1f %%  %+5.2f ± %.2f  "
                "%5.2f  %5.1f %%   %4.1f %%\n",
                threshold,
                spread,
                found.trials,
                found.fit.bias,
                found.fit.biasError,
                found.fit.deviation,
                100.0 * found.fit.within,
                100.0 * found.covered,
                found.turns.bias,
                found.turns.biasError,
                found.turns.deviation,
                100.0 * found.turns.within,
                100.0 * found.bounded);
    std::fflush(stdout);
}

void printRehearsal(const LineExperiment& experiment,
                    const StaircaseSettings& settings,
                    double lapse,
                    int sessions,
                    std::uint64_t seed)
{
    std::printf(
        "%s: %d simulated sessions a row, from %g down by %g %s, %d times down and up, lapse %g\n"
        "                          fit of all answers                     mean of the turns\n"
        "  true, %s  spread  trials  bias          sd     within   95 %%     bias          sd     "
        "within   bound\n",
        experiment.title.c_str(),
        sessions,
        settings.maximum,
        settings.step,
        experiment.unit.c_str(),
        settings.times,
        lapse,
        experiment.unit.c_str());
    const double mean = experiment.paperMean, deviation = experiment.paperDeviation;
    for (const double threshold : {mean - deviation, mean, mean + deviation})
        for (const double steps : {0.5, 1.0, 2.0, 3.0})
        {
            const SimulatedParticipant person{threshold, steps * settings.step, lapse, seed};
            printRow(threshold, person.spread, rehearse(person, settings, sessions));
        }
}

int failed(const std::exception& error)
{
    std::fprintf(stderr, "midair-jnd: %s\n", error.what());
    return 2;
}

/// Returns what has to be alike for thresholds to have a mean: all of a session but whose it is.
nlohmann::json conditionsOf(const TrialFile& session)
{
    nlohmann::json conditions = session.head.toJson();
    conditions.erase("participant");
    if (conditions["answers"].is_object()) conditions["answers"] = "simulated";
    return conditions;
}

} // namespace

std::string summaryOf(const TrialFile& session)
{
    const LineExperiment& experiment = session.head.experiment;
    std::string text = fmt::format("{}, participant {}: {} trials, {} void\n",
                                   experiment.title,
                                   session.head.participant,
                                   session.trials.size(),
                                   session.voided.size());
    if (!session.staircase.isFinished())
        return text + "  not finished; the same command goes on with it\n";
    const Threshold turns = thresholdOf(session.staircase.turns());
    const PsychometricFit fit = fitTrials(session.trials, session.head.staircase);
    text += fmt::format("  threshold, fit of all answers  {:.2f} ± {:.2f} {}, spread {:.2f}\n"
                        "  threshold, mean of the turns   {:.2f} {} (standard deviation {:.2f})\n"
                        "  paper, over its participants   {:.1f} ± {:.1f} {}\n",
                        fit.threshold,
                        fit.thresholdError,
                        experiment.unit,
                        fit.spread,
                        turns.value,
                        experiment.unit,
                        turns.deviation,
                        experiment.paperMean,
                        experiment.paperDeviation,
                        experiment.unit);
    if (turns.bounds > 0)
        text += fmt::format("  {} of {} turns were at an end of the range: the threshold may lie "
                            "outside, or the line wasn't felt\n",
                            turns.bounds,
                            session.staircase.turns().size());
    return text;
}

void drawSession(const TrialFile& session, const std::string& path)
{
    draw(plotOf(session), path);
}

int rehearseCommand(int argc, char** argv)
{
    CLI::App app("Leads simulated participants through the staircases, without an array, and "
                 "prints how well their thresholds are found.",
                 "midair-jnd rehearse");
    std::string name;
    int sessions = 1000, times = 3;
    double step = 0.0, lapse = 0.02;
    std::uint64_t seed = 1;
    app.add_option("--experiment", name, "oblique or shifted [both]");
    app.add_option("--sessions", sessions, "Sessions a row")
        ->check(CLI::Range(2, 1000000))
        ->capture_default_str();
    app.add_option("--step", step, "Of the staircase [2.5 deg, 1.5 mm]")
        ->check(CLI::PositiveNumber);
    app.add_option("--times", times, "Times down and up")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    app.add_option("--lapse", lapse, "Share of answers by a coin")
        ->check(CLI::Range(0.0, 1.0))
        ->capture_default_str();
    app.add_option("--seed", seed, "Of the first session; the others follow")
        ->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try
    {
        if (!name.empty()) lineExperiment(name);
        for (const LineExperiment& experiment : lineExperiments())
        {
            if (!name.empty() && experiment.name != name) continue;
            const StaircaseSettings settings{
                experiment.maximum, step > 0.0 ? step : experiment.step, times};
            const std::string problem = problemOf(settings);
            if (!problem.empty()) throw base::InputError(problem);
            printRehearsal(experiment, settings, lapse, sessions, seed);
        }
    }
    catch (const std::exception& error)
    {
        return failed(error);
    }
    return 0;
}

int plotCommand(int argc, char** argv)
{
    CLI::App app("Prints and draws what sessions found, beside the paper's: one file, its "
                 "staircase; several, their thresholds.",
                 "midair-jnd plot");
    std::vector<std::string> files;
    std::string out = "jnd.png";
    app.add_option("files", files, "Results of sessions of one experiment")->required();
    app.add_option("--out", out, "Picture: .png, .svg or .pdf")->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try
    {
        std::vector<TrialFile> sessions;
        std::set<std::string> codes;
        for (const std::string& file : files)
        {
            sessions.push_back(TrialFile::load(file));
            const TrialFile& session = sessions.back();
            std::printf("%s", summaryOf(session).c_str());
            if (session.trials.empty())
                throw base::InputError("results \"" + file + "\" have no trials");
            if (session.head.experiment.name != sessions.front().head.experiment.name)
                throw base::InputError("results \"" + file +
                                       "\" are of another experiment than \"" + files.front() +
                                       "\"");
            const std::string other =
                differenceOf(conditionsOf(sessions.front()), conditionsOf(session));
            if (!other.empty())
                throw base::InputError("results \"" + file + "\" can't be averaged with \"" +
                                       files.front() + "\": " + other + " (there, and here)");
            if (files.size() > 1 && !session.staircase.isFinished())
                throw base::InputError("results \"" + file + "\" aren't finished");
            if (!codes.insert(session.head.participant).second)
                throw base::InputError("results \"" + file + "\" are of participant " +
                                       session.head.participant + ", who is there twice");
        }
        if (sessions.size() > 1)
        {
            const GroupThreshold group = groupOf(sessions);
            std::printf("mean of %zu participants %.2f, standard deviation %.2f %s\n",
                        sessions.size(),
                        group.mean,
                        group.deviation,
                        sessions.front().head.experiment.unit.c_str());
        }
        draw(sessions.size() == 1 ? plotOf(sessions.front()) : plotOf(sessions), out);
    }
    catch (const std::exception& error)
    {
        return failed(error);
    }
    return 0;
}

} // namespace midair::samples
