#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/surface/Outline.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <vector>

namespace midair::haptics
{

struct SelectorOptions;

/// Tells which places an array can reach; made once for an array and a wavelength.
class Workspace
{
public:
    enum class Verdict
    {
        INSIDE,
        TOO_CLOSE,
        BEHIND, ///< every transducer faces away, or the board of the nearest one is in between
        OUT_OF_REACH
    };

    /// Throws InputError for an array without transducers, a wavelength that is not positive and
    /// options out of range.
    Workspace(const TransducerArray& array, double wavelength_m, const SelectorOptions& options);

    Verdict judge(const Eigen::Vector3d& point) const;
    double minDistance_m() const { return _minDistance; }
    double reach_m() const { return _reach; }
    double wavelength_m() const { return _wavelength; }

private:
    struct Plane
    {
        Eigen::Vector3d normal;
        double offset;
        Eigen::Vector3d sample; ///< one of its transducers
    };

    Eigen::Matrix3Xd _positions;
    Eigen::Matrix3Xd _normals;
    std::vector<Plane> _planes; ///< the distinct planes that transducers lie in
    double _wavelength;
    double _minDistance;
    double _reach = 0.0;
};

/// The feature edges of a mesh in the array's frame, by whether the array reaches them. A field for
/// outlines has no points to leave out, so one that is reached in part isn't reached.
struct ReachedOutlines
{
    std::vector<Outline> inside; ///< reached from one end to the other
    int outside = 0;             ///< number of the others
    int apart = 0;               ///< number of the mesh's points, which are on no outline
    double points = 0.0;         ///< half a wavelength apart along those inside
};

/// Sorts the outlines of \a mesh, which \a pose takes to the array's frame and whose target is
/// \a target, by \a workspace. Outlines of more than base::kMostControlPoints points half a
/// wavelength apart count as outside. Throws as featureOutlines() does.
ReachedOutlines reachedOutlines(const TriangleMesh& mesh,
                                const Eigen::Isometry3d& pose,
                                double target,
                                const Workspace& workspace,
                                const base::StopToken& stop = {});

} // namespace midair::haptics
