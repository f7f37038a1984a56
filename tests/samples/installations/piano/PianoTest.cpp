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

/// How much of the power's mean swings with \a frequency_Hz, from the steps from \a begin to \a end
/// alone: a busy machine may leave steps out, which says nothing of the others' times.
double
swing(const std::vector<Power>& powers, std::size_t begin, std::size_t end, double frequency_Hz)
{
    double mean = 0.0;
    for (std::size_t i = begin; i < end; ++i)
        mean += powers[i].value / static_cast<double>(end - begin);
    std::complex<double> sum = 0.0;
    for (std::size_t i = begin; i < end; ++i)
        sum += (powers[i].value - mean) *
               std::polar(1.0, -base::kTwoPi * frequency_Hz * powers[i].time_s);
    return mean > 0.0 ? 2.0 * std::abs(sum) / (mean * static_cast<double>(end - begin)) : 0.0;
}

} // namespace

// A finger plays the scale; what went to the device, step by step, swings with one key's frequency
// after the other.
TEST(Piano, EachKeyIsPlayedWithItsFrequency)
{
    const OwnFolder out("piano");
    const std::string recording = out.path + "/scale.midair";
    // A unit's 249 transducers, as the file of 3984 would be large; 0.15 m below the keys.
    const Visit run = visit(
        "piano",
        "--frames 380 --array autd3 --set earLimit=none --set 'calibration=1 0 0 0 0 1 0 0 0 0 1 0 "
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
    constexpr double kWindow_s = 0.12;
    constexpr std::size_t kSteps = 24;        // of 120 at 1000 a second
    std::vector<double> first_s(kKeys, -1.0); // when each key's frequency was played first
    for (std::size_t begin = 0; begin < powers.size(); begin += 5)
    {
        std::size_t end = begin;
        while (end < powers.size() && powers[end].time_s < powers[begin].time_s + kWindow_s)
            ++end;
        if (end < begin + kSteps) continue;
        std::vector<double> swings;
        for (const double frequency_Hz : frequencies_Hz)
            swings.push_back(swing(powers, begin, end, frequency_Hz));
        const auto most = std::max_element(swings.begin(), swings.end());
        double& first = first_s[static_cast<std::size_t>(most - swings.begin())];
        if (*most > 0.5 && first < 0.0) first = powers[begin].time_s;
    }
    for (std::size_t key = 0; key < kKeys; ++key)
    {
        EXPECT_GE(first_s[key], 0.0) << keys[key] << " of " << powers.size() << " steps";
        if (key > 0)
        {
            EXPECT_GT(first_s[key], first_s[key - 1]) << keys[key];
        }
    }
}
