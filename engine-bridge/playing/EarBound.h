#pragma once

#include "device/ArrayDevice.h"
#include "haptics/propagation/Exposure.h"

#include <Eigen/Core>

#include <memory>

namespace midair::bridge
{

/// A limit on the level at listening places, for PressureCap to hold. A field keeps to it if
/// neither its rms pressure in a place and in four more around it, with its phases as played, nor
/// what 99 of 100 sets of phases stay below (6.6 dB over the incoherent sum) is over the limit.
class EarBound
{
public:
    /// \a limit_dB: dB re 20 uPa, rms, over 0. Fields are those of the array of \a exposure, which
    /// is used by one thread at a time.
    EarBound(double limit_dB, std::shared_ptr<haptics::Exposure> exposure);

    double limit_dB() const { return _limit_dB; }

    /// Returns the pressure of \a played (m, as the device plays it) at the loudest place, over
    /// that of the limit: at most 1 if it keeps to it; NaN if it is none. \a rounding: the most
    /// that an amplitude changes when it is lowered and rounded by itself; 0 if the field stays the
    /// same but for its level. Since nobody knows the errors of such a rounding, they count like
    /// noise on all amplitudes, with the same 6.6 dB.
    double excess(const Eigen::VectorXcf& played,
                  float rounding,
                  const device::DriveAbility& ability) const;

private:
    Eigen::VectorXf loudest_Pa(const Eigen::VectorXcf& played,
                               const device::DriveAbility& ability) const;

    double _limit_dB;
    double _limit_Pa; ///< rms
    std::shared_ptr<haptics::Exposure> _exposure;
};

} // namespace midair::bridge
