// midair-jnd: the paper's two experiments, with a real or a simulated participant.
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/experiments/jnd/JndCommands.h"
#include "samples/experiments/jnd/PlayedPoints.h"
#include "samples/experiments/jnd/Staircase.h"
#include "samples/experiments/jnd/TrialFile.h"
#include "samples/experiments/jnd/TrialRunner.h"
#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/Looks.h"

#include <osgMidair/HapticPoints>

#include <osg/MatrixTransform>
#include <osg/Shape>
#include <osgGA/GUIEventAdapter>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>

namespace
{

using namespace midair::samples;
using namespace midair;

/// Command-line options of an experiment.
struct JndOptions
{
    std::string experiment = "oblique";
    std::string participant; ///< a code
    std::string results;     ///< file; empty: jnd-EXPERIMENT-CODE.csv
    double step = 0.0;       ///< 0: the experiment's default
    int times = 3;
    TrialTimes trial;
    double pressure_Pa = 10000.0;
    bool isSimulated = false;
    double threshold = -1.0; ///< of the simulated participant; below 0: the paper's mean
    double spread = 0.0;     ///< 0: two steps
    double lapse = 0.02;
    bool isShown = false; ///< lines are visible
};

/// How long the end is shown to a participant.
constexpr double kFarewell_s = 10.0;
/// Pressure cap as a multiple of the lines' pressure, which varies by some 0.01 % with drive
/// levels.
constexpr double kMostShare = 1.01;

/// The paper's two experiments, answered by keys or by a simulated participant.
class JndInstallation : public Installation
{
public:
    InstallationTitle title() const override
    {
        return {"jnd",
                "The paper's two experiments: the smallest angle and the smallest shift at which a "
                "mid-air line feels different from the reference line. `midair-jnd rehearse` and "
                "`midair-jnd plot` need no array; each has a --help.",
                "Feel two lines with a fingertip: first a straight one, then another"};
    }

    void addOptions(CLI::App& app) override
    {
        const std::string group = "Experiment";
        app.add_option("--experiment", _options.experiment, "oblique or shifted")
            ->capture_default_str()
            ->group(group);
        app.add_option(
               "--participant", _options.participant, "A code such as P07; names aren't stored")
            ->required()
            ->group(group);
        app.add_option("--results",
                       _options.results,
                       "Results file; an existing one is continued [jnd-EXPERIMENT-CODE.csv]")
            ->type_name("FILE")
            ->group(group);
        app.add_option("--step", _options.step, "Step of the staircase [2.5 deg, 1.5 mm]")
            ->check(CLI::PositiveNumber)
            ->group(group);
        app.add_option("--times", _options.times, "Number of runs down, and of runs up")
            ->check(CLI::Range(1, 100))
            ->capture_default_str()
            ->group(group);
        const auto seconds = [&](const char* name, double& value, double least, const char* help)
        {
            app.add_option(name, value, help)
                ->check(CLI::Range(least, 60.0))
                ->capture_default_str()
                ->type_name("S")
                ->group(group);
        };
        seconds(
            "--reference", _options.trial.reference_s, 0.0, "Duration of the first line; 0: none");
        seconds("--between", _options.trial.between_s, 0.0, "Silence between the two lines");
        seconds("--line", _options.trial.line_s, 0.05, "Longest duration of the second line");
        seconds("--rest", _options.trial.rest_s, 0.0, "Silence after an answer");
        app.add_option("--pressure", _options.pressure_Pa, "Peak pressure of every line, Pa")
            ->check(CLI::Range(1.0, 1e5))
            ->capture_default_str()
            ->group(group);
        app.add_flag(
               "--show", _options.isShown, "Show the lines on the screen; not for participants")
            ->group(group);
        app.add_flag("--simulate", _options.isSimulated, "Simulate the participant, with --seed")
            ->group(group);
        app.add_option("--threshold",
                       _options.threshold,
                       "Threshold of the simulated participant [the paper's mean]")
            ->check(CLI::NonNegativeNumber)
            ->group(group);
        app.add_option("--spread", _options.spread, "Spread of its threshold [two steps]")
            ->check(CLI::PositiveNumber)
            ->group(group);
        app.add_option("--lapse", _options.lapse, "Share of its random answers")
            ->check(CLI::Range(0.0, 1.0))
            ->capture_default_str()
            ->group(group);
    }

