#pragma once

#include "haptics/propagation/RingingMean.h"

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace midair::haptics
{

/// Half the breadth of a fingertip, m; places within it of a place on a surface are its pad.
constexpr double kFingertipPad_m = 0.007;

/// Returns the sensitivity of skin to a vibration of \a frequency_Hz (>= 0), relative to that at
/// 220 Hz, where it is largest: the reciprocal of the threshold, which falls by 12 dB an octave up
/// to there and rises by 9 dB an octave beyond (Verrillo 1966, "Vibrotactile thresholds for hairy
/// skin"; glabrous skin has the same slopes).
double skinSensitivity(double frequency_Hz);

/// Returns the number of waves of \a fields (>= 1) in turn, each for \a step_s (> 0), that skin
/// feels as a vibration: those up to 1000 Hz, at most 256.
int feltWaves(int fields, double step_s);

/// Returns the pads of fingertips on a surface, sampled evenly at \a places (3 x n, m): each row
/// averages over the places of one pad, so that its sum is 1. Pads are spread over the surface, at
/// most 400. Both sides of what is thinner than a pad are in one.
Eigen::SparseMatrix<double, Eigen::RowMajor> fingertipPads(const Eigen::Matrix3Xd& places);

/// Returns how strongly fields in turn vibrate under a fingertip:
///     sqrt(mean_pads sum_h (s(f_h) |A_h|)^2 / 2) / mean_pads A_0,   f_h = h/(K step_s),
/// where A_h are waves of the pressure on a pad (\a course averaged over it), A_0 its mean, and s
/// is skinSensitivity(): the rms of the alternating force, as strong as one of 220 Hz, over the
/// mean force. 0 without waves, and for silence. \a period_s: K step_s.
double fingertipVibration(const Eigen::SparseMatrix<double, Eigen::RowMajor>& pads,
                          const RingingCourse& course,
                          double period_s);

} // namespace midair::haptics
