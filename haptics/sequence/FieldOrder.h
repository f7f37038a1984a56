#pragma once

#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Sizes of the steps of a cycle of K >= 1 fields of equal length, including that from the last
/// field to the first.
struct CycleSteps
{
    double meanPhaseStep_rad = 0.0; ///< mean |change of phase| of a transducer in a step
    /// sum_i |q_i - q_i before|^2 / sum_i |q_i|^2, both summed over all steps
    double driveChange = 0.0;
    double largestPhaseStep_rad = 0.0; ///< largest |change of phase| of any transducer in any step
};
CycleSteps cycleSteps(const std::vector<Eigen::VectorXcf>& cycle);

/// Sorts \a fields so that each differs little from the next; the first stays first. Nearest
/// neighbour, then 2-opt (Croes 1958), both by |<q_k, q_l>|, which is independent of a common
/// phase. Returns the former index of each.
std::vector<int> orderFields(std::vector<Eigen::VectorXcf>& fields);

/// Turns \a q by the common phase, which cannot be felt, that brings it nearest to \a last, in
/// whole levels of \a drive, so that it stays playable. Does nothing if their lengths differ.
void alignField(Eigen::VectorXcf& q, const Eigen::VectorXcf& last, const DriveResolution& drive);

/// Aligns each field of a cycle with the one before it, and distributes the remaining difference
/// between the last and the first over all.
void alignFields(std::vector<Eigen::VectorXcf>& fields, const DriveResolution& drive);

/// Returns \a fields with \a steps >= 0 intermediate fields after each, in which each transducer's
/// phase turns by the shorter angle, rounded to the levels of \a drive. Throws InputError for
/// negative steps.
std::vector<Eigen::VectorXcf> smoothedFields(const std::vector<Eigen::VectorXcf>& fields,
                                             int steps,
                                             const DriveResolution& drive);

/// Rounds the phases of \a q to the levels of \a drive.
void roundPhases(Eigen::VectorXcf& q, const DriveResolution& drive);

/// Scales \a q to \a share (0 .. 1) of its amplitude, on the levels of \a drive
/// (roundAmplitudes()).
void scaleField(Eigen::VectorXcf& q, float share, const DriveResolution& drive);

} // namespace midair::haptics
