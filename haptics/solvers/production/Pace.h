#pragma once

#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <array>

namespace midair::haptics
{

/// Keeps a deadline: knows from earlier solves what the stages of one take, so that the last field
/// is finished in time instead of begun (SOLVER.md, "Deadline").
class Pace
{
public:
    enum Stage
    {
        BUILD,    ///< building G
        ROUND,    ///< a round of projections
        STEP,     ///< a CG step
        FINISH,   ///< rounding and measuring what is played
        THOROUGH, ///< the same with thorough shaping
        STAGES
    };

    /// Begins a solve. \a deadline_ms counts from FieldProblem::start(); 0: none.
    void start(const FieldProblem& field, double deadline_ms)
    {
        _field = &field;
        _deadline_ms = deadline_ms;
        const double entries = static_cast<double>(field.n()) * field.m();
        for (std::size_t k = 0; deadline_ms > 0.0 && k < STAGES; ++k)
            _cost_ms[k] = entries != _entries ? kGuess_ms[k] * entries : kForget * _cost_ms[k];
        _entries = entries;
    }
    /// Returns how many times \a stage fits before the finish, 0 .. \a most; \a most without a
    /// deadline.
    int fits(Stage stage, int most) const
    {
        if (_deadline_ms <= 0.0) return most;
        const double count = left_ms(FINISH) / _cost_ms[stage];
        return static_cast<int>(std::clamp(count, 0.0, static_cast<double>(most)));
    }
    /// Returns true if so little time is left that a round has to be the finish. \a isBuilt: G is.
    bool isHurried(bool isBuilt) const
    {
        return _deadline_ms > 0.0 &&
               left_ms(FINISH) < (isBuilt ? 0.0 : _cost_ms[BUILD]) + _cost_ms[ROUND];
    }
    /// Returns true if \a finish can be begun in time.
    bool allows(Stage finish) const { return _deadline_ms <= 0.0 || left_ms(finish) >= 0.0; }
    /// Does \a work, which is \a count times \a stage, and remembers what that took.
    template<typename Work>
    void timed(Stage stage, int count, const Work& work)
    {
        if (_deadline_ms <= 0.0) return work();
        const double start = _field->elapsed_ms();
        work();
        took(stage, count, _field->elapsed_ms() - start);
    }
    /// Remembers that \a count times \a stage took \a ms; 0 times: that counts for nothing.
    void took(Stage stage, int count, double ms)
    {
        if (count <= 0) return;
        double& cost_ms = _cost_ms[stage];
        cost_ms += kMemory * (std::min(ms / count, kMostGrowth * cost_ms) - cost_ms);
    }

private:
    double left_ms(Stage finish) const
    {
        return _deadline_ms - _field->elapsed_ms() - _cost_ms[finish];
    }

    // SOLVER.md, "Deadline". A stage that takes longer since the machine is busy for a moment
    // counts little, and one that was left out for lack of time is tried again.
    static constexpr std::array<double, STAGES> kGuess_ms = {
        1e-6, 2e-7, 8e-8, 3e-7, 8e-7};         // per entry
    static constexpr double kMemory = 0.3;     // share of the last time
    static constexpr double kMostGrowth = 2.0; // over what is remembered
    static constexpr double kForget = 0.98;    // per solve

    const FieldProblem* _field = nullptr;
    double _deadline_ms = 0.0, _entries = 0.0;
    std::array<double, STAGES> _cost_ms{};
};

} // namespace midair::haptics
