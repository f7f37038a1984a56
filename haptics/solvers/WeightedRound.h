#pragma once

#include "haptics/solvers/FieldProblem.h"

#include <Eigen/Core>

/// A round of weighted Gerchberg-Saxton between the points and the transducers, which play unit
/// amplitudes (SOLVER.md, "Rounds").
namespace midair::haptics
{

/// Sets field.w to w_l u_l, where u = field.u are the phases of the pressures.
void weighPhases(FieldProblem& field, const Eigen::VectorXf& weights);

/// Makes a round: z = G* (w u), q = z/|z|, p = G q, y = |p|, u = p/|p|, all in \a field. Reads G
/// once.
void projectionRound(FieldProblem& field, const Eigen::VectorXf& weights);

/// Multiplies each weight w_l by s a_l/|p_l|, limited to 1/mostReweighing .. mostReweighing; s is
/// the fitted level.
void reweigh(const FieldProblem& field, Eigen::VectorXf& weights, float mostReweighing = 5.0f);

} // namespace midair::haptics
