#include "engine-bridge/solving/ArrayLevels.h"

#include "haptics/base/DutyLaw.h"

#include <cmath>
#include <complex>
#include <cstdint>
#include <sstream>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

device::DriveSignal signalOf(std::uint8_t phase, std::uint8_t duty)
{
    device::DriveSignal signal;
    signal.phase = {phase};
    signal.duty = {duty};
    return signal;
}

} // namespace

TEST(ArrayLevels, FinerPhasesThanASignalHasAreLimitedAndTold)
{
    haptics::DriveResolution fine;
    fine.phaseLevels = 1024;
    EXPECT_TRUE(keepToSignal(fine));
    EXPECT_EQ(fine.phaseLevels, 256);
    EXPECT_TRUE(hasDuties(fine));
    EXPECT_FALSE(keepToSignal(fine)) << "nothing is left to limit";
}

TEST(ArrayLevels, OfASignalTheNearestLevelsArePlayed)
{
    haptics::DriveResolution coarse;
    coarse.phaseLevels = 32;
    coarse.amplitudeLevels = {0.0, 0.5, 1.0};
    EXPECT_FALSE(keepToSignal(coarse));
    // 83 of 256 is 10.4 of 32; sin(pi 90/510) = 0.53.
    const LevelDrive levels = levelsOf(coarse, signalOf(83, 90));
    EXPECT_EQ(levels.phase, std::vector<int>{10});
    EXPECT_EQ(levels.amplitude, std::vector<int>{1});
    const std::complex<float> q = playedBy(coarse, signalOf(83, 90))[0];
    EXPECT_NEAR(std::abs(q), 0.5F, 1e-6F);
    EXPECT_NEAR(std::arg(q), static_cast<float>(2.0 * M_PI * 10 / 32), 1e-6F);
    EXPECT_EQ(levelColumns(coarse), "phase_level_of_32,amplitude_level_of_3");
}

TEST(ArrayLevels, ADriveIsWrittenWithPlacesAndNormals)
{
    haptics::TransducerArray array;
    array.positions = Eigen::Vector3d(0.25, 0.0, -0.125);
    array.normals = Eigen::Vector3d::UnitZ();
    array.board = {0};
    keepToSignal(array.drive);
    std::ostringstream out;
    writeDrive(out, array, signalOf(64, 255));
    EXPECT_EQ(out.str(),
              "x_m,y_m,z_m,nx,ny,nz,phase_level,duty_level\n0.25,0,-0.125,0,0,1,64,255\n");
}

} // namespace midair::bridge
