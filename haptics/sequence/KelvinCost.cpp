#include "haptics/sequence/KelvinCost.h"

#include "haptics/base/Limits.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/PressureField.h"

#include <vector>

namespace midair::haptics
{

KelvinCost kelvinCost(const ControlPoints& points,
                      const Eigen::VectorXcf& q,
                      const TransducerArray& array,
                      const Medium& medium,
                      int threads,
                      const base::StopToken& stop)
{
    std::vector<Eigen::Index> kept;
    for (Eigen::Index l = 0; l < points.size(); ++l)
        if (points.targets[l] > 0.0) kept.push_back(l);
    KelvinCost cost;
    if (kept.empty() || q.size() != array.size()) return cost;
    const Eigen::Matrix3Xd places = points.positions(Eigen::all, kept);
    Eigen::VectorXd a = points.targets(kept);
    raiseTargets(a);
    const auto pressure_Pa = [&](const Medium& air) -> Eigen::VectorXd
    { return pressureAt(places, array, air, q, threads, stop).cwiseAbs().cast<double>(); };
    Medium other = medium;
    other.temperature_C += medium.temperature_C + 1.0 <= base::kMostTemperature_C ? 1.0 : -1.0;
    const double level = fittedLevel(pressure_Pa(medium), a);
    const Eigen::VectorXd y = pressure_Pa(other);
    const double otherLevel = fittedLevel(y, a);
    if (!(level > 0.0) || !(otherLevel > 0.0)) return cost;
    cost.level = otherLevel / level;
    cost.rms = relativeErrors(y, a, points.absolute ? 1.0 : otherLevel).rms;
    return cost;
}

} // namespace midair::haptics
