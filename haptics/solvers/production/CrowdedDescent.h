#pragma once

#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/production/GaussNewtonStep.h"
#include "haptics/solvers/production/GaussNewtonTuning.h"
#include "haptics/solvers/production/ShapedRounding.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace midair::haptics
{

/// Amplitudes of the transducers, on the device's levels (SOLVER.md, "Amplitudes"). Phase-only, all
/// play one amplitude, or an even mix of its two neighbouring levels; otherwise |q_i| = min(1, g
/// |z_i|), which takes the least power for a field.
class DriveAmplitudes
{
public:
    /// Requested loudness or level.
    struct Wish
    {
        bool phaseOnly = true;
        float loudness = 1.0f; ///< share of the array's full loudness, 0 .. 1
        float level_Pa =
            0.0f; ///< level s for targets in Pa, the largest target; 0: relative targets
    };

    void reserve(const FieldProblem& field)
    {
        _amplitudes.reserve(static_cast<std::size_t>(field.G.paddedTransducers()));
    }
    /// Chooses amplitudes for the phases field.q (|q_i| = 1), whose level is \a full, and scales
    /// field.q and y by them; field.z = G* c belongs to field.q.
    void choose(FieldProblem& field, const Wish& wish, float full);
    /// Changes all amplitudes by \a ratio, as far as playable. Returns false, without change, if
    /// that is less than half of leastChange().
    bool scale(const FieldProblem& field, float ratio);
    /// Returns the smallest relative change of the level that the device's amplitudes allow.
    float leastChange(const FieldProblem& field) const;
    /// Returns true if no larger amplitudes are playable.
    bool isFull() const { return _full || (_wish.phaseOnly && _gain >= 1.0f); }

    /// m amplitudes; null: all are 1.
    const float* data() const { return _full ? nullptr : _amplitudes.data(); }
    /// rms of the amplitudes, 0 .. 1.
    float rms() const { return _full ? 1.0f : _rms; }
    /// Phase-only: standard deviation of the amplitudes over their mean, due to the mix.
    float spread() const
    {
        const float ratio = _full || !(_gain > 0.0f) ? 1.0f : _rms / _gain;
        return std::sqrt(std::max(0.0f, ratio * ratio - 1.0f));
    }

private:
    void set(const FieldProblem& field);
    void measure(const FieldProblem& field);

    Wish _wish;
    float _gain = 1.0f; // phase-only: the mean amplitude; else g
    float _rms = 1.0f;  // of _amplitudes
    bool _full = true;  // all amplitudes are 1
    base::AlignedBuffer<float> _amplitudes;
};

/// Drive during corrections: continuous phases, amplitudes, and the conversion of both to what the
/// device plays. field.q, p, y and u always belong to the last measurement.
class CorrectedDrive
{
public:
    /// Starts from field.q, |q_i| = 1.
    void begin(const FieldProblem& field);
    /// Measures the continuous phases with their amplitudes.
    void measure(FieldProblem& field) { advance(field, nullptr, nullptr, nullptr); }
    /// Turns the phases by \a step and measures them.
    void turn(FieldProblem& field, const GaussNewtonStep& step)
    {
        advance(field, &step, nullptr, nullptr);
    }
    /// Rounds the phases to the device's levels, after turning them by \a step if not null, and
    /// measures the result; the continuous phases stay.
    void play(FieldProblem& field,
              const QuietPoints& quiet,
              const GaussNewtonStep* step,
              const ShapedRounding::Effort& effort)
    {
        advance(field, step, &effort, &quiet);
    }

    /// The continuous phases, |.| = 1 (m).
    SplitVector& phases() { return _phases; }

    DriveAmplitudes amplitudes;

private:
    void advance(FieldProblem& field,
                 const GaussNewtonStep* step,
                 const ShapedRounding::Effort* effort,
                 const QuietPoints* quiet);
    void put(FieldProblem& field, int block, const ShapedRounding::Effort* effort);

    SplitVector _phases;
    ShapedRounding _shaping;
};

/// Fields for points that crowd within a wavelength, for which undamped corrections do not converge
/// (SOLVER.md, "Crowded points"). Damped Gauss-Newton steps (Levenberg 1944, Marquardt 1963)
/// minimise
///     f = sum_l r_l^2,  r_l = 1 - |p_l|^2/(s a_l)^2, times a_l/kQuiet at quiet points,
/// over the phases of the drive; |p_l|^2, unlike |p_l|, is smooth at a zero of the field. The
/// phases are kept between updates and move with the points.
class CrowdedDescent
{
public:
    explicit CrowdedDescent(const GaussNewtonTuning& tuning) : _tuning(tuning) {}

    struct Wish
    {
        float goal = 1e-3f; ///< error at which the descent ends
        int steps = 1000;   ///< maximum number of damped steps
        bool moved = false; ///< the points are those of the last update, moved
    };
    /// Sets field.q to unit amplitudes with other phases, from which a drive is made and measured.
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
    /// Returns true if the last descent did not continue from the phases of the one before.
    bool beganAnew() const { return _beganAnew; }

private:
    /// Working set of a descent.
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
        float error = 0.0f; // sqrt(f/n)/2, the rms of relative errors if they are small
        float level = 0.0f; // s, Pa
    };

    bool takeKept(Work& work);
    void keep(const Work& work);
    void fit(Work& work, int most, float leastLevel);
    void beginAnew(Work& work);
    void beginPowerfully(Work& work);
    void beginSmoothly(Work& work);
    /// Returns the error up to which a field needs no lower level.
    float fair(const Work& work) const;
    void raise(Work& work);
    void startFrom(Work& work, float level, float leastLevel, int steps);
    bool isOver(const Work& work) const;

    const GaussNewtonTuning& _tuning;
    SplitVector _kept;     // m, phases of the last update
    SplitVector _arrival;  // m, arrival phases of the waves at the middle point
    SplitVector _before;   // m, phases before a step
    SplitVector _quieter;  // m, phases before the level was raised
    SplitVector _powerful; // n, phases of the most power
    bool _hasKept = false;
    bool _beganAnew = true;
    int _lanes = 0;
    float _loudness = 0.0f; // final loudness of the last descent from nothing
};

} // namespace midair::haptics
