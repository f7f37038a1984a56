#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// One step of a pattern of drives: \a field of its fields, times \a amplitude.
struct PatternStep
{
    int field = 0;          ///< index, from 0
    double amplitude = 1.0; ///< 0 .. 1
};

/// Power that all transducers radiate together, sum_i |a_i|^2 over their envelopes a_i, without
/// unit; of a pattern that repeats.
struct RadiatedPower
{
    double steady_mean = 0.0;   ///< of the envelopes as they are asked for
    double ringing_mean = 0.0;  ///< of those that ring
    double steady_swing = 0.0;  ///< amplitude of the part at a frequency
    double ringing_swing = 0.0; ///< likewise
};

/// Returns the power of \a steps (>= 1) of \a fields (>= 1 times m activations), each \a step_s (>
/// 0) long, played again and again by transducers that ring with \a ringing_s (>= 0); its swing is
/// that at \a frequency_Hz (>= 0, a whole number of periods in the pattern; 0: none). In step k
///     a(t) = q_k + d_k e^{-t/tau},  d_k = a_{k-1} - q_k at its beginning,
/// so that all integrals are closed forms. Throws InputError for no steps and what is out of range.
RadiatedPower radiatedPower(const std::vector<Eigen::VectorXcf>& fields,
                            const std::vector<PatternStep>& steps,
                            double step_s,
                            double ringing_s,
                            double frequency_Hz = 0.0);

/// Returns what \a fields (K >= 1) that are played in turn, each for \a step_s (> 0), again and
/// again, have of each other in the mean of |sum_i G_i a_i(t)|^2 if all sound came at once:
///     mean = 1/K sum_k sum_l M_{(k - l) mod K} conj(p_k) p_l,   p_k = sum_i G_i q_i^k.
/// K numbers, of M_d = M_{K-d}, which sum to 1; (1, 0, ..) without ringing. Throws InputError for
/// what is out of range.
Eigen::VectorXd ringingOverlaps(int fields, double step_s, double ringing_s);

/// Returns |p|^2 in Pa^2 at \a points (3 x n), averaged over the time in which \a fields (K >= 1
/// times m activations) are played once, each for \a step_s (> 0), again and again, where each
/// transducer follows its drive with the array's ringing and is heard R/c later:
///     p(t) = sum_i G_i a_i(t - R_i/c).
/// Delays are rounded to bins of at most 4 us; a step's sum and its decaying rest
/// are added up in closed form. Within 0.2 % of exact delays. Throws as meanSquarePressure() does,
/// and InputError for a \a step_s that is not above 0.
Eigen::VectorXd ringingMeanSquare(const Eigen::Matrix3Xd& points,
                                  const TransducerArray& array,
                                  const Medium& medium,
                                  const std::vector<Eigen::VectorXcf>& fields,
                                  double step_s,
                                  int threads = 1,
                                  const base::StopToken& stop = {});

} // namespace midair::haptics
