#pragma once

#include "haptics/tuning/TuningResponses.h"

namespace midair::haptics
{

/// Takes transducers apart that played all at once. Row r of Sylvester's matrix of order n has the
/// sign (-1)^popcount(r & c) in column c, and transducer i plays column i + 1. The matrix is
/// symmetric, and its own inverse but for the factor n, so
///     n y_c = sum_r sign(r, c) Y_r.
/// Column 0 is what leaks into every row; the columns behind the last transducer hear noise alone.
/// Rows that are missing are those that make these unused columns 0, in the least-squares sense; of
/// more than half as many rows as there are such columns the place is refused.
void decodeHadamard(const TuningPlan& plan,
                    const TuningReadings& readings,
                    int place,
                    TuningResponses& to);

/// Takes transducers apart by levels L alone. Beside a reference S a transducer y plays at 0, 90,
/// 180 and 270 degrees:
///     I_psi = |S + y e^{j psi}|^2,  y conj(S) = ((I_0 - I_180) + j (I_270 - I_90)) / 4,
/// and I_0 + I_180 = I_90 + I_270, which gives one of the four that is missing, and tells a
/// microphone that clips. |S|^2 is the level of the reference alone. The transducers of the first
/// reference A are measured beside a second one B, whose transducers were measured beside A:
///     y conj(S_A) = y conj(S_B) X / |S_B|^2,  X = conj(S_A) S_B = sum of y_j conj(S_A) over B.
/// What comes out is y e^{-j arg S_A}. The mean square of silent rows is taken off each square.
void decodeLevels(const TuningPlan& plan,
                  const TuningReadings& readings,
                  int place,
                  TuningResponses& to);

} // namespace midair::haptics
