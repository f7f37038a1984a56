#pragma once

#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// What the steps of a cycle change, the one from the last field to the first among them. The cycle
/// has K >= 1 fields of equal length.
struct CycleSteps
{
    double meanPhaseStep_rad = 0.0;    ///< mean |change of phase| of the transducers in a step
    double driveChange = 0.0;          ///< sum_i |q_i - q_i before|^2 / sum_i |q_i|^2 of a step
    double largestPhaseStep_rad = 0.0; ///< of any transducer in any step
};
CycleSteps cycleSteps(const std::vector<Eigen::VectorXcf>& cycle);

/// Puts \a fields into an order in which each differs little from the next, the first staying
/// first: nearest neighbour, then 2-opt (Croes 1958), both by |<q_k, q_l>|, which a common phase
/// leaves alone. Returns where each was.
std::vector<int> orderFields(std::vector<Eigen::VectorXcf>& fields);

/// Turns \a q by the common phase that brings it nearest to \a last, which cannot be felt; by whole
/// levels of \a drive, which keeps it playable. Does nothing where their lengths differ.
void alignField(Eigen::VectorXcf& q, const Eigen::VectorXcf& last, const DriveResolution& drive);

/// Does the same for each field of a cycle and the one before it, and spreads what is then left
/// between the last and the first over all.
void alignFields(std::vector<Eigen::VectorXcf>& fields, const DriveResolution& drive);

/// Returns \a fields with \a steps >= 0 more between one and the next, in which each transducer
/// turns the shorter way; on the levels of \a drive. Throws InputError for less than 0 steps.
std::vector<Eigen::VectorXcf> smoothedFields(const std::vector<Eigen::VectorXcf>& fields,
                                             int steps,
                                             const DriveResolution& drive);

/// Scales \a q to \a share (0 .. 1) of its amplitude, with each transducer on the nearest level of
/// \a drive.
void scaleField(Eigen::VectorXcf& q, float share, const DriveResolution& drive);

} // namespace midair::haptics
