#include "haptics/array/Medium.h"

#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"

#include <cmath>

namespace midair::haptics
{

namespace
{

constexpr double kReferencePressure_Pa = 101325.0; // p_r of ISO 9613-1
constexpr double kReferenceTemperature_K = 293.15; // T_0 of ISO 9613-1
constexpr double kTriplePoint_K = 273.16;          // T_01 of ISO 9613-1, annex B
constexpr double kDryAir_J_kgK = 287.05;           // specific gas constant

// Relaxation frequencies of oxygen and nitrogen in Hz.
struct Relaxation
{
    double oxygen;
    double nitrogen;
};

// ISO 9613-1:1993, equations 3 and 4, with the molar concentration of water vapour h (percent) of
// annex B:
//     p_sat/p_r = 10^C,  C = -6.8346 (T_01/T)^1.261 + 4.6151,  h = h_r (p_sat/p_r) / (p_a/p_r)
//     f_rO = (p_a/p_r) (24 + 4.04e4 h (0.02 + h)/(0.391 + h))
//     f_rN = (p_a/p_r) (T/T_0)^(-1/2) (9 + 280 h exp(-4.170 ((T/T_0)^(-1/3) - 1)))
Relaxation relaxationFrequencies(double T, double relativeHumidity, double pressureRatio)
{
    const double saturation =
        std::pow(10.0, -6.8346 * std::pow(kTriplePoint_K / T, 1.261) + 4.6151);
    const double h = 100.0 * relativeHumidity * saturation / pressureRatio;
    const double t = T / kReferenceTemperature_K;
    return {pressureRatio * (24.0 + 4.04e4 * h * (0.02 + h) / (0.391 + h)),
            pressureRatio / std::sqrt(t) *
                (9.0 + 280.0 * h * std::exp(-4.170 * (1.0 / std::cbrt(t) - 1.0)))};
}

} // namespace

double Medium::soundSpeed() const
{
    return 331.3 * std::sqrt(1.0 + temperature_C / base::kZeroCelsius_K);
}

double Medium::attenuation(double frequency_Hz) const
{
    // ISO 9613-1:1993, equation 5; the standard's 8.686 turns Np into dB and is left out here. f in
    // Hz, T in K:
    //     alpha = f^2 [ 1.84e-11 (p_a/p_r)^-1 (T/T_0)^(1/2) + (T/T_0)^(-5/2)
    //             ( 0.01275 e^(-2239.1/T) / (f_rO + f^2/f_rO)
    //               + 0.1068 e^(-3352/T) / (f_rN + f^2/f_rN) ) ]
    const double T = base::toKelvin(temperature_C);
    const double t = T / kReferenceTemperature_K;
    const double pressureRatio = pressure_Pa / kReferencePressure_Pa;
    const auto [oxygen, nitrogen] = relaxationFrequencies(T, relativeHumidity, pressureRatio);
    const double f2 = frequency_Hz * frequency_Hz;

    const double classical = 1.84e-11 / pressureRatio * std::sqrt(t);
    const double vibrational = 0.01275 * std::exp(-2239.1 / T) / (oxygen + f2 / oxygen) +
                               0.1068 * std::exp(-3352.0 / T) / (nitrogen + f2 / nitrogen);
    return f2 * (classical + std::pow(t, -2.5) * vibrational);
}

double Medium::density() const
{
    return pressure_Pa / (kDryAir_J_kgK * base::toKelvin(temperature_C));
}

bool Medium::isValid(std::string* error) const
{
    return base::RangeCheck()
        .within("temperature_C", temperature_C, -40.0, 60.0)
        .within("relativeHumidity", relativeHumidity, 0.0, 1.0)
        .within("pressure_Pa", pressure_Pa, 50e3, 120e3)
        .passed(error);
}

bool operator==(const Medium& a, const Medium& b)
{
    return a.temperature_C == b.temperature_C && a.relativeHumidity == b.relativeHumidity &&
           a.pressure_Pa == b.pressure_Pa;
}

} // namespace midair::haptics
