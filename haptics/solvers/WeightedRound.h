#pragma once

#include "haptics/solvers/FieldProblem.h"

#include <Eigen/Core>

/// A round of weighted Gerchberg-Saxton between the points and transducers of unit amplitude
/// (SOLVER.md, "Rounds").
namespace midair::haptics
{

/// field.w = w_l u_l, with u the phases of the field at hand.
void weighPhases(FieldProblem& field, const Eigen::VectorXf& weights);

/// z = G* (w u), q = z/|z|, p = G q, u = p/|p|: leaves field.z, q, p, y and u. G is read once.
void projectionRound(FieldProblem& field, const Eigen::VectorXf& weights);

/// w_l <- w_l s a_l/|p_l|, by a factor of at most \a mostReweighing either way; s is the fitted
/// level.
void reweigh(const FieldProblem& field, Eigen::VectorXf& weights, float mostReweighing = 5.0f);

} // namespace midair::haptics
