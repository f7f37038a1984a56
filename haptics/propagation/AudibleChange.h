#pragma once

namespace midair::haptics
{

/// Share of the energy of a drive's change that lies within 20 Hz to 20 kHz of the carrier, 0 .. 1,
/// when fields follow each other at \a rate_Hz (> 0). What changes in a drive's envelope at f is
/// heard at f, the air demodulating it (Suzuki, Fujiwara, Makino, Shinoda, "Reducing amplitude
/// fluctuation by gradual phase shift in midair ultrasound haptics", IEEE Transactions on Haptics
/// 13, 2020). A change D that is held for T = 1/rate is a pulse, whose energy spectrum is
///     |D|^2 T^2 sinc^2(f T),  sinc x = sin(pi x)/(pi x),  in all |D|^2 T
/// (Oppenheim, Schafer, zero-order hold).
double audibleShare(double rate_Hz);

} // namespace midair::haptics
