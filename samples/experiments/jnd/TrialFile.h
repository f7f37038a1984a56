#pragma once

#include "samples/experiments/jnd/Staircase.h"
#include "samples/experiments/paper/LineExperiment.h"
#include "samples/shared/shards/LineJournal.h"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace midair::samples
{

/// What was played in a trial that counts, and what was answered.
struct Trial
{
    int number = 0;        ///< from 1
    int run = 0;           ///< of the staircase, from 1
    double value = 0.0;    ///< in the experiment's unit
    bool isFelt = false;   ///< the answer
    double answer_s = 0.0; ///< from the line's beginning to the answer
    double line_s = 0.0;   ///< for which the line was played
    double rms = 0.0;      ///< of the field as it was played, at its control points
    double loudness = 0.0; ///< E of that field
    double level_Pa = 0.0; ///< its pressure, peak
};

/// What a session is of: all that its results depend on. A file of results begins with it.
struct SessionHead
{
    LineExperiment experiment;
    std::string participant; ///< a code, "P07"; never a name
    StaircaseSettings staircase;
    nlohmann::json others; ///< what else has to be alike when it goes on: times, array, who answers

    nlohmann::json toJson() const;
};

/// Returns what is wrong with a participant's code; empty: nothing. One to three capital letters
/// and one to four digits, so that no name gets in by mistake.
std::string problemOfCode(const std::string& code);

/// The results of a session, as a file has them.
struct TrialFile
{
    SessionHead head;
    std::vector<Trial> trials;
    std::vector<std::string> voided; ///< a sentence for each trial that doesn't count
    Staircase staircase{StaircaseSettings{}};

    /// Reads all whole lines of \a text; \a name is of the file, for messages. Throws
    /// base::InputError for what isn't such a file, or isn't what the staircase would have asked.
    static TrialFile parse(const std::string& text, const std::string& name);
    static TrialFile load(const std::string& path);
};

/// Returns what a file of \a head begins with, lines of text.
std::string headText(const SessionHead& head);

/// Returns the line of a trial, and that of one that doesn't count.
std::string lineOf(const Trial& trial);
std::string lineOfVoid(int trial, const std::string& why);

/// The file of results while a session goes on: each answer is on the disk before the next trial
/// begins, and a session that died goes on where it was.
class TrialLog
{
public:
    /// Opens \a path to go on with it, or begins it. Throws base::InputError, and leaves the file,
    /// if another run has it, if it holds something else, or another experiment, participant or
    /// setting.
    TrialLog(const std::string& path, const SessionHead& head);

    const TrialFile& results() const { return _results; }
    /// A sentence on what was found and dropped; empty: nothing.
    const std::string& dropped() const { return _dropped; }

    /// Adds the answer to what the staircase asks, with the figures of \a played. Returns when it
    /// is on the disk. Throws base::InputError if it can't be written.
    void add(bool isFelt, const Trial& played);
    /// Adds that the trial which is asked for was played in vain.
    void addVoid(const std::string& why);

private:
    const std::string _path;
    LineJournal _file;
    TrialFile _results;
    std::string _dropped;
};

/// What all answers say of somebody's threshold and spread: the chance to feel a difference x is
/// that of SimulatedParticipant, with a lapse of kFitLapse. Posterior means and deviations, for
/// thresholds that are equally likely from 0 to the maximum and spreads that are equally likely on
/// a logarithmic axis from a quarter of a step to a quarter of the maximum. Which values were asked
/// depends on answers alone, so the likelihood doesn't ask how the staircase went.
struct PsychometricFit
{
    double threshold = 0.0;
    double thresholdError = 0.0; ///< standard deviation of the posterior
    double spread = 0.0;         ///< geometric mean
};

/// Share of trials in which people are thought to answer by chance.
constexpr double kFitLapse = 0.02;

/// Fits \a trials, of which there is at least one.
PsychometricFit fitTrials(const std::vector<Trial>& trials, const StaircaseSettings& settings);

} // namespace midair::samples
