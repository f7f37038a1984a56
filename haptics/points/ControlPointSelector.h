#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/points/Workspace.h"
#include "haptics/surface/SurfaceSampler.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace midair::haptics
{

/// Samples of one object in the array frame; all matrices and vectors have the same length.
struct PosedObject
{
    int object = 0;      ///< index for ControlPoints::object
    int priority = 0;    ///< points of higher priority win
    double target = 1.0; ///< > 0; multiplied by the intensity
    /// > 0; minimum distance to points of other objects (the larger of both objects counts)
    double spacing_m = 8.5e-3;
    Eigen::Matrix3Xd positions;          ///< 3 x n, metres, array frame
    Eigen::Matrix3Xd normals;            ///< 3 x n
    Eigen::VectorXf intensity;           ///< n or empty: 1
    std::vector<std::uint64_t> identity; ///< n or empty, see ControlPoints::identity

    /// Sets positions, normals and intensity from \a samples; allocates only if their number
    /// changes. Sample i gets the identity \a first + i.
    void pose(const SurfaceSamples& samples,
              const Eigen::Isometry3d& meshToArray,
              std::uint64_t first = 0);
    /// Keeps the samples for which \a isKept(index) is true.
    void keepIf(const std::function<bool(Eigen::Index)>& isKept);
};

/// Point that competes for the budget.
struct BudgetPoint
{
    int priority;
    int object; ///< breaks ties of equal remainders
    int source; ///< the source whose share it uses
    int sample;
    Eigen::Vector3d position; ///< m
};

/// Returns a flag for each point: 1 for at most \a maxPoints points that stay. The budget is given
/// out in order of priority. The first priority that does not fit as a whole is shared among its
/// sources in proportion to their points (largest remainders), and each source's share is spread
/// over it. Throws Stopped if \a stop requests it.
std::vector<char> shareBudget(const std::vector<BudgetPoint>& points,
                              int maxPoints,
                              const base::StopToken& stop = {});

/// Treatment of crowded points, which are closer together than a field can resolve.
enum class Crowding
{
    THIN,  ///< the later by priority is left out
    MERGE, ///< both are replaced by their mean, with the first object and the larger target
    DROP   ///< both are left out
};

/// Options for the selection of control points.
struct SelectorOptions
{
    /// >= 1; the budget. Objects of higher priority get their points first; those of equal priority
    /// share in proportion to their points.
    int maxPoints = 1000;
    Crowding crowding = Crowding::THIN;
    /// 0 .. 1; points of one object closer than this (or than its spacing, if less) are crowded.
    double crowdingWavelengths = 1.0 / 3.0;
    double minDistanceWavelengths = 1.0; ///< >= 0; minimum distance from the nearest transducer
    /// >= 0; maximum distance from the nearest transducer. 0: twice the extent of the array, at
    /// least 0.3 m.
    double reach_m = 0.0;
    base::StopToken stop; ///< on its request the selection throws Stopped

    /// Returns false if a setting is out of range; \a error then names the first one.
    bool isValid(std::string* error = nullptr) const;
};

/// Points of an object that were left out, by reason.
struct LeftOutPoints
{
    int notFinite = 0; ///< position, normal or target is NaN or infinite
    int noTarget = 0;  ///< target times intensity is not positive
    /// too close to a transducer or a reflector, behind the array or out of reach
    int outOfWorkspace = 0;
    int tooClose = 0;    ///< part of outOfWorkspace: too close to a transducer
    int behind = 0;      ///< part of outOfWorkspace: behind the array
    int atReflector = 0; ///< part of outOfWorkspace: nearer than a wavelength to a reflector
    int crowded = 0;     ///< too near another point, merged ones included
    int overBudget = 0;

    LeftOutPoints& operator+=(const LeftOutPoints& other);
    int total() const { return notFinite + noTarget + outOfWorkspace + crowded + overBudget; }
    /// Returns "20 behind the array, 10 over the budget"; "" if none was left out.
    std::string summary() const;
};

/// Numbers of selected and left out points, by reason; candidates is their sum.
struct SelectionReport
{
    int candidates = 0;
    int selected = 0;
    int notFinite = 0;   ///< position, normal or target is NaN or infinite
    int noTarget = 0;    ///< target times intensity is not positive
    int tooClose = 0;    ///< too close to a transducer
    int behind = 0;      ///< behind the array
    int atReflector = 0; ///< nearer than a wavelength to a reflector
    int outOfReach = 0;
    int spacedOut = 0; ///< too near a point of another object of higher precedence
    int crowdThinned = 0;
    int crowdMerged = 0; ///< merged into another point
    int crowdDropped = 0;
    int overBudget = 0;
    std::vector<int> perObject;         ///< selected points of each object, in the order given
    std::vector<LeftOutPoints> leftOut; ///< likewise

    /// Returns "120 of 150 points: 20 behind the array, 10 over the budget of 120"; "" if all were
    /// selected.
    std::string summary() const;
};

/// The selected points and their sources, so that a solver can start from the last field.
struct Selection
{
    ControlPoints points;    ///< in the order of the objects and their samples
    std::vector<int> source; ///< for each point: index of its object, in the order given
    std::vector<int> sample; ///< for each point: its column in PosedObject::positions
    SelectionReport report;
};

/// Selects control points among the samples of several objects. Leaves out points beyond the
/// array's reach, keeps the spacing between objects, resolves crowds and keeps the budget; counts
/// all points left out. Precedence is by priority, then by distance to the middle of the workspace
/// (nearer first), then by x, y and z, so the order of objects and points does not matter. Throws
/// InputError for members of unequal length and for spacings and options out of range.
Selection selectControlPoints(const std::vector<PosedObject>& objects,
                              const Workspace& workspace,
                              const SelectorOptions& options);

} // namespace midair::haptics
