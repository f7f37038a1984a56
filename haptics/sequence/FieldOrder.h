#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPoints.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// What is left of a field in air that is 1 K warmer than it was solved for: sound is faster by
/// 0.17 %, so that waves from near and far transducers no longer arrive in step.
struct KelvinCost
{
    double rms = 0.0;   ///< relative, at the points; 0: not measured
    double level = 0.0; ///< fitted level over that in \a medium; 0: not measured
};

/// Plays \a q (m) in \a medium and in air 1 K warmer, or colder where the medium can't be warmer,
/// and compares |p| at those of \a points that have a target. Takes as long as two matrices for
/// them. Nothing is measured without such points, and for silence. Throws base::Stopped.
KelvinCost kelvinCost(const ControlPoints& points,
                      const Eigen::VectorXcf& q,
                      const TransducerArray& array,
                      const Medium& medium,
                      int threads,
                      const base::StopToken& stop = {});

/// Share of what a focus of its own reaches, over the root of the number of points, that each of
/// many points is sure to get; below what solvers reach, so that it is exceeded by none of them
/// (tests/haptics/sequence/FocusShareTest.cpp).
constexpr double kSureShare = 0.3;

/// Lowers the targets of those points of \a points, by their indices \a small, that stand for
/// objects which are one focus each, to what one of their points would get if the objects had their
/// \a whole points: one focus has all of the sound. Where there are no others, targets in Pa take
/// the place of relative ones, and \a loudness counts up to 1.
void holdToShare(const std::vector<int>& small,
                 int whole,
                 double loudness,
                 const TransducerArray& array,
                 const Medium& medium,
                 ControlPoints& points);

/// Size of the steps of a cycle, including that from the last field to the first. The cycle has K
/// >= 1 fields of equal length.
struct CycleSteps
{
    double meanPhaseStep_rad = 0.0; ///< mean |change of phase| of a transducer in a step
    /// sum_i |q_i - q_i before|^2 / sum_i |q_i|^2, both summed over all steps
    double driveChange = 0.0;
    double largestPhaseStep_rad = 0.0; ///< largest |change of phase| of any transducer in any step
};
CycleSteps cycleSteps(const std::vector<Eigen::VectorXcf>& cycle);

/// Sorts \a fields so that each differs little from the next; the first stays first. Nearest
/// neighbour, then 2-opt (Croes 1958), both by |<q_k, q_l>|, which does not depend on a common
/// phase. Returns the former index of each.
std::vector<int> orderFields(std::vector<Eigen::VectorXcf>& fields);

/// Turns \a q by the common phase, which cannot be felt, that brings it nearest to \a last, in
/// whole levels of \a drive, so that it stays playable. Does nothing if their lengths differ.
void alignField(Eigen::VectorXcf& q, const Eigen::VectorXcf& last, const DriveResolution& drive);

/// Aligns each field of a cycle with the one before it, and spreads the remaining difference
/// between the last and the first over all.
void alignFields(std::vector<Eigen::VectorXcf>& fields, const DriveResolution& drive);

/// Returns \a fields with \a steps >= 0 intermediate fields between one and the next, in which each
/// transducer's phase turns by the shorter angle, rounded to the levels of \a drive. Throws
/// InputError for less than 0 steps.
std::vector<Eigen::VectorXcf> smoothedFields(const std::vector<Eigen::VectorXcf>& fields,
                                             int steps,
                                             const DriveResolution& drive);

/// Scales \a q to \a share (0 .. 1) of its amplitude, on the levels of \a drive
/// (roundAmplitudes()).
void scaleField(Eigen::VectorXcf& q, float share, const DriveResolution& drive);

} // namespace midair::haptics
