#pragma once

namespace midair::haptics
{

/// Returns the fraction, 0 .. 1, of the energy of a change of the drive that lies 20 Hz to 20 kHz
/// from the carrier, when fields follow each other at \a rate_Hz (> 0). The air demodulates the
/// ultrasound, so a change of the envelope at frequency f is heard at f (Suzuki, Fujiwara, Makino,
/// Shinoda, "Reducing amplitude fluctuation by gradual phase shift in midair ultrasound haptics",
/// IEEE Transactions on Haptics 13, 2020). A change D that is held for T = 1/rate is a pulse, whose
/// energy spectrum is
///     |D|^2 T^2 sinc^2(f T),  sinc x = sin(pi x)/(pi x),  in all |D|^2 T
/// (Oppenheim, Schafer, zero-order hold).
double audibleShare(double rate_Hz);

} // namespace midair::haptics
