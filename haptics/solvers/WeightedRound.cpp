#include "haptics/solvers/WeightedRound.h"

#include "haptics/points/FittedLevel.h"

#include <algorithm>

namespace midair::haptics
{

void weighPhases(FieldProblem& field, const Eigen::VectorXf& weights)
{
    for (int l = 0; l < field.n(); ++l)
    {
        const auto row = static_cast<std::size_t>(l);
        field.w.set(row, field.u.at(row) * weights[l]);
    }
}

void projectionRound(FieldProblem& field, const Eigen::VectorXf& weights)
{
    weighPhases(field, weights);
    field.projectRound(field.w, field.p);
    field.phasesOf(field.p);
}

void reweigh(const FieldProblem& field, Eigen::VectorXf& weights, float mostReweighing)
{
    const float s = fittedLevel(field.y, field.a);
    for (int l = 0; l < field.n(); ++l)
        weights[l] *= std::clamp(s * field.a[l] / std::max(field.y[l], kLeastPressure),
                                 1.0f / mostReweighing,
                                 mostReweighing);
}

} // namespace midair::haptics
