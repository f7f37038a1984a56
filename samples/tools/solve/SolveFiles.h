#pragma once

#include "device/drive/DriveSignal.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/probe/FingertipForce.h"
#include "haptics/scattering/SceneScattering.h"
#include "haptics/sequence/ReflectorFigures.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/certificate/Certificate.h"

#include <osgMidair/ExposureFigures>

#include <Eigen/Core>

#include <fstream>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace midair::samples
{

/// Returns the text of a regular file of at most 64 MiB. Throws base::InputError with its name.
std::string textOf(const std::string& path);

/// Reads listening places (3 x n) from a CSV file with a header line that has x_m, y_m and z_m, in
/// any order; other columns are ignored. At most 100,000 places. Throws base::InputError that names
/// the file and the line.
Eigen::Matrix3Xd readEars(const std::string& path);

/// Reads control points from a CSV file with a header line: x_m,y_m,z_m,nx,ny,nz and either
/// target_Pa (absolute) or target (relative). Columns may be in any order; others are ignored. The
/// file must be a regular one of at most 64 MiB and 100,000 points. Throws base::InputError that
/// names the file and the line.
haptics::ControlPoints readControlPoints(const std::string& path);

/// A text file that is written from its beginning. All functions throw base::InputError with its
/// name.
class TextFile
{
public:
    explicit TextFile(std::string path);

    std::ofstream& stream() { return _file; }
    /// Writes a line.
    template<typename... Values>
    void line(fmt::format_string<Values...> format, Values&&... values)
    {
        _file << fmt::format(format, std::forward<Values>(values)...) << '\n';
    }
    void finish();

private:
    std::string _path;
    std::ofstream _file;
};

/// Writes x_m,y_m,z_m,nx,ny,nz,target_Pa,achieved_Pa: one row per control point; pressures are peak
/// amplitudes.
void writeControlPoints(const std::string& path,
                        const haptics::ControlPoints& points,
                        const Eigen::VectorXd& target_Pa,
                        const Eigen::VectorXd& achieved_Pa);

/// Writes x_m,y_m,z_m,nx,ny,nz and the levels that the array plays for \a signal: one row per
/// transducer, in the array's order. The last two columns are those of levelColumns(): phase_level
/// L of 256 means e^{+j 2 pi L/256}, and duty_level L of 256 the relative amplitude sin(pi L/510).
/// For an array with other levels, phase_level_of_N means e^{+j 2 pi L/N}, and amplitude_level_of_N
/// is the index, from 0, into its amplitudeLevels (-1: off, if they have no 0). The array's levels
/// must have passed keepToSignal().
void writeDrive(const std::string& path,
                const haptics::TransducerArray& array,
                const device::DriveSignal& signal);

/// What reflectors do to the drives.
struct SolvedReflectors
{
    int count = 0;
    bool isCorrected = false;         ///< the drives are solved for them
    haptics::ReflectorFigures played; ///< of the drives
    haptics::ReflectorFigures other;  ///< of the drives that weren't taken; 0: not solved
    int hidden = 0;                   ///< transducers behind them
    double freeEars_dB = 0.0;         ///< level at the ears without them
};

/// What a thing in the field does to the drives, whose report includes it.
struct SolvedScatterer
{
    std::string what;                  ///< what it is and where, if that isn't given; else empty
    std::string whyUncorrected;        ///< empty: the drives are solved for it
    double rms = 0.0;                  ///< of the drives, as in the report
    double level_Pa = 0.0;             ///< FieldFigures::level_Pa, the same
    double uncorrectedRms = 0.0;       ///< of the drives that aren't solved for it
    double uncorrectedLevel_Pa = 0.0;  ///< of these
    haptics::ScatteringFigures change; ///< by the thing, of the pressures of the drives
};

/// Values of a summary besides the report; missing ones are omitted.
struct SummaryParts
{
    int fields = 1; ///< number of fields played in turn, including steps between them
    double fieldRate_Hz = 0.0;
    haptics::FingertipForce fingertip; ///< at the strongest point
    bool evened = false;               ///< the report rates all fields together, not each one
    std::optional<haptics::Certificate> certificate;
    /// Figures with ringing: level and errors as in the report, with each point's pressure scaled
    /// by the share that ringing leaves of its mean over the fields. Fields in turn only.
    std::optional<haptics::SolveReport> ringing;
    haptics::ExposureFigures exposure;          ///< while these fields play without end
    std::optional<SolvedReflectors> reflectors; ///< if there are any
    std::optional<SolvedScatterer> scatterer;   ///< if there is one
};

/// Writes what is needed to recompute the field, the SolveReport under "report", and \a parts.
void writeSummary(const std::string& path,
                  const haptics::TransducerArray& array,
                  const haptics::Medium& medium,
                  const haptics::SolveReport& report,
                  const SummaryParts& parts);

} // namespace midair::samples
