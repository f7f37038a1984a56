#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// One step of a drive pattern: field number \a field, times \a amplitude.
struct PatternStep
{
    int field = 0;          ///< index, from 0
    double amplitude = 1.0; ///< 0 .. 1
};

/// Total radiated power of a repeating pattern, sum_i |a_i|^2 over the transducers' envelopes a_i,
/// without unit.
struct RadiatedPower
{
    double steady_mean = 0.0;   ///< for the commanded envelopes
    double ringing_mean = 0.0;  ///< for the envelopes with ringing
    double steady_swing = 0.0;  ///< amplitude at the given frequency
    double ringing_swing = 0.0; ///< likewise
};

/// Returns the power of \a steps (>= 1) of \a fields (>= 1 times m activations), each \a step_s (>
/// 0) long, repeated, with transducers that ring with \a ringing_s (>= 0). The swing is at \a
/// frequency_Hz (>= 0, a whole number of periods in the pattern; 0: none). In step k
///     a(t) = q_k + d_k e^{-t/tau},  d_k = a_{k-1} - q_k at its beginning,
/// so all integrals are closed forms. Throws InputError for no steps and values out of range.
RadiatedPower radiatedPower(const std::vector<Eigen::VectorXcf>& fields,
                            const std::vector<PatternStep>& steps,
                            double step_s,
                            double ringing_s,
                            double frequency_Hz = 0.0);

/// Returns the weights with which \a fields (K >= 1) in turn, each played for \a step_s (> 0) and
/// repeated, overlap in the mean of |sum_i G_i a_i(t)|^2, assuming equal travel times:
///     mean = 1/K sum_k sum_l M_{(k - l) mod K} conj(p_k) p_l,   p_k = sum_i G_i q_i^k.
/// K numbers with M_d = M_{K-d} and sum 1; (1, 0, ..) without ringing. Throws InputError for values
/// out of range.
Eigen::VectorXd ringingOverlaps(int fields, double step_s, double ringing_s);

/// The same for \a wave (>= 0) of |p|^2 over a turn, with the time from the beginning of field 0:
///     |p(t)|^2 = mean + Re sum_h A_h z^{-h t/step_s},   z = e^{-2 pi j/K},   h = 1, 2, ..
///     A_h = 2/K sum_k z^{h k} sum_d M_d conj(p_k) p_{(k + d) mod K}.
/// Wave 0 gives ringingOverlaps().
Eigen::VectorXcd waveOverlaps(int fields, double step_s, double ringing_s, int wave);

/// |p|^2 at n points over one turn of fields, Pa^2.
struct RingingCourse
{
    Eigen::VectorXd mean; ///< n
    /// n x number of waves, A_h above; time from the beginning of field 0 in the drive, so that
    /// points can be compared
    Eigen::MatrixXcd waves;
};

/// Returns the mean of ringingMeanSquare() and the first \a waves (>= 0) over a turn, in closed
/// form from the same bins: within 0.6 % of the mean, 2 % without ringing. Throws as
/// ringingMeanSquare() does.
RingingCourse ringingCourse(const Eigen::Matrix3Xd& points,
                            const TransducerArray& array,
                            const Medium& medium,
                            const std::vector<Eigen::VectorXcf>& fields,
                            double step_s,
                            int waves,
                            int threads = 1,
                            const base::StopToken& stop = {});

/// Returns |p|^2 in Pa^2 at \a points (3 x n), averaged over one turn of \a fields (K >= 1 times m
/// activations), each played for \a step_s (> 0) and repeated, where each transducer follows its
/// drive with the array's ringing and arrives R/c later:
///     p(t) = sum_i G_i a_i(t - R_i/c).
/// Delays are rounded to bins of at most 4 us; a step's sum and its decaying part are added in
/// closed form. Within 0.2 % of exact delays. Throws as meanSquarePressure() does, and InputError
/// unless \a step_s is above 0.
Eigen::VectorXd ringingMeanSquare(const Eigen::Matrix3Xd& points,
                                  const TransducerArray& array,
                                  const Medium& medium,
                                  const std::vector<Eigen::VectorXcf>& fields,
                                  double step_s,
                                  int threads = 1,
                                  const base::StopToken& stop = {});

} // namespace midair::haptics
