#pragma once

#include <optional>
#include <string>

namespace midair::samples
{

/// What is felt in a trial, and for how long.
struct TrialTimes
{
    double reference_s = 2.0; ///< 0: no reference is played; else for so long before each line
    double between_s = 0.5;   ///< >= 0: silence between reference and line
    double line_s = 4.0;      ///< > 0: the line falls silent after that, or when it is answered
    double rest_s = 1.0;      ///< >= 0: silence after an answer
};

/// What the array plays now of what is wanted, as far as the device tells.
struct PlayedNow
{
    bool isPlayed = false; ///< the field of the line that is wanted, and all of it
    bool isReady = true;   ///< it could play: not muted, lost or failing
    std::string problem;   ///< why not; "the array is muted"
};

/// Leads through trials, one after the other, frame by frame: reference, silence, line, answer,
/// silence. A trial counts if the array has played reference and line without a gap until they
/// ended; otherwise it is void, and the same is asked again once the array can play.
class TrialRunner
{
public:
    enum class Phase
    {
        WAITING,   ///< silent, until begin()
        REFERENCE, ///< the line at 0
        BETWEEN,
        LINE,    ///< the line at value(); may be answered
        ANSWER,  ///< silent, and not answered yet
        RESTING, ///< silent, after an answer
        STOPPED, ///< silent, since the array can't play; goes on by itself when it can
        DONE
    };

    /// What came of a step.
    struct Step
    {
        std::optional<bool> counted; ///< an answer that counts
        double answer_s = 0.0;       ///< from the line's beginning to its answer
        double line_s = 0.0;         ///< for which the line was played
        std::string voided;          ///< why the trial doesn't count; empty: nothing of the kind
    };

    explicit TrialRunner(const TrialTimes& times) : _times(times) {}

    /// Starts with the line at \a value: the first time, and when one was counted. After a rest.
    void ask(double value) { _value = value; }
    void begin(double now_s);
    void finish() { _phase = Phase::DONE; }

    /// Takes an answer, if there is one to be given now. Returns false if there isn't.
    bool answer(bool isFelt);

    /// Goes on to \a now_s, with what is played then.
    Step step(double now_s, const PlayedNow& played);

    Phase phase() const { return _phase; }
    /// Returns the value of the line that is to be played now; none: silence.
    std::optional<double> wanted() const;
    double value() const { return _value; }

    /// Longest time that the device may take to play what is wanted.
    static constexpr double kPatience_s = 5.0;

private:
    void go(Phase phase, double now_s);
    Step voidTrial(double now_s, const std::string& why);
    Step playPhase(double now_s, const PlayedNow& played);

    TrialTimes _times;
    Phase _phase = Phase::WAITING;
    double _value = 0.0;
    double _since_s = 0.0;       ///< begin of the phase
    double _played_s = -1.0;     ///< when its line was first played; -1: not yet
    double _line_s = 0.0;        ///< for which the line was played
    double _lineBegin_s = 0.0;   ///< when it was first played
    std::optional<bool> _answer; ///< given and not taken yet
};

} // namespace midair::samples
