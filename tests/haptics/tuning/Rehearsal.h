#pragma once

#include "haptics/tuning/RehearsedInstrument.h"
#include "haptics/tuning/TuningFit.h"
#include "haptics/tuning/TuningPlan.h"

#include <string>
#include <vector>

namespace midair::haptics
{

/// Places 15 cm before a board, 5 cm apart, the first \a count.
inline Eigen::Matrix3Xd placesBeforeBoard(int count)
{
    Eigen::Matrix3Xd places(3, 4);
    places << 0.004, 0.05, -0.02, -0.03, //
        0.002, -0.01, 0.045, -0.04,      //
        0.147, 0.17, 0.115, 0.195;
    return places.leftCols(count);
}

inline TuningPlan
planFor(const TransducerArray& array, TuningMethod method, const Eigen::Matrix3Xd& places)
{
    TuningPlanOptions options;
    options.method = method;
    options.places = places;
    return makeTuningPlan(array, options);
}

/// All readings of a rehearsal, as they are in memory.
inline TuningReadings readingsOf(RehearsedInstrument& instrument,
                                 const TuningPlan& plan,
                                 const TransducerArray* tuned = nullptr)
{
    TuningReadings readings;
    readings.areLevels = plan.method == TuningMethod::LEVELS || plan.method == TuningMethod::FOCUS;
    readings.values.resize(plan.size());
    for (int row = 0; row < plan.size(); ++row)
        readings.values[row] = instrument.reading(row, tuned);
    return readings;
}

} // namespace midair::haptics
