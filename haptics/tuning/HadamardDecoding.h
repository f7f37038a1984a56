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

} // namespace midair::haptics
