#include "engine-bridge/contact/ContactForce.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "tests/engine-bridge/contact/ContactNumbers.h"

#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

constexpr double kRate_Hz = 4000.0;

/// Size of the line at \a f_Hz of \a samples, under a Hann window.
double lineAt(const std::vector<double>& samples, double f_Hz)
{
    double mean = 0.0;
    for (const double sample : samples)
        mean += sample / static_cast<double>(samples.size());
    std::complex<double> sum = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i)
    {
        const double x = static_cast<double>(i) / static_cast<double>(samples.size());
        sum += (samples[i] - mean) * (1.0 - std::cos(base::kTwoPi * x)) *
               std::polar(1.0, -base::kTwoPi * f_Hz * static_cast<double>(i) / kRate_Hz);
    }
    return 2.0 * std::abs(sum) / static_cast<double>(samples.size());
}

double strongest(const std::vector<double>& samples, double least_Hz, double most_Hz)
{
    double best = 0.0, at = 0.0;
    for (double f = least_Hz; f <= most_Hz; f += 0.1)
        if (lineAt(samples, f) > best)
        {
            best = lineAt(samples, f);
            at = f;
        }
    return at;
}

ContactVibrationOptions textured()
{
    ContactVibrationOptions options;
    options.textureDepth = 0.5;
    options.texturePeriod_m = 1e-3;
    return options;
}

TEST(ContactVibration, TheMixHasItsTwoLines)
{
    ContactVibrationOptions options;
    options.lowDepth = 0.3;
    options.highDepth = 0.5;
    ContactVibration vibration(options);
    std::vector<double> samples;
    double least = 1.0;
    for (int i = 0; i < 4000; ++i)
    {
        vibration.advance(1.0 / kRate_Hz, 0.0);
        samples.push_back(vibration.share());
        least = std::min(least, vibration.share());
        EXPECT_NEAR(vibration.factor() * vibration.factor(), vibration.share(), 1e-12);
    }
    EXPECT_NEAR(lineAt(samples, 30.0), 0.15, 0.002);
    EXPECT_NEAR(lineAt(samples, 150.0), 0.25, 0.002);
    EXPECT_LT(lineAt(samples, 90.0), 0.001);
    EXPECT_NEAR(least, 0.2, 0.02);
}

// Swept from 20 to 200 mm/s: in each tenth of a second the line is at the mean v / lambda_s, and
// the phase goes on by what the speed says, so no jump is in it.
TEST(ContactVibration, ASweptSpeedGivesALineAtSpeedOverPeriodAndNoJumps)
{
    ContactVibration vibration(textured());
    constexpr int kWindow = 800; // 0.2 s
    std::vector<double> samples;
    double before = 0.0, mean_Hz = 0.0, share = 1.0;
    for (int i = 0; i < 20 * kWindow; ++i)
    {
        const double speed = 0.02 + 0.18 * i / (20.0 * kWindow);
        ASSERT_TRUE(vibration.advance(1.0 / kRate_Hz, (i / 500) % 2 ? speed : -speed));
        const double turn =
            std::remainder(vibration.texturePhase_rad() - before, base::kTwoPi) / base::kTwoPi;
        EXPECT_NEAR(turn * kRate_Hz, speed / 1e-3, 1e-6 * speed / 1e-3);
        before = vibration.texturePhase_rad();
        // No faster than its own line: 2 pi f m/2 a sample; a jump of the phase would be.
        EXPECT_LE(std::abs(vibration.share() - share), 1.01 * base::kPi * 0.5 * turn + 1e-12);
        share = vibration.share();
        samples.push_back(share);
        mean_Hz += speed / 1e-3 / kWindow;
        if (samples.size() < kWindow) continue;
        EXPECT_NEAR(strongest(samples, 5.0, 250.0), mean_Hz, std::max(0.02 * mean_Hz, 0.2));
        samples.clear();
        mean_Hz = 0.0;
    }
}

// The speed jumps from 50 to 51 mm/s and back 20 times a second. What isn't within the modulation's
// own sidebands, at 50.5 +- some 100 Hz, is below -40 dB of the line.
TEST(ContactVibration, ChangesOfSpeedLeaveNoBroadLines)
{
    ContactVibration vibration(textured());
    std::vector<double> samples;
    for (int i = 0; i < 8000; ++i)
    {
        vibration.advance(1.0 / kRate_Hz, (i / 100) % 2 ? 0.051 : 0.050);
        samples.push_back(vibration.share());
    }
    const double line = lineAt(samples, 50.5);
    EXPECT_NEAR(line, 0.25, 0.01);
    for (double f = 150.0; f < 1000.0; f += 0.5)
        EXPECT_LT(lineAt(samples, f), 0.01 * line) << f;
}

TEST(ContactVibration, NothingVibratesAtRestOrAboveWhatSkinFeels)
{
    ContactVibration vibration(textured());
    for (const double speed : {0.0, 0.55})
        for (int i = 0; i < 100; ++i)
        {
            vibration.advance(1e-3, speed);
            EXPECT_EQ(vibration.share(), 1.0);
        }
    ContactVibration slow(textured());
    double least = 1.0;
    for (int i = 0; i < 4000; ++i)
    {
        slow.advance(1e-3, 0.002);
        least = std::min(least, slow.share());
    }
    EXPECT_NEAR(least, 0.9, 0.001); // a fifth of 0.5
}

TEST(ContactVibration, RefusesNumbersThatAreNone)
{
    ContactVibration vibration(textured());
    vibration.advance(1e-3, 0.1);
    const double before = vibration.texturePhase_rad();
    EXPECT_FALSE(vibration.advance(kNan, 0.1));
    EXPECT_FALSE(vibration.advance(1e-3, kNan));
    EXPECT_FALSE(vibration.advance(-1e-3, 0.1));
    EXPECT_EQ(vibration.texturePhase_rad(), before);
    ContactVibrationOptions options = textured();
    options.lowDepth = 0.6;
    std::string error;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error,
              "ContactVibrationOptions: lowDepth, highDepth and textureDepth together must be at "
              "most 1");
    options = textured();
    options.texturePeriod_m = 0.0;
    EXPECT_THROW(ContactVibration{options}, base::InputError);
}

} // namespace

} // namespace midair::bridge
