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

/// Limits \a drive to what a DriveSignal can ask of an array: at most 256 phases, also where it
/// has more or continuous ones, and the duties' 256 amplitudes where it lists none. Returns true if
/// the phases became fewer.
bool keepToSignal(haptics::DriveResolution& drive);

/// Returns the levels that an array of \a drive, which keepToSignal() has limited, plays of \a
/// signal: of each phase and each amplitude the nearest one.
LevelDrive levelsOf(const haptics::DriveResolution& drive, const device::DriveSignal& signal);

/// Returns the activations (m) of levelsOf().
Eigen::VectorXcf playedBy(const haptics::DriveResolution& drive, const device::DriveSignal& signal);

/// Returns true if the amplitudes are those of the duty levels 0 .. 255 (base::dutyAmplitude).
bool hasDuties(const haptics::DriveResolution& drive);

/// Returns the names of drive.csv's last two columns: phase_level and duty_level for 256 levels;
/// phase_level_of_N and amplitude_level_of_N for any other number N, so that levels of another
/// meaning are not read as these.
std::string levelColumns(const haptics::DriveResolution& drive);

/// Writes what a drive.csv holds: x_m,y_m,z_m,nx,ny,nz and the columns of levelColumns(), a row for
/// each transducer; numbers have 9 digits and a decimal point.
void writeDrive(std::ostream& out,
                const haptics::TransducerArray& array,
                const device::DriveSignal& signal);

} // namespace midair::bridge
