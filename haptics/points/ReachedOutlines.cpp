#include "haptics/points/ReachedOutlines.h"

#include "haptics/base/Limits.h"
#include "haptics/surface/FeatureChains.h"
#include "haptics/surface/SurfaceSampler.h"

#include <utility>

namespace midair::haptics
{

namespace
{

// Spacing of the points at which an outline is checked; those that it is solved for are denser.
constexpr double kLook_wavelengths = 0.5;

bool areInside(const Eigen::Matrix3Xd& points, const Workspace& workspace)
{
    for (const auto& point : points.colwise())
        if (workspace.judge(point) != Workspace::Verdict::INSIDE) return false;
    return true;
}

} // namespace

ReachedOutlines reachedOutlines(const TriangleMesh& mesh,
                                const Eigen::Isometry3d& pose,
                                double target,
                                const Workspace& workspace,
                                const base::StopToken& stop)
{
    const double look_m = kLook_wavelengths * workspace.wavelength_m();
    ReachedOutlines reached;
    for (Outline& outline : featureOutlines(mesh,
                                            SamplerOptions().creaseAngle_rad,
                                            workspace.wavelength_m(),
                                            stop,
                                            &reached.apart))
    {
        outline.vertices = (pose * outline.vertices).eval();
        outline.target = target;
        const double points = pointsAlong({outline}, look_m); // before points() allocates them
        if (points > base::kMostControlPoints || !areInside(outline.points(look_m), workspace))
        {
            ++reached.outside;
            continue;
        }
        reached.points += points;
        reached.inside.push_back(std::move(outline));
    }
    return reached;
}

} // namespace midair::haptics
