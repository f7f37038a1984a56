#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/base/threads/ThreadPool.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/sequence/CycleVibration.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/FieldProblem.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/dense/QuasiNewton.h"

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace midair::haptics
{

/// Returns the spacings, in wavelengths, of surface samples for evening out, in the order in which
/// they are tried: kPlaceSpacings, and before them, for up to kFewFields \a fields (>= 1), which
/// are more uneven between the places, kClosePlaceSpacing.
std::vector<double> placeSpacings(int fields);
constexpr double kClosePlaceSpacing = 0.18;
constexpr int kFewFields = 3;

/// Options of a CycleEqualizer.
struct CycleEqualizerOptions
{
    int passes = 25; ///< >= 0; maximum number of accepted steps, all fields together
    /// > 0; goal for the mean of |p|^2 at the places, over that of the given fields. Above 1,
    /// because an even cycle wastes less: SOLVER.md, "Fields in turn"
    double raise = 1.2;
    /// > 0; the same with ringing: fields that overlap more waste less as well
    double ringingRaise = 1.25;
    /// > 0; with ringing, for up to kFewFields fields in turn, which ringing costs more
    double fewRaise = 1.3;
    /// > 0; the same for a single field, whose mean stays below its goal; the goal then follows, so
    /// that the mean becomes CycleEqualizer::kHeldGain of that before
    double heldRaise = 1.5;
    double calming = 0.3; ///< >= 0; weight of the vibration, v below

    /// Returns false if a setting is out of range; \a error then names the first one.
    bool isValid(std::string* error = nullptr) const;
};

/// Evens out the pressure on a surface, averaged over K >= 1 fields in turn; one is held. It
/// minimises, over the phases of all fields together,
///     f = sum_l a_l^2 r_l^2 / sum_l a_l^2 + v V,   r_l = I_l / (g a_l^2) - 1,
///     I_l = mean_k |p_l^k|^2,   V = 0
/// over places l with targets a_l, by limited-memory BFGS steps (Liu, Nocedal 1989); at first, for
/// one field, with a logarithm in place of r_l^2, which fills holes (SOLVER.md, "Fields in turn").
/// Amplitudes stay unchanged. If the array rings and the duration of fields is known, I_l is the
/// mean with ringing, by ringingOverlaps(), assuming equal travel times, and V, for up to
/// kFewFields fields, the square of their vibration, over the mean at the goal (CycleVibration). It
/// works in slices of about a millisecond, so that it can yield between them.
class CycleEqualizer
{
public:
    /// Takes threads, pool and stop token from \a solver; results don't depend on the number of
    /// threads. Throws base::InputError for invalid options.
    CycleEqualizer(const CycleEqualizerOptions& options, const SolverOptions& solver);

    /// Sets CycleEqualizerOptions::passes for the next begin(); >= 0.
    void setPasses(int passes) { _options.passes = passes; }

    /// Starts with \a fields (K of m activations; silent ones stay silent) and \a places (positions
    /// and targets; ideally 0.22 wavelengths apart). Each field plays for \a step_s; 0: long enough
    /// that ringing doesn't matter. Returns false, without work, if no place has a target, the
    /// places exceed base::kMostEntries, there is no field, or all fields are silent.
    bool begin(const ControlPoints& places,
               const TransducerArray& array,
               const Medium& medium,
               std::vector<Eigen::VectorXcf> fields,
               double step_s = 0.0);
    /// The same for fields near those of the last begin(), at places that have moved: their mean is
    /// still wanted to be that of the fields given then.
    bool resume(const ControlPoints& places,
                const TransducerArray& array,
                const Medium& medium,
                std::vector<Eigen::VectorXcf> fields,
                double step_s = 0.0);
    /// Does the next slice; returns hasWork(). Throws base::Stopped on a request of the solver
    /// options' token; it may then be called again.
    bool step();
    bool hasWork() const { return _at.slice != Slice::DONE; }
    static constexpr double kHeldGain = 1.005; ///< wanted gain() of a single field
    void end() { _at.slice = Slice::DONE; }    ///< drops the remaining work; keeps the memory

    int passes() const { return _descent.passes; } ///< accepted steps since begin()
    /// Coefficient of variation of I_l / a_l^2, weighted with a_l^2, after the last step.
    double variation() const { return _evenness.variation; }
    /// Vibration under fingertips after the last step, as fingertipVibration(), with equal travel
    /// times; 0 where V is 0.
    double vibration() const;
    /// Mean of I_l, relative to that of the given fields; 1 before the first evaluation.
    double gain() const { return _evenness.given > 0.0 ? _evenness.mean / _evenness.given : 1.0; }
    /// The fields after passes() steps, on the array's levels.
    std::vector<Eigen::VectorXcf> fields() const { return fields(_drive.phaseLevels); }
    /// The same with phases between the levels, as the steps found them.
    std::vector<Eigen::VectorXcf> unroundedFields() const { return fields(0); }

private:
    enum class Slice
    {
        BUILD,    ///< a block of G's rows
        FORWARD,  ///< p += G q of a block, for some of the fields
        BACKWARD, ///< z = G* (r p) of a block, for some of the fields
        DONE
    };
    /// A field that is not silent.
    struct Field
    {
        std::size_t index; // in _fields
        SplitVector q, kept, z, p, w;
    };

    /// Places over which the fields are evened out; n each.
    struct Places
    {
        Eigen::VectorXf targets2;  // a_l^2
        Eigen::VectorXf intensity; // I_l, Pa^2
        std::vector<int> rows;
        std::vector<double> rowSums;
    };
    /// Progress of the work.
    struct Cursor
    {
        Slice slice = Slice::DONE; // next slice
        int block = 0;
        std::size_t field = 0; // first field of the slice
    };
    struct Descent
    {
        QuasiNewton newton;
        Eigen::VectorXf gradient, lastGradient, direction;
        double f = 0.0, slope = 0.0, share = 1.0;
        int passes = 0;
        int fillPasses = 0;     // left, with f of beginBackward()'s logarithm
        bool isStarted = false; // the given fields were evaluated
    };
    struct Evenness
    {
        double goal = 0.0, given = 0.0, mean = 0.0, variation = 0.0;
        double vibration2 = 0.0; // V
    };

    std::vector<Eigen::VectorXcf> fields(int phaseLevels) const;
    void bindRinging(const ControlPoints& places, double step_s, double ringing_s);
    void reserve();
    void buildBlock(int block);
    void forwardBlock(std::size_t first, std::size_t last);
    void backwardBlock(int thread, std::size_t first, std::size_t last);
    double raise() const;
    void beginForward();
    void beginBackward();
    void sumSteady();
    void sumRinging();
    void gatherPressures(std::size_t place);
    double meanGoal() const;
    double evaluate();
    void judge();
    void direct();
    void turn(double share);
    bool keepsUp();
    void keepUp();

    CycleEqualizerOptions _options;
    std::shared_ptr<base::ThreadPool> _pool;
    base::StopToken _stop;
    PropagationMatrix _matrix{Storage::FIXED};
    DriveResolution _drive;
    std::vector<Eigen::VectorXcf> _fields; // as given
    std::vector<Field> _sounding;
    std::vector<SplitVector> _sum; // one per thread, for a block
    struct Ringing
    {
        Eigen::VectorXf overlaps; // K, ringingOverlaps(); empty: fields are steady
        CycleVibration vibration;
        CycleVibration::Pressures p, w; // K, at a place; silent fields are 0
    };
    Ringing _ringing;
    Places _places;
    Cursor _at;
    Descent _descent;
    Evenness _evenness;
};

/// Evens out a cycle, or a held field, in slices and returns each intermediate one worth playing.
/// Its fields keep their order and common phases, so one cycle can replace another while it plays.
class EvenedCycle
{
public:
    /// \a passes: >= 0, as CycleEqualizerOptions::passes; up to kFewFields fields take kFewPasses/K
    /// times as many. \a steps: >= 0, intermediate fields after each field of the cycle. Takes
    /// threads, pool and stop token from \a solver.
    EvenedCycle(int passes, int steps, const SolverOptions& solver);

    /// Starts with \a cycle: one field for each part, with the steps between them, as
    /// SequenceComposer::join() makes it; or one held field. Returns false, without work, as
    /// CycleEqualizer::begin() does, without passes, and for targets in Pa, because each point then
    /// needs its pressure in its own field.
    bool begin(const FieldSequence& cycle,
               const ControlPoints& places,
               const TransducerArray& array,
               const Medium& medium);
    /// Starts with its last field for \a held, which is of the same surfaces, moved by less than a
    /// quarter of a wavelength. Its last fields stay as strong, and it takes only the given number
    /// of passes; step() then returns only the final field. Otherwise as begin(), and for a held
    /// field after a held one.
    bool resume(const FieldSequence& held,
                const ControlPoints& places,
                const TransducerArray& array,
                const Medium& medium);
    /// Does the next slice. Returns a cycle that is more even than the last by kWorthIt (a held
    /// field: kHeldWorthIt), or the final one; it is `evened`, and its report has the figures of
    /// the steps between its fields, but not yet those of the average field. Cycles more than 1 -
    /// kLeastGain weaker than the given one are not returned. Throws base::Stopped; it may then be
    /// called again.
    std::optional<FieldSequence> step();
    bool hasWork() const { return _equalizer.hasWork(); }
    void end() { _equalizer.end(); } ///< drops the remaining work
    const CycleEqualizer& equalizer() const { return _equalizer; }

    static constexpr int kFewPasses = 24;   ///< factor on the passes of a held field
    static constexpr double kWorthIt = 0.7; ///< factor on the coefficient of variation
    /// The same for a held field, which would be felt to jump: it changes in small steps.
    static constexpr double kHeldWorthIt = 0.9;
    static constexpr double kLeastGain = 0.98; ///< of the mean radiation pressure

private:
    bool start(const FieldSequence& cycle,
               const ControlPoints& places,
               const TransducerArray& array,
               const Medium& medium);
    FieldSequence made() const;

    CycleEqualizer _equalizer;
    bool _isResumed = false;
    int _passes;
    int _steps;
    FieldSequence _cycle; // as given
    DriveResolution _drive;
    double _ringing_s = 0.0;
    double _handedOut = 0.0; // variation of the last cycle returned, at first of the given one
    int _seen = 0;           // checked passes of the equaliser
};

} // namespace midair::haptics
