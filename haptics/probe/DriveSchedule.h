#pragma once

#include "haptics/sequence/FieldSequence.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::haptics
{

/// One of a schedule's drives, times \a amplitude, for \a duration_s.
struct ScheduledDrive
{
    int drive = 0;           ///< index, from 0
    double amplitude = 1.0;  ///< 0 .. 1
    double duration_s = 0.0; ///< above 0
};

/// What an array is driven with over time.
struct DriveSchedule
{
    std::vector<Eigen::VectorXcf> drives; ///< m activations each, |q_i| <= 1
    std::vector<ScheduledDrive> steps;    ///< >= 1, in the order in which they are played
    double begin_s = 0.0;                 ///< when the first of them begins
    /// True: the steps repeat, before their beginning, too, so that all is settled at any time.
    /// False: before the first the array is silent, and the last is held for ever.
    bool repeats = true;

    /// Returns the length of all steps together.
    double duration_s() const;
    /// Returns false if there are no steps, lengths or indices disagree, or a number is not finite
    /// or out of range; \a error then says which.
    bool isValid(std::string* error = nullptr) const;
};

/// Returns \a sequence as a device plays it from time 0 to \a until_s (0 .. 3600) at least: fields
/// in turn at its field rate, each with the amplitude of its modulation when it begins. It repeats
/// where fields and modulation do within 65536 steps; else it begins 0.2 s before, when all
/// transducers have long settled. Throws InputError for no fields, options out of range, and more
/// than 10^7 steps.
DriveSchedule stepsOf(const FieldSequence& sequence, double until_s);

} // namespace midair::haptics
