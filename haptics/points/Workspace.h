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

/// Decides which places an array can reach; made once per array and wavelength.
class Workspace
{
public:
    enum class Verdict
    {
        INSIDE,
        TOO_CLOSE,
        BEHIND, ///< every transducer faces away, or the nearest one's board is in between
        OUT_OF_REACH,
        AT_REFLECTOR ///< nearer than a wavelength to a reflector, whose images are no waves there
    };

    /// Throws InputError for an array without transducers, a wavelength that is not positive, and
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
    std::vector<Reflector> _reflectors;
    double _wavelength;
    double _minDistance;
    double _reach = 0.0;
};

/// Feature edges of a mesh in the array frame, by reachability. A field for outlines can't leave
/// out points, so a partly reached outline counts as not reached.
struct ReachedOutlines
{
    std::vector<Outline> inside; ///< reached from end to end
    int outside = 0;             ///< number of the others
    int apart = 0;               ///< mesh points that are on no outline
    double points = 0.0;         ///< points half a wavelength apart along inside
};

/// Sorts the outlines of \a mesh by \a workspace; \a pose is mesh -> array, \a target their target.
/// Outlines of more than base::kMostControlPoints points at half a wavelength count as outside.
/// Throws as featureOutlines() does.
ReachedOutlines reachedOutlines(const TriangleMesh& mesh,
                                const Eigen::Isometry3d& pose,
                                double target,
                                const Workspace& workspace,
                                const base::StopToken& stop = {});

} // namespace midair::haptics
