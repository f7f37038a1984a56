#include "haptics/sequence/FocusShare.h"

#include "haptics/propagation/ReferencePropagation.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

void holdToShare(const std::vector<int>& small,
                 int whole,
                 double loudness,
                 const TransducerArray& array,
                 const Medium& medium,
                 ControlPoints& points)
{
    const double most = small.empty() ? 0.0 : points.targets.maxCoeff();
    if (!(most > 0.0)) return;
    const double now = points.size();
    const double all = std::max(now, now - static_cast<double>(small.size()) + whole);
    const bool isAlone = !points.absolute && small.size() == static_cast<std::size_t>(now);
    const Eigen::VectorXd reached_Pa =
        referencePropagationMatrix(pick(points, small).positions, array, medium)
            .cwiseAbs()
            .rowwise()
            .sum();
    const double share = kSureShare * std::min(loudness, 1.0) / std::sqrt(all);
    for (std::size_t i = 0; i < small.size(); ++i)
    {
        double& target = points.targets[small[i]];
        const double sure_Pa = share * reached_Pa[static_cast<Eigen::Index>(i)];
        if (isAlone)
            target *= sure_Pa / most;
        else if (points.absolute)
            target = std::min(target, sure_Pa);
        else
            target *= std::sqrt(now / all);
    }
    points.absolute = points.absolute || isAlone;
}

} // namespace midair::haptics
