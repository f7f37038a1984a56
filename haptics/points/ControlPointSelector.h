#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/points/Workspace.h"
#include "haptics/surface/SurfaceSampler.h"

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace midair::haptics
{

/// What happens to points that crowd: nearer to each other than a field can tell apart.
enum class Crowding
{
    THIN,  ///< the later one, by priority, is left out
    MERGE, ///< both become one at their mean, with the earlier one's object and the larger target
    DROP   ///< both are left out
};

/// What is worth solving for; isValid() names the first setting that is out of its range.
struct SelectorOptions
{
    /// >= 1; objects of higher priority get their points first, those of equal priority share in
    /// proportion to their counts.
    int maxPoints = 1000;
    Crowding crowding = Crowding::THIN;
    /// 0 .. 1; points of one object that are nearer to each other than this (or than its spacing,
    /// if that is less) are a crowd.
    double crowdingWavelengths = 1.0 / 3.0;
    double minDistanceWavelengths = 1.0; ///< >= 0; to the nearest transducer
    /// >= 0; the farthest that a point may be from its nearest transducer. 0: twice the extent of
    /// the array, at least 0.3 m.
    double reach_m = 0.0;
    base::StopToken stop; ///< where it asks for that, the selection throws Stopped

    bool isValid(std::string* error = nullptr) const;
};

/// One object's samples in the array frame; all members of the same length.
struct PosedObject
{
    int object = 0;      ///< goes into ControlPoints::object
    int priority = 0;    ///< larger wins
    double target = 1.0; ///< > 0; times the intensity
    /// > 0; how far points of other objects are kept (the larger of the two counts)
    double spacing_m = 8.5e-3;
    Eigen::Matrix3Xd positions; ///< 3 x n, metres, array frame
    Eigen::Matrix3Xd normals;   ///< 3 x n
    Eigen::VectorXf intensity;  ///< n or empty: 1

    /// Fills positions, normals and intensity from \a samples; allocates only if their number
    /// changed.
    void pose(const SurfaceSamples& samples, const Eigen::Isometry3d& meshToArray);
};

/// What became of the points: candidates is the sum of selected and of all that were left out.
struct SelectionReport
{
    int candidates = 0;
    int selected = 0;
    int notFinite = 0; ///< position, normal or target is NaN or infinite
    int noTarget = 0;  ///< target times intensity is not positive
    int tooClose = 0;  ///< to a transducer
    int behind = 0;    ///< the array
    int outOfReach = 0;
    int spacedOut = 0; ///< too near a point of another object that comes first
    int crowdThinned = 0;
    int crowdMerged = 0; ///< taken into another point
    int crowdDropped = 0;
    int overBudget = 0;
    std::vector<int> perObject; ///< selected, by index of the objects as given

    /// "120 of 150 points: 20 behind the array, 10 over the budget of 120"; "" where all were
    /// selected.
    std::string summary() const;
};

/// The points to solve for, and where each came from, so that a solver can start from the last
/// field.
struct Selection
{
    ControlPoints points;    ///< in the order of the objects and their samples
    std::vector<int> source; ///< index of the object as given, a point each
    std::vector<int> sample; ///< its column in PosedObject::positions, a point each
    SelectionReport report;
};

/// Selects the points that are solved for from those of several objects. What the array cannot
/// reach is left out, the spacing holds across objects, crowds are resolved and the budget is kept;
/// all that is left out is counted. Where points compete, priority decides, then the distance to
/// the middle of the workspace (the nearer stays), then x, y and z, so that the order of objects
/// and points does not matter. Throws InputError for members of unequal length and for spacings and
/// options out of range.
Selection selectControlPoints(const std::vector<PosedObject>& objects,
                              const Workspace& workspace,
                              const SelectorOptions& options);

} // namespace midair::haptics
