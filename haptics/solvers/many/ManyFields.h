#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/Units.h"
#include "haptics/base/threads/StopToken.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::base
{
class ThreadPool;
}

namespace midair::haptics
{

class FieldPath;

/// Options of ManyFields; isValid() names the first that is out of range.
struct ManyFieldsOptions
{
    int threads = 1; ///< 1 .. base::kMostThreads
    /// 3e-4 .. 0.3; ManyFieldsFigures::rms that is good enough, rounding included. A tighter one
    /// takes longer; an array with few transducers per point or few phase levels may not reach it,
    /// which the figures tell.
    double rmsTolerance = 0.01;
    /// >= 0; number of successive fields of one path. Fields of a path continue each other; the
    /// first of a path is found from nothing, so paths run on all threads at the same time, and no
    /// field depends on the number of threads. 0: all fields are one path, on one thread. 1: all
    /// fields are independent.
    int fieldsInPath = 0;
    /// Largest change of a transducer's phase from one field of a path to the next, rad; 0: no
    /// bound, else 4 steps of the array's phases (at most pi) .. pi. Motion that needs more costs
    /// accuracy, which the figures tell: a step of x m turns phases by up to 2 pi x / wavelength.
    double largestPhaseStep_rad = 0.0;
    std::uint64_t seed = 1; ///< seed of starting phases; equal seeds give equal fields
    /// Checked between fields.
    base::StopToken stop;

    bool isValid(std::string* error = nullptr) const;
};

/// Points and targets of many fields. The arrays are the caller's.
struct ManyPoints
{
    int fields = 0;                    ///< 1 and up
    int points = 0;                    ///< of each field, 1 .. ManyFields::kMostPoints
    const double* positions = nullptr; ///< fields x points x 3, m, in the array's frame
    /// Ratios of the wanted pressures, 0 .. 1e12, not all 0 in a field: fields x points, or points
    /// if \a sameTargets. Null: all points are equally loud. A point of target 0 is held silent, to
    /// kLeastTarget of the largest, so that fades end continuously.
    const double* targets = nullptr;
    bool sameTargets = true;
};

/// Figures of one field, measured after rounding.
struct ManyFieldsFigures
{
    /// rms of (|p_l| - s a_l)/(s d_l), s the fitted level: d_l = a_l, or for targets below 0.3 of
    /// the largest a unit between a_l and 0.3 of it (QuietPoints::yard()).
    float rms;
    float level_Pa;      ///< s at the largest target, peak Pa at full drive
    float loudness;      ///< E: 1 is the energy of one focus, shared by all points
    float phaseStep_rad; ///< largest change of a phase since the last field; 0 where a path begins
};

/// Solves fields by the thousand for animations, sensations and studies: the production solver's
/// rounds, steps and rounding (haptics/SOLVER.md) without what a single live field needs. One
/// object serves one array; solve() doesn't allocate per field, and not at all after the first call
/// with the same number of points and of targets below 0.3 of the largest.
///
///     ManyFields many(TransducerArray::octagonalPrism(), Medium(), {});
///     many.solve({fields, points, positions.data()}, phases.data());
class ManyFields
{
public:
    static constexpr int kMostPoints = 1000;
    static constexpr int kMostPhaseLevels = 256;

    /// Number of phases that fields for \a array have, 2 .. kMostPhaseLevels: the array's, or
    /// kMostPhaseLevels if it plays any phase.
    static int phaseLevelsOf(const TransducerArray& array)
    {
        return array.drive.phaseLevels > 0 ? array.drive.phaseLevels : kMostPhaseLevels;
    }
    static double phaseStepOf_rad(const TransducerArray& array)
    {
        return base::kTwoPi / phaseLevelsOf(array);
    }

    /// Throws InputError for an invalid array, medium or option, and for an array of more than
    /// kMostPhaseLevels phases.
    ManyFields(const TransducerArray& array,
               const Medium& medium,
               const ManyFieldsOptions& options);
    ~ManyFields();
    ManyFields(const ManyFields&) = delete;
    ManyFields& operator=(const ManyFields&) = delete;

    int transducers() const { return _transducers; }

    /// Throws InputError, which names the field and the point, for counts out of range, positions
    /// that aren't finite and targets out of range.
    void check(const ManyPoints& points) const;
    /// Sets \a phases (fields x transducers) to the phases of full amplitude, in units of
    /// phaseStepOf_rad(), in the array's order; 0 for dead transducers. \a figures: fields, or null
    /// if they aren't wanted, which saves time. Throws InputError, which names the field and the
    /// point, for counts out of range, positions that aren't finite, targets out of range and
    /// points that no transducer reaches, and Stopped on request; \a phases is then partly set. One
    /// call at a time.
    void
    solve(const ManyPoints& points, std::uint8_t* phases, ManyFieldsFigures* figures = nullptr);

private:
    ManyFieldsOptions _options;
    int _transducers = 0;
    std::unique_ptr<base::ThreadPool> _pool;
    std::vector<std::unique_ptr<FieldPath>> _paths; // one for each thread
};

} // namespace midair::haptics
