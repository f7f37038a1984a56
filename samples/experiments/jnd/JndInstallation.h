#pragma once

#include "samples/experiments/jnd/Rehearsal.h"
#include "samples/experiments/jnd/TrialFile.h"
#include "samples/experiments/jnd/TrialRunner.h"
#include "samples/installations/shell/Installation.h"

#include <osgMidair/HapticPoints>

#include <memory>
#include <string>

namespace midair::samples
{

/// What the command line of an experiment says.
struct JndOptions
{
    std::string experiment = "oblique";
    std::string participant; ///< a code
    std::string results;     ///< file; empty: jnd-EXPERIMENT-CODE.csv
    double step = 0.0;       ///< 0: the experiment's own
    int times = 3;
    TrialTimes trial;
    double pressure_Pa = 10000.0;
    bool isSimulated = false;
    double threshold = -1.0; ///< of the simulated participant; below 0: the paper's mean
    double spread = 0.0;     ///< 0: two steps
    double lapse = 0.02;
    bool isShown = false; ///< lines can be seen
};

/// The paper's two experiments with a participant who answers by keys, or a simulated one.
class JndInstallation : public Installation
{
public:
    InstallationTitle title() const override;
    void addOptions(CLI::App& app) override;
    void arrange(osgMidair::HapticSettings& settings) override;
    void build(Stage& stage) override;
    void update(const Moment& now) override;
    void pressed(int key) override;
    bool isOver() const override;
    bool canRehearse() const override { return false; } ///< answers would be kept
    bool restsAlone() const override { return false; }
    std::string caption() const override;
    void report(nlohmann::ordered_json& figures) const override;

    /// The session, once it was built; null before.
    const TrialLog* log() const { return _log.get(); }
    const std::string& resultsFile() const { return _options.results; }

private:
    SessionHead head() const;
    void buildLine(Stage& stage);
    PlayedNow playedNow(const osgMidair::HapticStatistics& now);
    void take(const TrialRunner::Step& step);
    void play(std::optional<double> value);
    void place(double value);
    void beginWhenReady(const PlayedNow& played);
    void say(const std::string& text) const;
    bool isLive() const { return !_options.isSimulated; }

    JndOptions _options;
    SimulatedParticipant _simulated;
    std::unique_ptr<TrialLog> _log;
    std::unique_ptr<TrialRunner> _runner;
    osgMidair::HapticScene* _haptics = nullptr;
    osg::ref_ptr<osgMidair::HapticPoints> _line;
    osg::ref_ptr<osg::Node> _shown; ///< null where lines aren't shown
    std::optional<double> _playing; ///< value of the line that was set last; none yet
    bool _isOn = false;             ///< a line is wanted now
    double _wantedSince_s = 0.0;    ///< since when, of the steady clock
    Trial _figures;                 ///< of the line that was played last
    std::string _trouble;           ///< why nothing is played; empty: nothing of the kind
    bool _isBegun = false;          ///< somebody said that it may begin
    double _done_s = -1.0;          ///< when it was finished; -1: it isn't
    double _now_s = 0.0;
};

} // namespace midair::samples