    // The cap is just above the line's pressure, because a louder line is invalid.
    void arrange(osgMidair::HapticSettings& settings) override
    {
        settings.maxPressure = kMostShare * _options.pressure_Pa;
    }

    void build(Stage& stage) override
    {
        const LineExperiment& experiment = lineExperiment(_options.experiment);
        std::string problem = problemOfCode(_options.participant);
        if (!problem.empty()) throw base::InputError(problem);
        if (_options.step <= 0.0) _options.step = experiment.step;
        if (_options.results.empty())
            _options.results = fmt::format("jnd-{}-{}.csv", experiment.name, _options.participant);
        _simulated = {_options.threshold < 0.0 ? experiment.paperMean : _options.threshold,
                      _options.spread > 0.0 ? _options.spread : 2.0 * _options.step,
                      _options.lapse,
                      stage.seed};
        _haptics = &stage.haptics;
        const SessionHead session = head();
        problem = problemOf(session.staircase);
        if (problem.empty() && _options.isSimulated) problem = problemOf(_simulated);
        if (!problem.empty()) throw base::InputError(problem);
        _log = std::make_unique<TrialLog>(_options.results, session);
        if (!_log->dropped().empty()) say(_log->dropped());
        if (!_log->results().trials.empty())
            say(fmt::format("continuing \"{}\" after {} trials",
                            _options.results,
                            _log->results().trials.size()));
        _runner = std::make_unique<TrialRunner>(_options.trial);
        buildLine(stage);
        play(std::nullopt);
        if (_log->results().staircase.isFinished())
        {
            _runner->finish();
            _done_s = base::steadySeconds() - kFarewell_s;
            return;
        }
        _runner->ask(_log->results().staircase.value());
        _isBegun = _options.isSimulated;
    }

    void update(const Moment& now) override
    {
        _now_s = base::steadySeconds();
        const PlayedNow played = playedNow(now.statistics);
        beginWhenReady(played);
        take(_runner->step(_now_s, played));
        if (_options.isSimulated && _runner->phase() == TrialRunner::Phase::ANSWER)
            _runner->answer(
                _simulated.feels(_log->results().staircase.trials() + 1, _runner->value()));
        play(_runner->wanted());
    }

    void pressed(int key) override
    {
        using Key = osgGA::GUIEventAdapter::KeySymbol;
        if (key == Key::KEY_Space) _isBegun = true;
        if (_options.isSimulated) return;
        if (key == Key::KEY_Left || key == 'n' || key == 'N') _runner->answer(false);
        if (key == Key::KEY_Right || key == 'y' || key == 'Y') _runner->answer(true);
    }

    bool isOver() const override
    {
        if (_done_s < 0.0) return false;
        return _options.isSimulated || _now_s - _done_s >= kFarewell_s;
    }

    bool canRehearse() const override { return false; } ///< answers would be stored
    bool restsAlone() const override { return false; }
    std::string caption() const override
    {
        const std::string begin = fmt::format(
            "{} - trial {}: ", _options.participant, _log->results().staircase.trials() + 1);
        const std::string keys = "   left arrow: no    right arrow: yes";
        switch (_runner->phase())
        {
        case TrialRunner::Phase::WAITING:
            if (!_trouble.empty()) return "One moment: " + _trouble;
            return _isBegun ? "One moment" : "Ready? Press the space bar";
        case TrialRunner::Phase::REFERENCE:
            return begin + "first line";
        case TrialRunner::Phase::BETWEEN:
            return begin + "..";
        case TrialRunner::Phase::LINE:
        case TrialRunner::Phase::ANSWER:
            return begin + _log->results().head.experiment.question + keys;
        case TrialRunner::Phase::RESTING:
            return begin + "a moment";
        case TrialRunner::Phase::STOPPED:
            return begin + "doesn't count, once more (" + _trouble + ")";
        case TrialRunner::Phase::DONE:
            return "Thank you, that was all";
        }
        return {};
    }

