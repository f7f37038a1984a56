#pragma once

#include "haptics/solvers/production/DriveAmplitudes.h"
#include "haptics/solvers/production/GaussNewtonTuning.h"
#include "haptics/solvers/production/Pace.h"

#include <functional>

namespace midair::haptics
{

/// Fields for points that crowd within a wavelength, where undamped corrections do not converge
/// (SOLVER.md, "Crowded points"). Damped Gauss-Newton steps (Levenberg 1944, Marquardt 1963)
/// minimise
///     f = sum_l r_l^2,  r_l = 1 - |p_l|^2/(s a_l)^2, times a_l/kQuiet at quiet points,
/// over the phases of the drive; |p_l|^2, unlike |p_l|, is smooth in a zero of the field. The
/// phases are kept from one update to the next and move with the points.
class CrowdedDescent
{
public:
    explicit CrowdedDescent(const GaussNewtonTuning& tuning) : _tuning(tuning) {}

    struct Wish
    {
        float goal = 1e-3f; ///< error at which it ends
        int steps = 1000;   ///< most damped steps
        bool moved = false; ///< the points are those of the last update, moved
    };
    /// Sets field.q to unit amplitudes with other phases, then this makes a drive of them and
    /// measures it.
    using Begin = std::function<void(FieldProblem&)>;

    /// Lowers the error of the measured \a drive, from the phases of the last descent if these fit
    /// better. Returns the number of damped steps; drive is measured.
    int descend(FieldProblem& field,
                const QuietPoints& quiet,
                CorrectedDrive& drive,
                GaussNewtonStep& step,
                Pace& pace,
                const Wish& wish,
                const Begin& begin);
    /// Returns true if the last descent did not go on from the phases of the one before.
    bool beganAnew() const { return _beganAnew; }

private:
    /// What one descent works on.
    struct Work
    {
        FieldProblem& field;
        const QuietPoints& quiet;
        CorrectedDrive& drive;
        GaussNewtonStep& step;
        Pace& pace;
        const Wish& wish;
        const Begin& begin;
        int steps = 0;      // damped steps so far
        float error = 0.0f; // sqrt(f/n)/2, the rms of relative errors where they are small
        float level = 0.0f; // s, Pa
    };

    bool takeKept(Work& work);
    void keep(const Work& work);
    void fit(Work& work, int most, float leastLevel);
    void beginAnew(Work& work);
    void beginSmoothly(Work& work);
    void raise(Work& work);
    void startFrom(Work& work, int lane, int steps);
    bool isOver(const Work& work) const;

    const GaussNewtonTuning& _tuning;
    SplitVector _kept;    // m, phases of the last update
    SplitVector _arrival; // m, phases with which the waves arrived at the point in the middle
    SplitVector _before;  // m, phases before a step
    SplitVector _quieter; // m, phases before the level was raised
    bool _hasKept = false;
    bool _beganAnew = true;
    int _lanes = 0;
    float _loudness = 0.0f; // where the last descent from nothing ended
};

} // namespace midair::haptics
