// midair-coincide: measures the offset between where a focus is felt and where it is seen. A
// participant moves one fingertip to both.
#include "engine-bridge/calibration/StillTip.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/experiments/coincide/CoincidenceStudy.h"
#include "samples/experiments/jnd/PlayedPoints.h"
#include "samples/experiments/jnd/TrialFile.h"
#include "samples/experiments/jnd/TrialRunner.h"
#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/Looks.h"
#include "samples/shared/SettingOptions.h"

#include <osgMidair/HandSource>
#include <osgMidair/HapticPoints>

#include <osg/MatrixTransform>
#include <osg/Shape>
#include <osgGA/GUIEventAdapter>

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace
{

using namespace midair::samples;
using namespace midair;

/// Options of the command line.
struct CoincideOptions
{
    std::string participant; ///< a code
    std::string results;     ///< file; empty: coincide-CODE.csv
    int pairs = 12;
    double spread_m = 0.02;
    double pressure_Pa = 10000.0;
    double hold_s = 1.0;
    std::vector<double> middle = {0.0, 0.0, 0.0};
    std::vector<double> offset = {0.0, 0.0, 0.0}; ///< of the simulated participant
    double noise_m = 0.005;
    bool isSimulated = false;
};

constexpr float kBall_m = 0.008;           ///< radius
constexpr double kMostShare = 1.01;        ///< pressure cap as a multiple of the focus's pressure
constexpr double kEndless_s = 1e6;         ///< a trial waits until the fingertip comes
constexpr std::size_t kIndexTip = 10;      ///< of Hand::joints
constexpr double kFarewell_s = 10.0;       ///< how long the end is shown
constexpr double kSeen = 1.0, kFelt = 2.0; ///< values of the runner's trials

Eigen::Vector3d vectorOf(const std::vector<double>& numbers)
{
    return {numbers.at(0), numbers.at(1), numbers.at(2)};
}

class Coincide : public Installation
{
public:
    InstallationTitle title() const override
    {
        return {"coincide",
                "Measures the distance between where a focus is felt and where it is seen: the "
                "participant moves a fingertip to a visible ball and, blind, to a focus.",
                "Move a fingertip to what you see or feel, and hold still"};
    }

    void addOptions(CLI::App& app) override
    {
        const std::string group = "Experiment";
        const auto add = [&](const char* name, auto& value, const char* what)
        { return app.add_option(name, value, what)->group(group); };
        add("--participant", _options.participant, "A code such as P07, not a name")->required();
        add("--results",
            _options.results,
            "Results file; an existing one is continued [coincide-CODE.csv]")
            ->type_name("FILE");
        add("--pairs", _options.pairs, "Number of pairs of a seen and a felt trial")
            ->check(CLI::Range(2, 1000))
            ->capture_default_str();
        add("--middle", _options.middle, "Centre of the places, m")->expected(3);
        add("--spread", _options.spread_m, "Range of the places along each axis, m")
            ->transform(inUnit("m", base::parseQuantity))
            ->capture_default_str();
        add("--pressure", _options.pressure_Pa, "Pressure of the focus, Pa")
            ->check(CLI::Range(1.0, 1e5))
            ->capture_default_str();
        add("--hold", _options.hold_s, "How long to hold the fingertip still, s")
            ->check(CLI::Range(0.1, 10.0))
            ->capture_default_str();
        app.add_flag("--simulate", _options.isSimulated, "Simulate the participant, with --seed")
            ->group(group);
        add("--offset", _options.offset, "Offset of the simulated participant: felt minus seen, m")
            ->expected(3);
        add("--noise", _options.noise_m, "Noise of its fingertip per coordinate, m")
            ->check(CLI::Range(0.0, 0.1))
            ->capture_default_str();
    }

    void arrange(osgMidair::HapticSettings& settings) override
    {
        settings.maxPressure = kMostShare * _options.pressure_Pa;
    }

    void build(Stage& stage) override
    {
        const std::string problem = problemOfCode(_options.participant);
        if (!problem.empty()) throw base::InputError(problem);
        if (!_options.isSimulated && !stage.areHandsKnown)
            throw base::InputError("a hand tracker is needed: --hands SOURCE");
        if (_options.results.empty())
            _options.results = "coincide-" + _options.participant + ".csv";
        _haptics = &stage.haptics;
        _seed = stage.seed;
        _reacher = {vectorOf(_options.offset), _options.noise_m, _seed};
        _log = std::make_unique<ReachLog>(_options.results, head());
        TrialTimes times;
        times.reference_s = 0.0;
        times.between_s = 0.0;
        times.line_s = kEndless_s;
        times.rest_s = _options.isSimulated ? 0.0 : 1.0;
        _runner = std::make_unique<TrialRunner>(times);
        _still = bridge::StillTip(_options.hold_s);
        _focus = new osgMidair::HapticPoints;
        _focus->setName("focus");
        _focus->setPressureUnit(osgMidair::HapticProperty::PASCAL);
        _focus->setPressure(_options.pressure_Pa);
        stage.haptics.addChild(_focus);
        _ball = new osg::MatrixTransform;
        _ball->addChild(solid(new osg::Sphere(osg::Vec3(), kBall_m), kShownColors[1]));
        _ball->setNodeMask(0);
        stage.lit.addChild(_ball);
        _isBegun = _options.isSimulated;
        next();
    }

    void update(const Moment& now) override
    {
        _now_s = base::steadySeconds();
        const PlayedNow played = playedNow(now);
        if (_runner->phase() == TrialRunner::Phase::WAITING && _isBegun && played.isReady)
            _runner->begin(_now_s);
        const TrialRunner::Step step = _runner->step(_now_s, played);
        if (!step.voided.empty())
            std::fprintf(
                stderr, "midair-coincide: restarting the trial: %s\n", step.voided.c_str());
        if (step.counted) count();
        look();
        show(_runner->wanted());
    }

    void pressed(int key) override
    {
        if (key == osgGA::GUIEventAdapter::KEY_Space) _isBegun = true;
    }

    bool isOver() const override
    {
        if (_runner->phase() != TrialRunner::Phase::DONE) return false;
        return _options.isSimulated || _now_s - _done_s >= kFarewell_s;
    }
    bool canRehearse() const override { return false; }
    bool restsAlone() const override { return false; }
    std::vector<std::string> overlays() const override { return {}; } ///< blind
    std::string caption() const override
    {
        switch (_runner->phase())
        {
        case TrialRunner::Phase::WAITING:
            return _isBegun ? "One moment" : "Ready? Press the space bar";
        case TrialRunner::Phase::LINE:
            return fmt::format("{} of {}: {}",
                               _log->reaches().size() + 1,
                               2 * _options.pairs,
                               _trial.isFelt ? "find what you feel, and hold still"
                                             : "touch the ball, and hold still");
        case TrialRunner::Phase::DONE:
            return "Thank you, that was all";
        default:
            return "Take the hand away";
        }
    }

    void report(nlohmann::ordered_json& figures) const override
    {
        if (!_log) return;
        const Coincidence found = coincidenceOf(_log->reaches());
        figures["participant"] = _options.participant;
        figures["seen"] = found.seen;
        figures["felt"] = found.felt;
        if (found.seen < 2 || found.felt < 2) return;
        for (int axis = 0; axis < 3; ++axis)
        {
            figures["difference_m"].push_back(found.difference[axis]);
            figures["standardError_m"].push_back(found.standardError[axis]);
        }
    }

    const ReachLog* log() const { return _log.get(); }

private:
    std::string head() const
    {
        nlohmann::json head;
        head["participant"] = _options.participant;
        head["pairs"] = _options.pairs;
        head["middle_m"] = _options.middle;
        head["spread_m"] = _options.spread_m;
        head["pressure_Pa"] = _options.pressure_Pa;
        head["array"] = _haptics->getArray();
        head["seed"] = _seed;
        if (_options.isSimulated)
            head["simulated"] = {{"offset_m", _options.offset}, {"noise_m", _options.noise_m}};
        return head.dump();
    }

    /// Starts the first trial that is not yet in the file.
    void next()
    {
        const int number = static_cast<int>(_log->reaches().size());
        if (number >= 2 * _options.pairs)
        {
            _runner->finish();
            _done_s = base::steadySeconds();
            return;
        }
        _trial = trialOf(number, _seed, vectorOf(_options.middle), _options.spread_m);
        _runner->ask(_trial.isFelt ? kFelt : kSeen);
    }

    void count()
    {
        _log->add(_trial);
        next();
    }

    /// A seen trial doesn't need the array.
    PlayedNow playedNow(const Moment& now) const
    {
        PlayedNow played;
        played.isPlayed = true;
        if (_runner->wanted() != kFelt) return played;
        // Without a calibration, scene coordinates are array coordinates.
        return playedPoints(*_haptics, now.statistics, _wanted, _wantedSince_s);
    }

    /// Takes the fingertip's position once it is held still.
    void look()
    {
        const bool isAsked = _runner->phase() == TrialRunner::Phase::LINE;
        if (_options.isSimulated)
        {
            _trial.tip = _reacher.tip(static_cast<int>(_log->reaches().size()), _trial);
            if (isAsked) _runner->answer(true);
            return;
        }
        if (!_hands) _hands = handsOfScene();
        std::vector<osgMidair::Hand> hands;
        std::optional<bridge::StillTip::Sample> sample;
        if (_hands && _hands->getHands(_now_s, hands) && !hands.empty() &&
            hands.front().joints[kIndexTip].positionValid)
        {
            const osg::Vec3d& tip = hands.front().joints[kIndexTip].position;
            sample = bridge::StillTip::Sample{{tip.x(), tip.y(), tip.z()}, {}};
        }
        const auto held = _still.add(_now_s, sample);
        if (!held || !isAsked) return;
        _trial.tip = held->tip;
        _runner->answer(true);
    }

    osg::ref_ptr<osgMidair::HandSource> handsOfScene()
    {
        if (_haptics->getHandSource()) return _haptics->getHandSource();
        std::string error;
        const auto hands = osgMidair::openHandSource(_haptics->getHands(), error);
        if (!hands && !error.empty()) std::fprintf(stderr, "midair-coincide: %s\n", error.c_str());
        return hands;
    }

    void show(std::optional<double> value)
    {
        const bool isFelt = value == kFelt;
        _ball->setNodeMask(value == kSeen ? ~0U : 0U);
        _ball->setMatrix(
            osg::Matrixd::translate(_trial.place.x(), _trial.place.y(), _trial.place.z()));
        if (_haptics->getEnabled() != isFelt)
        {
            _haptics->setEnabled(isFelt);
            _wantedSince_s = _now_s;
        }
        if (!isFelt || (_wanted.cols() == 1 && _wanted.col(0) == _trial.place)) return;
        _wanted = _trial.place;
        _wantedSince_s = _now_s;
        _focus->setPoints({{_trial.place.x(), _trial.place.y(), _trial.place.z()}});
    }

    CoincideOptions _options;
    std::unique_ptr<ReachLog> _log;
    std::unique_ptr<TrialRunner> _runner;
    SimulatedReacher _reacher;
    bridge::StillTip _still;
    Reach _trial; ///< current trial
    osgMidair::HapticScene* _haptics = nullptr;
    osg::ref_ptr<osgMidair::HandSource> _hands;
    osg::ref_ptr<osgMidair::HapticPoints> _focus;
    osg::ref_ptr<osg::MatrixTransform> _ball;
    Eigen::Matrix3Xd _wanted; ///< last place of the focus
    double _wantedSince_s = 0.0, _now_s = 0.0, _done_s = 0.0;
    std::uint64_t _seed = 1;
    bool _isBegun = false; ///< somebody pressed the space bar
};

} // namespace

int main(int argc, char** argv)
{
    Coincide installation;
    const int status = runInstallation(installation, argc, argv);
    if (installation.log())
        std::fputs(coincidenceOf(installation.log()->reaches()).text().c_str(), stdout);
    return status;
}
