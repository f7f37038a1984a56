
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/probe/PressureProbe.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <cmath>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

Eigen::VectorXcf focusAt(const TransducerArray& array, const Eigen::Vector3d& at)
{
    return referencePropagationMatrix(at, array, Medium())
        .row(0)
        .unaryExpr([](const std::complex<double>& g) { return std::conj(g) / std::abs(g); })
        .transpose()
        .cast<std::complex<float>>();
}

// Every frequency farther than the window's width from a multiple of \a base_Hz is 100 dB below the
// strongest line but the mean; multiples up to \a lines of them are there.
void expectLinesAt(const Spectrum& spectrum, double base_Hz, int lines)
{
    const double strongest = spectrum.amplitude.tail(spectrum.amplitude.size() - 3).maxCoeff();
    ASSERT_GT(strongest, 0.0);
    double between = 0.0;
    for (Eigen::Index k = 0; k < spectrum.amplitude.size(); ++k)
    {
        const double f = static_cast<double>(k) * spectrum.step_Hz;
        const double off_Hz = std::fabs(f - base_Hz * std::round(f / base_Hz));
        if (off_Hz > 1.5 * spectrum.step_Hz) between = std::max(between, spectrum.amplitude[k]);
    }
    EXPECT_LT(between, 1e-5 * strongest);
    for (int line = 1; line <= lines; ++line)
        EXPECT_GT(spectrum.amplitude[std::lround(line * base_Hz / spectrum.step_Hz)],
                  1e-3 * strongest)
            << line;
}

TEST(Spectrum, ASineHasItsAmplitudeAtItsFrequency)
{
    Eigen::VectorXd values(20000);
    for (int k = 0; k < values.size(); ++k)
        values[k] = 7.0 + 3.0 * std::sin(base::kTwoPi * 250.0 * k / 20e3 + 1.0);
    const Spectrum spectrum = spectrumOf(values, 20e3);
    EXPECT_DOUBLE_EQ(spectrum.step_Hz, 1.0);
    ASSERT_EQ(spectrum.amplitude.size(), 10001);
    EXPECT_NEAR(spectrum.amplitude[0], 7.0, 1e-9);
    EXPECT_NEAR(spectrum.amplitude[250], 3.0, 1e-9);
    EXPECT_NEAR(spectrum.amplitude[249], 1.5, 1e-9);
    EXPECT_NEAR(spectrum.amplitude[252], 0.0, 1e-9);
}

TEST(Spectrum, LengthsHaveNoLargePrimes)
{
    EXPECT_EQ(smoothLength(1), 1);
    EXPECT_EQ(smoothLength(7), 6);
    EXPECT_EQ(smoothLength(20011), 20000);
    EXPECT_EQ(spectrumOf(Eigen::VectorXd::Ones(20011), 20e3).amplitude.size(), 10001);
    EXPECT_THROW(spectrumOf(Eigen::VectorXd::Ones(1), 1.0), base::InputError);
    EXPECT_THROW(spectrumOf(Eigen::VectorXd::Constant(4, NAN), 1.0), base::InputError);
    EXPECT_THROW(spectrumOf(Eigen::VectorXd::Ones(4), 0.0), base::InputError);
}

// A focus on a circle of 3 mm, 50 steps a turn of 0.2 s, and what a point on it hears.
TEST(Spectrum, OfLateralModulationHasLinesAtItsHarmonicsOnly)
{
    const TransducerArray array = TransducerArray::singleBoard();
    DriveSchedule schedule;
    for (int k = 0; k < 50; ++k)
    {
        const double angle = base::kTwoPi * k / 50;
        schedule.drives.push_back(
            focusAt(array, {0.003 * std::cos(angle), 0.003 * std::sin(angle), 0.15}));
        schedule.steps.push_back({k, 1.0, 0.2 / 50});
    }
    const PressureProbe probe(array, Medium(), schedule);
    ProbeOptions options;
    options.duration_s = 2.0;
    const Eigen::VectorXd P = radiationOf(probe.at({0.003, 0.0, 0.15}, options), Medium());
    expectLinesAt(spectrumOf(P, options.rate_Hz), 5.0, 2);
}

TEST(Spectrum, OfAnAmplitudeModulationHasLinesAtItsHarmonicsOnly)
{
    const TransducerArray array = TransducerArray::singleBoard();
    FieldSequence sequence;
    sequence.fields = {focusAt(array, {0.0, 0.0, 0.15})};
    sequence.modulation.amplitudeRate_Hz = 200.0;
    sequence.modulation.fieldRate_Hz = 4000.0;
    const PressureProbe probe(array, Medium(), stepsOf(sequence, 1.0));
    const Eigen::VectorXd P = radiationOf(probe.at({0.0, 0.0, 0.15}, {}), Medium());
    const Spectrum spectrum = spectrumOf(P, 20e3);
    expectLinesAt(spectrum, 200.0, 1);
    // P swings between 0 and its top, so its mean is nearly its line's.
    EXPECT_NEAR(spectrum.amplitude[200] / spectrum.amplitude[0], 1.0, 0.1);
}

} // namespace
} // namespace midair::haptics
