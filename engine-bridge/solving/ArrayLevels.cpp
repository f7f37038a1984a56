#include "engine-bridge/solving/ArrayLevels.h"

#include "device/drive/DriveEncoder.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <complex>
#include <locale>
#include <ostream>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

constexpr int kSignalPhases = 256;

// The nearest of \a levels to a level of 256; a tie is possible only for phases that no solver has
// rounded to this array.
int phaseLevelOf(int phase, int levels)
{
    return (2 * phase * levels + kSignalPhases) / (2 * kSignalPhases) % levels;
}

int amplitudeLevelOf(float amplitude, const std::vector<float>& levels)
{
    // Off stays off, even if the array's lowest level is not 0.
    if (!(amplitude > 0.0f)) return levels.front() > 0.0f ? -1 : 0;
    const auto above = std::lower_bound(levels.begin(), levels.end(), amplitude);
    const auto index = static_cast<int>(above - levels.begin());
    if (above == levels.end()) return index - 1;
    if (above != levels.begin() && amplitude - *(above - 1) < *above - amplitude) return index - 1;
    return index;
}

} // namespace

bool keepToSignal(haptics::DriveResolution& drive)
{
    if (drive.amplitudeLevels.empty()) drive.amplitudeLevels = device::amplitudeLevels();
    if (drive.phaseLevels >= 2 && drive.phaseLevels <= kSignalPhases) return false;
    drive.phaseLevels = kSignalPhases;
    return true;
}

LevelDrive levelsOf(const haptics::DriveResolution& drive, const device::DriveSignal& signal)
{
    const std::vector<float>& duties = device::amplitudeLevels();
    std::vector<int> levelOfDuty(duties.size());
    for (std::size_t duty = 0; duty < duties.size(); ++duty)
        levelOfDuty[duty] = amplitudeLevelOf(duties[duty], drive.amplitudeLevels);
    LevelDrive levels;
    levels.phase.reserve(signal.phase.size());
    levels.amplitude.reserve(signal.duty.size());
    for (const std::uint8_t phase : signal.phase)
        levels.phase.push_back(phaseLevelOf(phase, drive.phaseLevels));
    for (const std::uint8_t duty : signal.duty)
        levels.amplitude.push_back(levelOfDuty[duty]);
    return levels;
}

Eigen::VectorXcf playedBy(const haptics::DriveResolution& drive, const device::DriveSignal& signal)
{
    const LevelDrive levels = levelsOf(drive, signal);
    std::vector<std::complex<float>> phasors;
    for (int level = 0; level < drive.phaseLevels; ++level)
        phasors.emplace_back(std::polar(1.0, base::kTwoPi * level / drive.phaseLevels));
    Eigen::VectorXcf q = Eigen::VectorXcf::Zero(signal.size());
    for (Eigen::Index i = 0; i < q.size(); ++i)
    {
        const auto index = static_cast<std::size_t>(i);
        const int amplitude = levels.amplitude[index];
        if (amplitude >= 0)
            q[i] = drive.amplitudeLevels[static_cast<std::size_t>(amplitude)] *
                   phasors[static_cast<std::size_t>(levels.phase[index])];
    }
    return q;
}

bool hasDuties(const haptics::DriveResolution& drive)
{
    return drive.amplitudeLevels == device::amplitudeLevels();
}

std::string levelColumns(const haptics::DriveResolution& drive)
{
    const std::string phase = drive.phaseLevels == kSignalPhases
                                  ? "phase_level"
                                  : fmt::format("phase_level_of_{}", drive.phaseLevels);
    return phase + "," +
           (hasDuties(drive) ? "duty_level"
                             : fmt::format("amplitude_level_of_{}", drive.amplitudeLevels.size()));
}

void writeDrive(std::ostream& out,
                const haptics::TransducerArray& array,
                const device::DriveSignal& signal)
{
    out.imbue(std::locale::classic());
    out.precision(9);
    const LevelDrive levels = levelsOf(array.drive, signal);
    out << "x_m,y_m,z_m,nx,ny,nz," << levelColumns(array.drive) << '\n';
    for (int i = 0; i < array.size(); ++i)
    {
        for (int axis = 0; axis < 3; ++axis)
            out << array.positions(axis, i) << ',';
        for (int axis = 0; axis < 3; ++axis)
            out << array.normals(axis, i) << ',';
        const auto index = static_cast<std::size_t>(i);
        out << levels.phase[index] << ',' << levels.amplitude[index] << '\n';
    }
}

} // namespace midair::bridge
