#pragma once

#include "device/drive/DriveSignal.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/certificate/Certificate.h"

#include <Eigen/Core>

#include <optional>
#include <string>

namespace midair::samples
{

/// Reads control points from a CSV file with a header line: x_m,y_m,z_m,nx,ny,nz and either
/// target_Pa (absolute) or target (relative). Columns may be in any order; others are ignored. The
/// file must be a regular one of at most 64 MiB and 100,000 points. Throws base::InputError that
/// names the file and the line.
haptics::ControlPoints readControlPoints(const std::string& path);

/// Writes x_m,y_m,z_m,nx,ny,nz,target_Pa,achieved_Pa: one row per control point; pressures are peak
/// amplitudes.
void writeControlPoints(const std::string& path,
                        const haptics::ControlPoints& points,
                        const Eigen::VectorXd& target_Pa,
                        const Eigen::VectorXd& achieved_Pa);

/// Writes x_m,y_m,z_m,nx,ny,nz,phase_level,duty_level: one row per transducer, in the array's
/// order.
void writeDrive(const std::string& path,
                const haptics::TransducerArray& array,
                const device::DriveSignal& signal);

/// Values of a summary besides the report; missing ones are left out.
struct SummaryParts
{
    int fields = 1; ///< number of fields played in turn, steps between them included
    double fieldRate_Hz = 0.0;
    std::optional<haptics::Certificate> certificate;
};

/// Writes what is needed to recompute the field, the SolveReport under "report", and \a parts.
void writeSummary(const std::string& path,
                  const haptics::TransducerArray& array,
                  const haptics::Medium& medium,
                  const haptics::SolveReport& report,
                  const SummaryParts& parts);

} // namespace midair::samples
