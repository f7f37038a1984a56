#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/sequence/Modulator.h"
#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// What is to be played: one field that is held, or several that are played in turn, over and over.
struct FieldSequence
{
    /// K fields of m activations each, |q_i| <= 1, in the order in which they are played; none:
    /// nothing could be made, and the report says why.
    std::vector<Eigen::VectorXcf> fields;
    /// parts[k]: the points that fields[k] is for, at their full targets. As many as fields or
    /// fewer; a field without a part, or with an empty one, is a step between others.
    std::vector<ControlPoints> parts;
    /// Amplitude modulation of all of it, and how fast fields follow each other.
    ModulatorOptions modulation;
    /// Of all fields together; of each at its own points.
    SolveReport report;

    bool isHeld() const { return fields.size() == 1; }
    bool isEmpty() const { return fields.empty(); }
    /// Whether what is to be played changes with time: several fields, or a modulation.
    bool changes() const { return fields.size() > 1 || modulation.amplitudeRate_Hz > 0.0; }
    /// The points of all parts, in playing order.
    ControlPoints points() const;
};

/// |p| at the points of \a sequence (n, in the order of points()), each in the field that is for
/// it. Throws base::Stopped where \a stop asks for that.
Eigen::VectorXf achievedPressure(const FieldSequence& sequence,
                                 const TransducerArray& array,
                                 const Medium& medium,
                                 int threads,
                                 const base::StopToken& stop = {});

/// Puts new figures into \a report (rms, max, level, loudness, points that fall short) for a field
/// that was scaled after it was solved; \a achieved_Pa are |p| at \a points (n).
void rateLevel(const ControlPoints& points,
               const Eigen::VectorXf& achieved_Pa,
               SolveReport& report);

/// Puts into the report how much \a sequence's fields differ from one to the next, the step from
/// the last to the first among them: meanPhaseStep_rad, driveChange, and audibleChange at the field
/// rate. All are 0 for a single field.
void rateSteps(FieldSequence& sequence);

/// Turns a held \a sequence by the common phase that brings it nearest to \a last, which it follows
/// at \a rate_Hz, and puts that step into its report. The turn cannot be felt. Does nothing where
/// the sequence is not held or the lengths differ.
void continueFrom(const Eigen::VectorXcf& last,
                  double rate_Hz,
                  const DriveResolution& drive,
                  FieldSequence& sequence);

} // namespace midair::haptics
