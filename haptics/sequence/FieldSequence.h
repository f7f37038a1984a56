#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/sequence/Modulator.h"
#include "haptics/solvers/HologramSolver.h"

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace midair::haptics
{

/// What something outside an array's model adds to the pressures of a held field (ControlPoints'
/// outside_Pa), and the drive that it belongs to.
struct OutsideField
{
    Eigen::VectorXcd pressure_Pa; ///< o at the points (n), Pa
    Eigen::VectorXcf drive;       ///< q0 (m)

    /// Returns o (q0^H q)/|q0|^2 (n), what is added to a drive \a q that was lowered or turned.
    Eigen::VectorXcd at(const Eigen::VectorXcf& q) const;
};

/// Fields to play: one field that is held, or several in turn, repeated.
struct FieldSequence
{
    /// K fields of m activations each, |q_i| <= 1, in playing order; empty: they could not be made,
    /// and the report gives the reason.
    std::vector<Eigen::VectorXcf> fields;
    /// parts[k]: the points that fields[k] was made for, with their full targets. Not more than
    /// fields; a field without a part, or with an empty one, is an intermediate step.
    std::vector<ControlPoints> parts;
    /// Amplitude modulation of the whole sequence, and the rate of its fields.
    ModulatorOptions modulation;
    /// True: the fields are evened out together, so that only their average meets the targets.
    /// Figures then refer to the root of the mean of |p|^2 over all fields.
    bool evened = false;
    /// 0 .. 1; the fields are played at no more than this share of their amplitudes: a cap lowered
    /// the field that they come from to it, and what is even at the cap's places would pass it
    /// elsewhere.
    double most = 1.0;
    /// |p| of a held field at points() from its solver (HologramSolver::achieved_Pa()), Pa (n);
    /// empty: unknown. Code that changes the field clears it.
    Eigen::VectorXf achieved_Pa;
    /// Of a held field that isn't evened, at points(); null: nothing is known. The solver's
    /// achieved_Pa don't count it.
    std::shared_ptr<const OutsideField> outside;
    /// Report on all fields together, each at its own points; if evened, on their average.
    SolveReport report;

    bool isHeld() const { return fields.size() == 1; }
    bool isEmpty() const { return fields.empty(); }
    /// Returns true if the output changes with time: several fields, or a modulation.
    bool changes() const { return fields.size() > 1 || modulation.amplitudeRate_Hz > 0.0; }
    /// Returns the points of all parts, in playing order.
    ControlPoints points() const;
};

/// Scales \a fields down by a common factor, until no amplitude exceeds \a cap (0 .. 1) or the next
/// drive level below it, because rounding could raise it above the cap again. Returns true if that
/// changed them.
bool keepAmplitudes(double cap, std::vector<Eigen::VectorXcf>& fields);

/// Returns |p| at the points of \a sequence (n, in the order of points()), each in the field made
/// for it, with what is outside; for an evened sequence the root of the mean of |p|^2 over all
/// fields. Throws base::Stopped if \a stop requests it.
Eigen::VectorXf achievedPressure(const FieldSequence& sequence,
                                 const TransducerArray& array,
                                 const Medium& medium,
                                 int threads,
                                 const base::StopToken& stop = {});

/// Updates \a report (rms, max, level, loudness, points that fall short) for a field that was
/// scaled after its solve. \a achieved_Pa: |p| at \a points (n). The errors of silence are 1. \a
/// least_Pa: lower bound of the largest target, for targets in Pa.
void rateLevel(const ControlPoints& points,
               const Eigen::VectorXf& achieved_Pa,
               SolveReport& report,
               double least_Pa = 0.0);

/// Updates the report's figures of the steps between the fields of \a sequence, including that from
/// the last to the first: meanPhaseStep_rad, driveChange, and audibleChange at the field rate. All
/// are 0 for a single field.
void rateSteps(FieldSequence& sequence);

/// Updates ringingShare and ringingModulation in the report of \a sequence for transducers that
/// ring with \a ringing_s (0 .. kMostRinging_s). If fields and modulation don't repeat together
/// within 512 steps, the share is that of about as many.
void rateRinging(FieldSequence& sequence, double ringing_s);

/// Updates ringingShare in the report of a held \a sequence whose field replaces the settled field
/// \a last: the power of the first 1/\a rate_Hz. Does nothing if it is not held, if the lengths
/// differ, and if \a last or the field is silent.
void rateSwitch(const Eigen::VectorXcf& last,
                double rate_Hz,
                double ringing_s,
                FieldSequence& sequence);

/// Turns the field of a held \a sequence by the common phase, which cannot be felt, that brings it
/// nearest to \a last, and updates its report for this step, at \a rate_Hz. Does nothing if the
/// sequence is not held or the lengths differ.
void continueFrom(const Eigen::VectorXcf& last,
                  double rate_Hz,
                  const DriveResolution& drive,
                  FieldSequence& sequence);

/// Updates the report of a held \a sequence for the step from \a last to its field, without turning
/// either, at \a rate_Hz: meanPhaseStep_rad, driveChange and audibleChange. Does nothing if the
/// sequence is not held or the lengths differ.
void rateStep(const Eigen::VectorXcf& last, double rate_Hz, FieldSequence& sequence);

} // namespace midair::haptics
