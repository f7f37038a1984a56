#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/Units.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <Eigen/Core>

#include <cmath>
#include <cstdint>
#include <random>

namespace midair::haptics
{

/// How a real array may differ from the model that its field was solved with. Deviations are
/// independent, normal and of mean 0.
struct ArraySpread
{
    double gain = 0.0;       ///< rms of the relative deviation of a transducer's amplitude
    double phase_deg = 0.0;  ///< rms of its phase
    double position_m = 0.0; ///< rms of each of its three coordinates
};

/// Returns \a array with the deviations of \a seed.
inline TransducerArray
spreadArray(TransducerArray array, const ArraySpread& spread, std::uint64_t seed)
{
    const int m = array.size();
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    if (array.gain.size() == 0) array.gain = Eigen::VectorXd::Ones(m);
    if (array.phaseOffset_rad.size() == 0) array.phaseOffset_rad = Eigen::VectorXd::Zero(m);
    for (int i = 0; i < m; ++i)
    {
        array.gain[i] *= 1.0 + spread.gain * normal(random);
        array.phaseOffset_rad[i] += base::toRadians(spread.phase_deg) * normal(random);
        for (double& coordinate : array.positions.col(i))
            coordinate += spread.position_m * normal(random);
    }
    return array;
}

/// What a drive makes of the control points.
struct ChangedField
{
    double rms = 0.0;      ///< relative, of the pressures about their fitted level
    double max = 0.0;      ///< likewise, the largest
    double level_Pa = 0.0; ///< fitted peak pressure at a target of 1
};

/// Plays \a q (m) on \a array in \a medium, in double precision, and compares the pressures at
/// \a points with their relative targets.
inline ChangedField changedField(const ControlPoints& points,
                                 const TransducerArray& array,
                                 const Medium& medium,
                                 const Eigen::VectorXcf& q)
{
    const Eigen::VectorXd y = (referencePropagationMatrix(points.positions, array, medium) *
                               q.cast<std::complex<double>>())
                                  .cwiseAbs();
    ChangedField field;
    field.level_Pa = fittedLevel(y, points.targets);
    const RelativeErrors errors = relativeErrors(y, points.targets, field.level_Pa);
    field.rms = errors.rms;
    field.max = errors.max;
    return field;
}

} // namespace midair::haptics
