#include "haptics/points/FeltPlaces.h"

namespace midair::haptics
{

ControlPoints feltPlaces(const Eigen::Matrix3Xd& samples,
                         const ControlPoints& points,
                         double reach_m,
                         const base::StopToken& stop)
{
    ControlPoints places;
    places.absolute = points.absolute;
    places.positions.resize(3, samples.cols());
    places.targets.resize(samples.cols());
    Eigen::Index count = 0;
    base::StopLook look(stop);
    for (const auto& sample : samples.colwise())
    {
        look.turn();
        if (points.size() == 0) continue;
        Eigen::Index nearest = 0;
        const double distance2 =
            (points.positions.colwise() - sample).colwise().squaredNorm().minCoeff(&nearest);
        if (!(distance2 <= reach_m * reach_m)) continue;
        places.positions.col(count) = sample;
        places.targets[count++] = points.targets[nearest];
    }
    places.positions.conservativeResize(3, count);
    places.targets.conservativeResize(count);
    places.normals = Eigen::Matrix3Xd::Zero(3, count);
    return places;
}

} // namespace midair::haptics
