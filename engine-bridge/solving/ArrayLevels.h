#pragma once

#include "device/drive/DriveSignal.h"
#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <iosfwd>
#include <string>
#include <vector>

namespace midair::bridge
{

/// One field in the array's own levels, m each, as a drive.csv holds it and as the array plays it:
///     q_i = amplitudeLevels[amplitude_i] e^{+j 2 pi phase_i / phaseLevels}.
struct LevelDrive
{
    std::vector<int> phase;     ///< 0 .. phaseLevels - 1
    std::vector<int> amplitude; ///< index into amplitudeLevels; -1: off, in a list without a 0
};

/// Limits \a drive to the range of a DriveSignal: at most 256 phases, also instead of continuous
/// ones, and the 256 duty amplitudes if it lists none. Returns true if there are fewer phases now.
bool keepToSignal(haptics::DriveResolution& drive);

/// Returns the nearest levels to \a signal on an array of \a drive, which was limited by
/// keepToSignal().
LevelDrive levelsOf(const haptics::DriveResolution& drive, const device::DriveSignal& signal);

/// Returns the activations (m) of levelsOf().
Eigen::VectorXcf playedBy(const haptics::DriveResolution& drive, const device::DriveSignal& signal);

/// Returns true if the amplitudes are those of the duty levels 0 .. 255 (base::dutyAmplitude).
bool hasDuties(const haptics::DriveResolution& drive);

/// Returns the names of drive.csv's last two columns: phase_level and duty_level for 256 levels;
/// phase_level_of_N and amplitude_level_of_N for another number N, so that different meanings can't
/// be confused.
std::string levelColumns(const haptics::DriveResolution& drive);

/// Writes a drive.csv: x_m,y_m,z_m,nx,ny,nz and the columns of levelColumns(), one row per
/// transducer; numbers have 9 digits and a decimal point.
void writeDrive(std::ostream& out,
                const haptics::TransducerArray& array,
                const device::DriveSignal& signal);

} // namespace midair::bridge
