// The pressure over time of what a simulated array has played, against closed forms.
#include "engine-bridge/playing/PlayedDrives.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <cmath>

#include <gtest/gtest.h>

namespace midair::bridge
{
namespace
{

constexpr double kNow_s = 1000.0;
const Eigen::Vector3d kThere(0.0, 0.0, 0.1);

haptics::TransducerArray oneTransducer(double ringing_s)
{
    haptics::TransducerArray array;
    array.positions = Eigen::Matrix3Xd::Zero(3, 1);
    array.normals = Eigen::Vector3d::UnitZ();
    array.board = {0};
    array.ringing_s = ringing_s;
    return array;
}

/// Silence, full drive from 20 ms before now, a drive of phase 1 from 10 ms before now.
PlayedDrives onAndTurned()
{
    PlayedDrives played;
    played.until_s = kNow_s;
    played.fields = {
        {kNow_s - 5.0, {0.0F}}, {kNow_s - 0.02, {1.0F}}, {kNow_s - 0.01, {std::polar(1.0F, 1.0F)}}};
    return played;
}

Eigen::VectorXcd heard(const PlayedDrives& played, double ringing_s, double duration_s)
{
    const haptics::PressureProbe probe(
        oneTransducer(ringing_s), haptics::Medium(), scheduleOf(played));
    return probe.at(kThere, lastMoments(duration_s, 20e3));
}

TEST(PlayedDrives, RingsAsTheClosedFormSays)
{
    constexpr double kTau_s = 190e-6;
    const Eigen::VectorXcd p_Pa = heard(onAndTurned(), kTau_s, 0.03);
    const double late_s = kThere.norm() / haptics::Medium().soundSpeed();
    const std::complex<double> full_Pa =
        haptics::referencePropagationMatrix(kThere, oneTransducer(kTau_s), haptics::Medium())(0, 0);
    ASSERT_EQ(p_Pa.size(), 600);
    for (Eigen::Index k = 0; k < p_Pa.size(); ++k)
    {
        const double t_s = -0.03 + static_cast<double>(k) / 20e3 - late_s;
        std::complex<double> a = 0.0;
        if (t_s >= -0.02) a = 1.0 - std::exp(-(t_s + 0.02) / kTau_s);
        if (t_s >= -0.01)
            a = std::polar(1.0, 1.0) +
                (1.0 - std::polar(1.0, 1.0)) * std::exp(-(t_s + 0.01) / kTau_s);
        EXPECT_NEAR(std::abs(p_Pa[k] - full_Pa * a), 0.0, 2e-3 * std::abs(full_Pa)) << k;
    }
}

TEST(PlayedDrives, WithoutRingingItIsTheSteadyFieldBitForBit)
{
    PlayedDrives played;
    played.until_s = kNow_s;
    played.fields = {{kNow_s - 0.05, {{0.25F, 0.5F}}}};
    const Eigen::VectorXcd p_Pa = heard(played, 0.0, 0.02);
    const std::complex<double> steady_Pa =
        haptics::referencePropagationMatrix(kThere, oneTransducer(0.0), haptics::Medium())(0, 0) *
        std::complex<double>(0.25, 0.5);
    for (const std::complex<double> one : p_Pa)
        EXPECT_EQ(one, steady_Pa);
}

TEST(PlayedDrives, TakesTheRingingThatASimulationAsksFor)
{
    device::DriveAbility ability;
    EXPECT_EQ(simulatedRinging_s(oneTransducer(1e-4), ability), 1e-4);
    ability.ringing_s = 0.0;
    EXPECT_EQ(simulatedRinging_s(oneTransducer(1e-4), ability), 0.0);
    ability.ringing_s = 2e-4;
    EXPECT_EQ(simulatedRinging_s(oneTransducer(1e-4), ability), 2e-4);
}

TEST(PlayedDrives, OfADeviceIsHeardAfterItsWay)
{
    const auto device = device::openDevice("sim:?ringing=0us", {1, {}});
    device::DriveSignal signal;
    signal.phase = {0};
    signal.duty = {255};
    ASSERT_TRUE(device->send(signal));
    PlayedDrives played = playedOf(*device, 0.02);
    ASSERT_FALSE(played.fields.empty());
    played.until_s = played.fields.back().since_s + 5e-3; // whenever it was asked
    const Eigen::VectorXcd p_Pa = heard(played, 0.0, 0.005);
    EXPECT_EQ(std::abs(p_Pa[1]), 0.0) << "0.1 m are 0.29 ms";
    EXPECT_GT(std::abs(p_Pa[20]), 1.0);
}

TEST(PlayedDrives, OfFieldsAtOneTimeTheLastCounts)
{
    PlayedDrives played = onAndTurned();
    played.fields.insert(played.fields.begin() + 1, {kNow_s - 0.02, {0.5F}});
    EXPECT_EQ(scheduleOf(played).steps.size(), 3U);
    EXPECT_EQ(heard(played, 1e-4, 0.03), heard(onAndTurned(), 1e-4, 0.03));
}

TEST(PlayedDrives, NothingKnownIsSaid)
{
    EXPECT_THROW(scheduleOf({}), base::InputError);
}

} // namespace
} // namespace midair::bridge
