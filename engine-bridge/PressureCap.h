#pragma once

#include "device/DriveSignal.h"
#include "haptics/HologramSolver.h"
#include "haptics/Medium.h"
#include "haptics/TransducerArray.h"

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace midair::bridge
{

/// A drive that keeps to a cap of pressure, and the field that it makes.
struct CappedField
{
    double factor =
        1.0; ///< on all amplitudes; 1: as it was; 0: silent, since nothing less keeps to the cap
    Eigen::VectorXcf played;     ///< m, as the device plays it
    Eigen::VectorXf achieved_Pa; ///< n, |G q| of that, of the first of the arrays
};

/// Keeps the peak pressure at control points to a cap: looks at the field as the device plays it, in its levels, and scales the
/// whole drive down until no point has more; silences it where the device's levels can't.
///
/// What lowers amplitudes later (ramp, thermal budget, amplitude modulation) lowers the pressure with them: exactly where all
/// transducers play at one amplitude, as they do by default, else but for the rounding to the device's levels.
class PressureCap
{
public:
    /// \a max_Pa > 0, peak. Throws haptics::InputError for another.
    explicit PressureCap(double max_Pa);

    double max_Pa() const { return _max_Pa; }

    /// Lowers the duties of \a signal as far as needed. The cap holds for each of \a arrays, which differ in what is believed of
    /// them (obstacles in the sound's way or not). \a play tells what the device makes of a drive, as activations.
    CappedField hold(const Eigen::Matrix3Xd& points,
                     const std::vector<const haptics::TransducerArray*>& arrays,
                     const haptics::Medium& medium,
                     const std::function<Eigen::VectorXcf(const device::DriveSignal&)>& play,
                     device::DriveSignal& signal,
                     int threads = 1) const;

private:
    double _max_Pa;
};

/// Rates anew in \a report (rms, max, level, loudness, points that fall short) a field that was scaled down after it was solved.
void rate(const haptics::ControlPoints& points,
          const Eigen::VectorXf& achieved_Pa,
          bool absolute,
          haptics::SolveReport& report);

} // namespace midair::bridge
