#pragma once

#include <optional>
#include <string>

namespace midair::samples
{

/// Durations within a trial.
struct TrialTimes
{
    double reference_s = 2.0; ///< duration of the reference line before each line; 0: none
    double between_s = 0.5;   ///< >= 0: silence between reference and line
    double line_s = 4.0;      ///< > 0: longest duration of the line, which ends with the answer
    double rest_s = 1.0;      ///< >= 0: silence after an answer
};

/// What the array plays now, as far as the device reports it.
struct PlayedNow
{
    bool isPlayed = false; ///< the wanted line's field plays completely
    bool isReady = true;   ///< the array can play: not muted, lost or failing
    std::string problem;   ///< why not; "the array is muted"
};

/// Runs trials one after the other, frame by frame: reference, silence, line, answer, silence. A
/// trial counts if the array plays reference and line without a gap; otherwise it is void and
/// repeated once the array can play.
class TrialRunner
{
public:
    enum class Phase
    {
        WAITING,   ///< silent, until begin()
        REFERENCE, ///< the line at 0
        BETWEEN,
        LINE,    ///< the line at value(); can be answered
        ANSWER,  ///< silent, not yet answered
        RESTING, ///< silent, after an answer
        STOPPED, ///< silent because the array can't play; continues by itself
        DONE
    };

    /// Result of a step.
    struct Step
    {
        std::optional<bool> counted; ///< an answer that counts
        double answer_s = 0.0;       ///< from the start of the line to its answer
        double line_s = 0.0;         ///< duration of the line
        std::string voided;          ///< why the trial doesn't count; may be empty
    };

    explicit TrialRunner(const TrialTimes& times) : _times(times) {}

    /// Requests the line at \a value, initially and after each counted answer; it starts after a
    /// rest.
    void ask(double value) { _value = value; }
    void begin(double now_s);
    void finish() { _phase = Phase::DONE; }

    /// Takes an answer. Returns false if none is expected now.
    bool answer(bool isFelt);

    /// Advances to \a now_s with the current state of the array.
    Step step(double now_s, const PlayedNow& played);

    Phase phase() const { return _phase; }
    /// Returns the value of the line to play now; none: silence.
    std::optional<double> wanted() const;
    double value() const { return _value; }

    /// Timeout for the device to play a line.
    static constexpr double kPatience_s = 5.0;

private:
    void go(Phase phase, double now_s);
    Step voidTrial(double now_s, const std::string& why);
    Step playPhase(double now_s, const PlayedNow& played);

    TrialTimes _times;
    Phase _phase = Phase::WAITING;
    double _value = 0.0;
    double _since_s = 0.0;       ///< start of the phase
    double _played_s = -1.0;     ///< when its line first played; -1: not yet
    double _line_s = 0.0;        ///< duration of the line
    double _lineBegin_s = 0.0;   ///< when it first played
    std::optional<bool> _answer; ///< not yet processed
};

} // namespace midair::samples