    void report(nlohmann::ordered_json& figures) const override
    {
        if (!_log) return;
        const TrialFile& session = _log->results();
        figures["experiment"] = session.head.experiment.name;
        figures["participant"] = session.head.participant;
        figures["trials"] = session.trials.size();
        figures["void"] = session.voided.size();
        figures["finished"] = session.staircase.isFinished();
        figures["unit"] = session.head.experiment.unit;
        if (session.staircase.isFinished())
        {
            const PsychometricFit fit = fitTrials(session.trials, session.head.staircase);
            figures["threshold"] = fit.threshold;
            figures["thresholdError"] = fit.thresholdError;
            figures["meanOfTurns"] = thresholdOf(session.staircase.turns()).value;
        }
        figures["paper"] = session.head.experiment.paperMean;
        figures["paperDeviation"] = session.head.experiment.paperDeviation;
    }

    /// Returns null before the session is built.
    const TrialLog* log() const { return _log.get(); }
    const std::string& resultsFile() const { return _options.results; }

private:
    SessionHead head() const
    {
        SessionHead head;
        head.experiment = lineExperiment(_options.experiment);
        head.participant = _options.participant;
        head.staircase = {head.experiment.maximum, _options.step, _options.times};
        head.others["reference_s"] = _options.trial.reference_s;
        head.others["between_s"] = _options.trial.between_s;
        head.others["line_s"] = _options.trial.line_s;
        head.others["rest_s"] = _options.trial.rest_s;
        head.others["pressure_Pa"] = _options.pressure_Pa;
        head.others["array"] = _haptics->getArray();
        const std::string device = _haptics->getDevice();
        head.others["device"] = device.substr(0, device.find(':'));
        if (isLive())
            head.others["answers"] = "keys";
        else
            head.others["answers"] = {{"threshold", _simulated.threshold},
                                      {"spread", _simulated.spread},
                                      {"lapse", _simulated.lapse},
                                      {"seed", _simulated.seed}};
        return head;
    }

    void buildLine(Stage& stage)
    {
        _line = new osgMidair::HapticPoints;
        _line->setName("line");
        _line->setPressureUnit(osgMidair::HapticProperty::PASCAL);
        _line->setPressure(_options.pressure_Pa);
        stage.haptics.addChild(_line);
        if (!_options.isShown) return;
        // Along x, like the line at 0.
        const osg::ref_ptr<osg::Capsule> tube = new osg::Capsule(osg::Vec3(), 0.002F, kLine_m);
        tube->setRotation(osg::Quat(osg::PI_2, osg::Y_AXIS));
        const osg::ref_ptr<osg::MatrixTransform> place = new osg::MatrixTransform;
        place->addChild(solid(tube, kShownColors[1]));
        place->setNodeMask(0);
        stage.lit.addChild(place);
        stage.lit.addChild(glassBox(osg::Vec3d(0.0, 0.0, 0.0), osg::Vec3d(0.09, 0.03, 0.09)));
        _shown = place;
    }

    PlayedNow playedNow(const osgMidair::HapticStatistics& now)
    {
        PlayedNow played = playedPoints(*_haptics,
                                        now,
                                        _playing ? _log->results().head.experiment.points(*_playing)
                                                 : Eigen::Matrix3Xd(),
                                        _wantedSince_s);
        const osg::ref_ptr<const osgMidair::HapticField> field = _haptics->getField();
        if (!played.isPlayed) return played;
        if (now.fieldFrame != field->getFrameNumber()) return played;
        _figures.rms = now.rms;
        _figures.loudness = now.loudness;
        _figures.level_Pa = now.level_Pa;
        return played;
    }

    void take(const TrialRunner::Step& step)
    {
        if (!step.voided.empty())
        {
            _trouble = step.voided;
            say(fmt::format("trial {} doesn't count and is repeated: {}",
                            _log->results().staircase.trials() + 1,
                            step.voided));
            _log->addVoid(step.voided);
        }
        if (!step.counted) return;
        _trouble.clear();
        _figures.answer_s = step.answer_s;
        _figures.line_s = step.line_s;
        _log->add(*step.counted, _figures);
        const Staircase& staircase = _log->results().staircase;
        if (!staircase.isFinished())
        {
            _runner->ask(staircase.value());
            return;
        }
        _runner->finish();
        _done_s = _now_s;
    }

