#include "samples/experiments/jnd/JndCommands.h"

#include "haptics/base/InputError.h"
#include "samples/experiments/jnd/Staircase.h"
#include "samples/shared/ToolOptions.h"
#include "samples/shared/shards/Shards.h"
#include "samples/shared/views/CurvePlot.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>
#include <set>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace midair::samples
{

namespace
{

// Indices of the plots' colours.
constexpr int kOurs = 0;
constexpr int kPapers = 1;
constexpr int kFits = 2;

Curve marksOf(const std::vector<double>& x,
              const std::vector<double>& y,
              const std::string& name,
              CurveMark mark)
{
    Curve curve;
    curve.x = Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
    curve.y = Eigen::Map<const Eigen::VectorXd>(y.data(), static_cast<Eigen::Index>(y.size()));
    curve.name = name;
    curve.mark = mark;
    curve.isJoined = mark == CurveMark::NONE;
    curve.color = kOurs;
    return curve;
}

CurveBand paperBand(const LineExperiment& experiment)
{
    CurveBand band;
    band.low = experiment.paperMean - experiment.paperDeviation;
    band.high = experiment.paperMean + experiment.paperDeviation;
    band.middle = experiment.paperMean;
    band.name = fmt::format("paper: {:.1f} ± {:.1f} {}",
                            experiment.paperMean,
                            experiment.paperDeviation,
                            experiment.unit);
    band.color = kPapers;
    return band;
}

// A bar across the curve at half of the answers.
std::vector<Curve> fittedBar(const PsychometricFit& fit, const LineExperiment& experiment)
{
    const double low = std::max(0.0, fit.threshold - fit.thresholdError);
    const double high = std::min(experiment.maximum, fit.threshold + fit.thresholdError);
    std::vector<Curve> bar = {marksOf({low, high}, {0.5, 0.5}, "", CurveMark::NONE),
                              marksOf({fit.threshold},
                                      {0.5},
                                      fmt::format("threshold by the fit: {:.1f} ± {:.1f} {}",
                                                  fit.threshold,
                                                  fit.thresholdError,
                                                  experiment.unit),
                                      CurveMark::DISC)};
    for (Curve& curve : bar)
        curve.color = kFits;
    return bar;
}

CurvePanel staircasePanel(const TrialFile& session)
{
    const LineExperiment& experiment = session.head.experiment;
    CurvePanel panel;
    panel.xName = "trial";
    panel.yName = fmt::format("{} ({})", experiment.quantity, experiment.unit);
    panel.xLow = 0.0;
    panel.xHigh = static_cast<double>(session.trials.size()) + 1.0;
    panel.yHigh = session.head.staircase.maximum * 1.05;
    panel.bands = {paperBand(experiment)};
    const auto add = [&](const std::string& name, CurveMark mark, const std::vector<bool>& answers)
    {
        std::vector<double> x, y;
        for (const Trial& trial : session.trials)
        {
            if (std::count(answers.begin(), answers.end(), trial.isFelt) == 0) continue;
            x.push_back(trial.number);
            y.push_back(trial.value);
        }
        if (!x.empty()) panel.curves.push_back(marksOf(x, y, name, mark));
    };
    add("", CurveMark::NONE, {true, false});
    add("felt", CurveMark::DISC, {true});
    add("not felt", CurveMark::RING, {false});
    return panel;
}

CurvePanel sharePanel(const TrialFile& session, const PsychometricFit& fit)
{
    const LineExperiment& experiment = session.head.experiment;
    std::map<double, std::pair<int, int>> counts; // number felt, number of all
    for (const Trial& trial : session.trials)
    {
        counts[trial.value].first += trial.isFelt ? 1 : 0;
        ++counts[trial.value].second;
    }
    CurvePanel panel;
    panel.xName = fmt::format("{} ({})", experiment.quantity, experiment.unit);
    panel.yName = "share felt";
    panel.xLow = 0.0;
    panel.xHigh = session.head.staircase.maximum;
    panel.yHigh = 1.08;
    panel.bands = {paperBand(experiment)};
    panel.bands.front().isOfX = true;
    SimulatedParticipant person;
    person.threshold = fit.threshold;
    person.spread = fit.spread;
    person.lapse = kFitLapse;
    std::vector<double> x, y;
    for (const auto& [value, count] : counts)
    {
        x.push_back(value);
        y.push_back(static_cast<double>(count.first) / count.second);
    }
    Curve curve = marksOf({}, {}, "", CurveMark::NONE);
    curve.x = Eigen::VectorXd::LinSpaced(200, 0.0, panel.xHigh);
    curve.y = curve.x.unaryExpr([&](double value) { return person.chance(value); });
    curve.color = kFits;
    panel.curves = {marksOf(x, y, "answers", CurveMark::RING), curve};
    for (const Curve& part : fittedBar(fit, experiment))
        panel.curves.push_back(part);
    return panel;
}

std::string captionOf(const TrialFile& session)
{
    const Threshold threshold = thresholdOf(session.staircase.turns());
    const std::string& unit = session.head.experiment.unit;
    if (!session.staircase.isFinished())
        return fmt::format("{} trials so far, not finished", session.trials.size());
    std::string caption = fmt::format("{} trials; mean of {} turns {:.1f} {}",
                                      session.trials.size(),
                                      session.staircase.turns().size(),
                                      threshold.value,
                                      unit);
    if (threshold.bounds > 0)
        caption += fmt::format("; {} of the turns at an end of the range", threshold.bounds);
    return caption;
}

/// Returns the plot of a session with at least one trial: the staircase with the paper's threshold
/// next to the found one, and below it the share of "yes" at each value with the fitted curve.
CurvePlot plotOf(const TrialFile& session)
{
    const PsychometricFit fit = fitTrials(session.trials, session.head.staircase);
    CurvePlot plot;
    plot.title =
        fmt::format("{}, participant {}", session.head.experiment.title, session.head.participant);
    plot.caption = captionOf(session);
    plot.panels = {staircasePanel(session), sharePanel(session, fit)};
    return plot;
}

/// Returns mean and deviation of the thresholds.
Spread groupOf(const std::vector<TrialFile>& sessions)
{
    std::vector<double> found;
    found.reserve(sessions.size());
    for (const TrialFile& session : sessions)
        found.push_back(fitTrials(session.trials, session.head.staircase).threshold);
    return Spread(found);
}

/// Returns the plot of finished sessions of one experiment: each threshold with its uncertainty,
/// then mean and standard deviation next to the paper's.
CurvePlot plotOf(const std::vector<TrialFile>& sessions)
{
    const LineExperiment& experiment = sessions.front().head.experiment;
    const Spread group = groupOf(sessions);
    CurvePanel panel;
    panel.xName = "participant; bars: standard deviation of the fit, of participants for the means";
    panel.yName = fmt::format("threshold ({})", experiment.unit);
    panel.xLow = 0.0;
    panel.xHigh = static_cast<double>(sessions.size()) + 3.0;
    panel.yHigh = experiment.maximum * 1.02;
    panel.bands = {paperBand(experiment)};
    const auto add =
        [&](double x, double value, double deviation, const std::string& name, int color)
    {
        Curve bar = marksOf(
            {x, x}, {std::max(0.0, value - deviation), value + deviation}, "", CurveMark::NONE);
        Curve mark = marksOf({x}, {value}, "", CurveMark::DISC);
        bar.color = mark.color = color;
        panel.curves.push_back(bar);
        panel.curves.push_back(mark);
        panel.xTicks.emplace_back(x, name);
    };
    double x = 1.0;
    for (const TrialFile& session : sessions)
    {
        const PsychometricFit fit = fitTrials(session.trials, session.head.staircase);
        add(x++, fit.threshold, fit.thresholdError, session.head.participant, kOurs);
    }
    add(x++, group.mean, group.deviation, "mean", kOurs);
    add(x, experiment.paperMean, experiment.paperDeviation, "paper", kPapers);
    CurvePlot plot;
    plot.title = fmt::format("{}: {} participants", experiment.title, sessions.size());
    plot.caption = fmt::format("mean {:.1f}, standard deviation {:.1f} {}; paper {:.1f} and {:.1f}",
                               group.mean,
                               group.deviation,
                               experiment.unit,
                               experiment.paperMean,
                               experiment.paperDeviation);
    plot.panels = {panel};
    return plot;
}

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

/// Returns the conditions that must be equal to average thresholds: everything except the
/// participant.
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
        return text + "  not finished; the same command continues it\n";
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
        text += fmt::format("  {} of {} turns were at an end of the range: the threshold may be "
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
    CLI::App app("Runs the staircases with simulated participants, without an array, and prints "
                 "how well their thresholds are found.",
                 "midair-jnd rehearse");
    std::string name;
    int sessions = 1000, times = 3;
    double step = 0.0, lapse = 0.02;
    std::uint64_t seed = 1;
    app.add_option("--experiment", name, "oblique or shifted [both]");
    app.add_option("--sessions", sessions, "Sessions per row")
        ->check(CLI::Range(2, 1000000))
        ->capture_default_str();
    app.add_option("--step", step, "Step of the staircase [2.5 deg, 1.5 mm]")
        ->check(CLI::PositiveNumber);
    app.add_option("--times", times, "Number of runs down, and of runs up")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    app.add_option("--lapse", lapse, "Share of random answers")
        ->check(CLI::Range(0.0, 1.0))
        ->capture_default_str();
    app.add_option("--seed",
                   seed,
                   "Random seed of the first session; later sessions use the following numbers")
        ->capture_default_str();
    int status = EXIT_DONE;
    if (!parseTool(app, argc, argv, status)) return status;
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
    CLI::App app("Prints and draws results next to the paper's: for one file its staircase, for "
                 "several their thresholds.",
                 "midair-jnd plot");
    std::vector<std::string> files;
    std::string out = "jnd.png";
    app.add_option("files", files, "Results files of one experiment")->required();
    app.add_option("--out", out, "Picture: .png, .svg or .pdf")->capture_default_str();
    int status = EXIT_DONE;
    if (!parseTool(app, argc, argv, status)) return status;
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
                                       "\" belong to another experiment than \"" + files.front() +
                                       "\"");
            const std::string other =
                differenceOf(conditionsOf(sessions.front()), conditionsOf(session));
            if (!other.empty())
                throw base::InputError(
                    fmt::format("results \"{}\" can't be averaged with \"{}\": {} (there and here)",
                                file,
                                files.front(),
                                other));
            if (files.size() > 1 && !session.staircase.isFinished())
                throw base::InputError("results \"" + file + "\" aren't finished");
            if (!codes.insert(session.head.participant).second)
                throw base::InputError("results \"" + file + "\" belong to participant " +
                                       session.head.participant + ", who appears twice");
        }
        if (sessions.size() > 1)
        {
            const Spread group = groupOf(sessions);
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
