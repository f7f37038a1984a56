#include "haptics/base/Units.h"
#include "tests/samples/installations/Run.h"

#include <osgMidair/Recording>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

namespace
{

using namespace midair;

constexpr int kKeys = 8;

/// The drive's power from a moment of the recording on.
struct Power
{
    double time_s;
    double value;
};

std::vector<Power> powersOf(const std::string& file)
{
    std::string error;
    const osg::ref_ptr<osgMidair::RecordingReader> reader =
        osgMidair::RecordingReader::open(file, error);
    std::vector<Power> powers;
    if (!reader)
    {
        ADD_FAILURE() << error;
        return powers;
    }
    for (osgMidair::RecordedField field; reader->next(field);)
    {
        double sum = 0.0;
        for (const std::complex<float>& activation : field.activations)
            sum += std::norm(activation);
        powers.push_back({field.time_s, sum});
    }
    return powers;
}

/// Returns the power over \a begin_s .. \a end_s, 2000 times a second: each value stands until the
/// next.
std::vector<double> held(const std::vector<Power>& powers, double begin_s, double end_s)
{
    constexpr double kRate_Hz = 2000.0;
    std::vector<double> values;
    std::size_t next = 0;
    for (double t = begin_s; t < end_s; t += 1.0 / kRate_Hz)
    {
        while (next < powers.size() && powers[next].time_s <= t)
            ++next;
        values.push_back(next > 0 ? powers[next - 1].value : 0.0);
    }
    return values;
}

/// Share of the power's mean that swings with \a frequency_Hz.
double swing(const std::vector<double>& values, double frequency_Hz)
{
    std::complex<double> sum = 0.0;
    double mean = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i)
    {
        const double phase = base::kTwoPi * frequency_Hz * static_cast<double>(i) / 2000.0;
        sum += values[i] * std::polar(1.0, -phase);
        mean += values[i];
    }
    return mean > 0.0 ? 2.0 * std::abs(sum) / mean : 0.0;
}

} // namespace

// A finger plays the scale; what went to the device, step by step, swings with each key's frequency
// while the key is touched, and with no other's.
TEST(Piano, EachKeyIsPlayedWithItsFrequency)
{
    const OwnFolder out("piano");
    const std::string recording = out.path + "/scale.midair";
    // A unit's 249 transducers, as the file of 3984 would be large; 0.15 m below the keys.
    const Visit run = visit("piano",
                            "--frames 320 --array autd3 --set 'calibration=1 0 0 0 0 1 0 0 0 0 1 0 "
                            "0 0 0.15 1' --device 'record:" +
                                recording + "'",
                            out);
    ASSERT_EQ(run.outcome.code, 0) << run.outcome.output;
    const nlohmann::json& keys = run.report.at("scene").at("keys");
    ASSERT_EQ(keys.size(), std::size_t(kKeys));
    std::vector<double> frequencies_Hz;
    for (const auto& key : keys)
    {
        frequencies_Hz.push_back(key.at("frequency_Hz"));
        EXPECT_EQ(key.at("touches"), 1) << key;
        EXPECT_GT(key.at("largestForce_mN"), 0.0) << key;
    }
    EXPECT_NEAR(frequencies_Hz.back() / frequencies_Hz.front(), 2.0, 1e-9); // an octave

    const std::vector<Power> powers = powersOf(recording);
    ASSERT_FALSE(powers.empty());
    constexpr double kWindow_s = 0.1;
    std::vector<int> windows(kKeys, 0); // in which a key's frequency was played
    for (double t = 0.0; t + kWindow_s < powers.back().time_s; t += 0.5 * kWindow_s)
    {
        const std::vector<double> values = held(powers, t, t + kWindow_s);
        std::vector<double> swings;
        for (const double frequency_Hz : frequencies_Hz)
            swings.push_back(swing(values, frequency_Hz));
        const auto most = std::max_element(swings.begin(), swings.end());
        if (*most > 0.5) ++windows[static_cast<std::size_t>(most - swings.begin())];
    }
    for (int key = 0; key < kKeys; ++key)
        EXPECT_GE(windows[static_cast<std::size_t>(key)], 1)
            << keys[static_cast<std::size_t>(key)] << " of " << powers.size() << " steps";
}
