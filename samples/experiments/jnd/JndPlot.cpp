#include "samples/experiments/jnd/JndPlot.h"

#include "samples/experiments/jnd/PsychometricFit.h"
#include "samples/experiments/jnd/Rehearsal.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

// Places in the plots' colours.
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

// A bar across the curve, where half of the answers are yes.
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
    std::vector<double> x, y;
    for (const Trial& trial : session.trials)
    {
        x.push_back(trial.number);
        y.push_back(trial.value);
    }
    panel.curves.push_back(marksOf(x, y, "", CurveMark::NONE));
    for (const bool isFelt : {true, false})
    {
        std::vector<double> at, value;
        for (const Trial& trial : session.trials)
        {
            if (trial.isFelt != isFelt) continue;
            at.push_back(trial.number);
            value.push_back(trial.value);
        }
        if (!at.empty())
            panel.curves.push_back(marksOf(at,
                                           value,
                                           isFelt ? "felt" : "not felt",
                                           isFelt ? CurveMark::DISC : CurveMark::RING));
    }
    return panel;
}

CurvePanel sharePanel(const TrialFile& session, const PsychometricFit& fit)
{
    const LineExperiment& experiment = session.head.experiment;
    std::map<double, std::pair<int, int>> counts; // felt, of all
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
        return fmt::format("{} trials so far; the staircase isn't finished", session.trials.size());
    std::string caption = fmt::format("{} trials; mean of {} turns {:.1f} {}",
                                      session.trials.size(),
                                      session.staircase.turns().size(),
                                      threshold.value,
                                      unit);
    if (threshold.bounds > 0)
        caption += fmt::format("; {} of the turns at an end of the range", threshold.bounds);
    return caption;
}

} // namespace

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

GroupThreshold groupOf(const std::vector<TrialFile>& sessions)
{
    GroupThreshold group;
    const auto count = static_cast<double>(sessions.size());
    std::vector<double> found;
    for (const TrialFile& session : sessions)
        found.push_back(fitTrials(session.trials, session.head.staircase).threshold);
    for (const double value : found)
        group.mean += value / count;
    for (const double value : found)
        group.deviation += std::pow(value - group.mean, 2.0) / std::max(1.0, count - 1.0);
    group.deviation = std::sqrt(group.deviation);
    return group;
}

CurvePlot plotOf(const std::vector<TrialFile>& sessions)
{
    const LineExperiment& experiment = sessions.front().head.experiment;
    const GroupThreshold group = groupOf(sessions);
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

} // namespace midair::samples