    // Between lines the whole scene is disabled, so it reports no missing points.
    void play(std::optional<double> value)
    {
        if (value && (!_isOn || value != _playing)) _wantedSince_s = _now_s;
        _isOn = value.has_value();
        if (_haptics->getEnabled() != _isOn) _haptics->setEnabled(_isOn);
        if (_shown) _shown->setNodeMask(value ? ~0U : 0U);
        if (!value || value == _playing) return;
        _playing = value;
        const Eigen::Matrix3Xd points = _log->results().head.experiment.points(*value);
        std::vector<osg::Vec3d> places;
        for (Eigen::Index k = 0; k < points.cols(); ++k)
            places.emplace_back(points(0, k), points(1, k), points(2, k));
        _line->setPoints(places);
        if (_shown) place(*value);
    }

    void place(double value)
    {
        auto& transform = static_cast<osg::MatrixTransform&>(*_shown);
        const bool isOblique = _log->results().head.experiment.kind == LineKind::OBLIQUE;
        transform.setMatrix(isOblique ? osg::Matrixd::rotate(base::toRadians(value), osg::Y_AXIS)
                                      : osg::Matrixd::translate(0.0, 0.0, 1e-3 * value));
    }

    void beginWhenReady(const PlayedNow& played)
    {
        if (_runner->phase() != TrialRunner::Phase::WAITING || !_isBegun) return;
        if (played.isReady)
        {
            _trouble.clear();
            _runner->begin(_now_s);
        }
        else if (_trouble != played.problem)
        {
            _trouble = played.problem;
            say("waiting: " + _trouble);
        }
    }

    void say(const std::string& text) const
    {
        std::fprintf(stderr, "midair-jnd: %s\n", text.c_str());
    }

    bool isLive() const { return !_options.isSimulated; }

    JndOptions _options;
    SimulatedParticipant _simulated;
    std::unique_ptr<TrialLog> _log;
    std::unique_ptr<TrialRunner> _runner;
    osgMidair::HapticScene* _haptics = nullptr;
    osg::ref_ptr<osgMidair::HapticPoints> _line;
    osg::ref_ptr<osg::Node> _shown; ///< null: lines are invisible
    std::optional<double> _playing; ///< value of the last line; none yet
    bool _isOn = false;             ///< a line is wanted now
    double _wantedSince_s = 0.0;    ///< since when, steady clock
    Trial _figures;                 ///< of the last line
    std::string _trouble;           ///< why nothing plays; may be empty
    bool _isBegun = false;          ///< somebody pressed the space bar
    double _done_s = -1.0;          ///< end of the session; -1: not yet
    double _now_s = 0.0;
};

/// Prints the result and draws it next to the results file.
int conclude(const JndInstallation& installation)
{
    if (!installation.log()) return 0;
    const TrialFile& session = installation.log()->results();
    std::printf("%s", summaryOf(session).c_str());
    if (session.trials.empty()) return 0;
    std::string picture = installation.resultsFile();
    if (picture.size() > 4 && picture.compare(picture.size() - 4, 4, ".csv") == 0)
        picture.resize(picture.size() - 4);
    try
    {
        drawSession(session, picture + ".png");
        // The picture contains the results, so it is as private as they are.
        std::filesystem::permissions(picture + ".png",
                                     std::filesystem::perms::owner_read |
                                         std::filesystem::perms::owner_write);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-jnd: %s\n", error.what());
        return 1;
    }
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    const std::string command = argc > 1 ? argv[1] : "";
    if (command == "rehearse") return rehearseCommand(argc - 1, argv + 1);
    if (command == "plot") return plotCommand(argc - 1, argv + 1);
    JndInstallation installation;
    const int status = runInstallation(installation, argc, argv);
    const int drawn = conclude(installation);
    return status != 0 ? status : drawn;
}
