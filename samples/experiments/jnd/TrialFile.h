#pragma once

#include "samples/experiments/jnd/Staircase.h"
#include "samples/experiments/paper/LineExperiment.h"
#include "samples/shared/shards/LineJournal.h"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace midair::samples
{

/// A valid trial with its answer and figures.
struct Trial
{
    int number = 0;        ///< from 1
    int run = 0;           ///< of the staircase, from 1
    double value = 0.0;    ///< in the experiment's unit
    bool isFelt = false;   ///< the answer
    double answer_s = 0.0; ///< from the start of the line to the answer
    double line_s = 0.0;   ///< duration of the line
    double rms = 0.0;      ///< of the played field, at its control points
    double loudness = 0.0; ///< E of that field
    double level_Pa = 0.0; ///< its pressure, peak
};

/// Everything that a session's results depend on; the head of its file.
struct SessionHead
{
    LineExperiment experiment;
    std::string participant; ///< a code, "P07"; never a name
    StaircaseSettings staircase;
    nlohmann::json others; ///< other conditions that must be equal to continue: times, array,
                           ///< source of answers

    nlohmann::json toJson() const;
};

/// Returns what is wrong with a participant's code, or an empty text. A code has one to three
/// capital letters and one to four digits, so that no name is stored by mistake.
std::string problemOfCode(const std::string& code);

/// The results of a session.
struct TrialFile
{
    SessionHead head;
    std::vector<Trial> trials;
    std::vector<std::string> voided; ///< a sentence for each trial that doesn't count
    Staircase staircase{StaircaseSettings{}};

    /// Parses all complete lines of \a text; \a name is the file in messages. Throws
    /// base::InputError if it isn't such a file or doesn't match the staircase.
    static TrialFile parse(const std::string& text, const std::string& name);
    static TrialFile load(const std::string& path);
};

/// Returns the first lines of a file of \a head.
std::string headText(const SessionHead& head);

/// Returns the line of a trial, and that of a trial that doesn't count.
std::string lineOf(const Trial& trial);
std::string lineOfVoid(int trial, const std::string& why);

/// The results file of a running session: each answer is on disk before the next trial begins, and
/// an interrupted session continues.
class TrialLog
{
public:
    /// Opens \a path to continue it, or creates it. Throws base::InputError, and keeps the file, if
    /// another run has it, or if it has other content or belongs to another experiment, participant
    /// or setting.
    TrialLog(const std::string& path, const SessionHead& head);

    const TrialFile& results() const { return _results; }
    /// Returns a sentence on what was dropped, or an empty text.
    const std::string& dropped() const { return _dropped; }

    /// Adds the answer to the staircase's current value with the figures of \a played. Returns once
    /// it is on disk. Throws base::InputError if it can't be written.
    void add(bool isFelt, const Trial& played);
    /// Records that the current trial doesn't count.
    void addVoid(const std::string& why);

private:
    const std::string _path;
    LineJournal _file;
    TrialFile _results;
    std::string _dropped;
};

/// Estimates of threshold and spread from all answers. The model is that of SimulatedParticipant
/// with a lapse of kFitLapse. Values are posterior means and deviations, with a uniform prior of
/// thresholds from 0 to the maximum, and a log-uniform prior of spreads from a quarter of a step to
/// a quarter of the maximum. The asked values depend only on answers, so the likelihood needs no
/// model of the staircase.
struct PsychometricFit
{
    double threshold = 0.0;
    double thresholdError = 0.0; ///< standard deviation of the posterior
    double spread = 0.0;         ///< geometric mean
};

/// Assumed share of random answers.
constexpr double kFitLapse = 0.02;

/// Fits \a trials, at least one.
PsychometricFit fitTrials(const std::vector<Trial>& trials, const StaircaseSettings& settings);

} // namespace midair::samples
