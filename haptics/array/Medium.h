#pragma once

#include <string>

namespace midair::haptics
{

/// The air between the transducers and the hand.
struct Medium
{
    double temperature_C = 20.0;   ///< -40 .. 60
    double relativeHumidity = 0.5; ///< 0 .. 1
    double pressure_Pa = 101325.0; ///< 50,000 .. 120,000

    /// Speed of sound in m/s: 331.3 sqrt(1 + T/273.15).
    double soundSpeed() const;

    /// Amplitude attenuation in Np/m of a pure tone, ISO 9613-1:1993, equations 3 to 5. \a
    /// frequency_Hz > 0.
    double attenuation(double frequency_Hz) const;

    /// Density in kg/m^3, from the gas law for dry air.
    double density() const;

    /// Wavelength in m: soundSpeed() / frequency_Hz.
    double wavelength(double frequency_Hz) const { return soundSpeed() / frequency_Hz; }

    /// Returns false if a value is outside its range or not finite; \a error then names the value
    /// and the range.
    bool isValid(std::string* error = nullptr) const;
};

bool operator==(const Medium& a, const Medium& b);

} // namespace midair::haptics
