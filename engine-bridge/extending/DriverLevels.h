#pragma once

#include "device/drive/DriveSignal.h"

#include <complex>
#include <cstdint>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The phases and amplitudes that an application's driver can play, and fields in them.
class DriverLevels
{
public:
    /// \a amplitudes empty: those of DriveSignal. Throws DeviceError, which names the device
    /// \a name, if they are out of their ranges.
    DriverLevels(const std::string& name, unsigned int phaseLevels, std::vector<float> amplitudes);

    unsigned int phaseLevels() const { return _phaseLevels; }
    const std::vector<float>& amplitudes() const { return _amplitudes; }

    /// Rounds \a signal to the driver's levels: amplitudes down, so that no cap is exceeded.
    void round(const device::DriveSignal& signal,
               std::vector<unsigned char>& phases,
               std::vector<unsigned char>& amplitudes) const;

    /// The same as activations.
    std::vector<std::complex<float>> activations(const device::DriveSignal& signal) const;

private:
    unsigned char phaseOf(std::uint8_t level) const;
    unsigned char amplitudeOf(std::uint8_t duty) const;

    unsigned int _phaseLevels;
    std::vector<float> _amplitudes;
    std::vector<int> _duties; ///< the duty level of each
};

} // namespace midair::bridge
