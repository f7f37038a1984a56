#include "engine-bridge/playing/EarBound.h"

#include "tests/engine-bridge/playing/EarTrials.h"

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

// The benchmark of ears does ten thousand of them.
TEST(EarBound, NoPlayedFieldIsOverTheLimitAtAnyPlace)
{
    int held = 0;
    int untouched = 0;
    int silent = 0;
    for (const char* name : {"board", "ultraino64"})
    {
        EarTrials trials(haptics::TransducerArray::load(name), 11, 6);
        for (int k = 0; k < 150; ++k)
        {
            const EarTrials::Outcome one = trials.next();
            EXPECT_LE(one.loudest_dB, one.limit_dB)
                << name << ", trial " << k << (one.isModulated ? ", modulated" : "");
            held += one.factor < 1.0 && one.factor > 0.0 ? 1 : 0;
            silent += one.factor <= 0.0 ? 1 : 0;
            untouched += one.factor >= 1.0 ? 1 : 0;
        }
    }
    EXPECT_GT(held, 150) << "or this shows little";
    EXPECT_GT(untouched, 5);
    EXPECT_LT(silent, 40);
}

TEST(EarBound, TheLimitIsUsedUpTo)
{
    const haptics::TransducerArray array = haptics::TransducerArray::singleBoard();
    const Eigen::Matrix3Xd place = Eigen::Vector3d(0.0, 0.0, 0.5);
    const auto exposure = std::make_shared<haptics::Exposure>(array, haptics::Medium(), place);
    // A focus on the ear: its own pressure decides, not the mean over phases.
    const double k = 2.0 * M_PI * array.frequency_Hz / haptics::Medium().soundSpeed();
    Eigen::VectorXcf q(array.size());
    for (Eigen::Index i = 0; i < q.size(); ++i)
        q[i] = std::complex<float>(
            std::polar(1.0, k * (place.col(0) - array.positions.col(i)).norm()));
    const double level_dB =
        haptics::soundLevel_dB(static_cast<double>(exposure->coherent_Pa2(q)[0]));
    const device::DriveAbility ability;
    EXPECT_NEAR(EarBound(level_dB, exposure).excess(q, 0.0f, ability), 1.0, 1e-3);
    EXPECT_NEAR(EarBound(level_dB - 20.0, exposure).excess(q, 0.0f, ability), 10.0, 1e-2);
    // What rounding by half a drive may change counts like noise, with its 6.6 dB.
    const double noise = 0.5 * std::sqrt(haptics::Exposure::kSpeckle *
                                         static_cast<double>(exposure->incoherent_Pa2(q)[0]) /
                                         haptics::meanSquareOf_Pa2(level_dB));
    EXPECT_GT(noise, 0.05);
    EXPECT_NEAR(EarBound(level_dB, exposure).excess(q, 0.5f, ability), 1.0 + noise, 1e-3);
    // With other phases the mean and its 6.6 dB do.
    for (Eigen::Index i = 0; i < q.size(); ++i)
        q[i] *= i % 2 == 0 ? 1.0f : -1.0f;
    const double mean_dB =
        haptics::soundLevel_dB(static_cast<double>(exposure->incoherent_Pa2(q)[0]));
    EXPECT_NEAR(EarBound(mean_dB + 10.0 * std::log10(haptics::Exposure::kSpeckle), exposure)
                    .excess(q, 0.0f, ability),
                1.0,
                1e-3);
    EXPECT_EQ(EarBound(100.0, exposure).excess(0.0f * q, 0.0f, ability), 0.0);
    q[3] = std::nanf("");
    EXPECT_TRUE(std::isnan(EarBound(100.0, exposure).excess(q, 0.0f, ability)));
}

// Where two halves work against each other at an ear, each is louder alone.
TEST(EarBound, HoldsForEachPartOfTheArrayAlone)
{
    const haptics::TransducerArray array = haptics::TransducerArray::singleBoard();
    const Eigen::Matrix3Xd place = Eigen::Vector3d(0.0, 0.0, 0.5);
    const auto exposure = std::make_shared<haptics::Exposure>(array, haptics::Medium(), place);
    device::DriveAbility ability;
    const double k = 2.0 * M_PI * array.frequency_Hz / haptics::Medium().soundSpeed();
    Eigen::VectorXcf q(array.size());
    for (Eigen::Index i = 0; i < q.size(); ++i)
    {
        ability.part.push_back(static_cast<int>(i % 2));
        q[i] = std::complex<float>(
            std::polar(1.0, k * (place.col(0) - array.positions.col(i)).norm()));
        if (i % 2 == 1) q[i] = -q[i];
    }
    const EarBound bound(110.0, exposure);
    EXPECT_GT(bound.excess(q, 0.0f, ability), 3.0 * bound.excess(q, 0.0f, {}));
}
