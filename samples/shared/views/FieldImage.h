#pragma once

#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <string>

namespace midair::samples
{

/// A slice of a field as a figure, with axes in mm, colour bar in Pa, outline and control points.
struct FieldImage
{
    haptics::FieldGrid grid;       ///< u and v must be perpendicular
    Eigen::VectorXcf pressure_Pa;  ///< columns * rows, peak, in the order of grid.points()
    haptics::ControlPoints points; ///< array frame; may be empty
    /// points.size() or empty; if given, points are coloured by achieved over wanted pressure
    Eigen::VectorXf achieved_Pa;
    /// wanted pressure where the target is largest (SolveReport::level_Pa); used with achieved_Pa
    double level_Pa = 0.0;
    /// 3 x 2 s, metres: s segments of the object's outline in the plane; may be empty
    Eigen::Matrix3Xd outline;
    std::string title;
    std::string caption; ///< one line below the picture; may be empty
};

/// Returns the rectangle that shows \a points best: through their centre, perpendicular to the
/// direction in which they spread least (or in a plane of the array frame if they are not flat), \a
/// margin_m wider than the points on every side, with samples \a step_m apart. Without points: the
/// plane y = 0, 2 margin_m wide.
haptics::FieldGrid bestSlice(const haptics::ControlPoints& points, double margin_m, double step_m);

/// Returns the intersection of \a mesh (moved by \a pose into the array frame) with the plane of \a
/// grid; of faces in that plane, their boundary and creases. 3 x 2 s, a pair of columns per
/// segment.
Eigen::Matrix3Xd outlineInPlane(const haptics::TriangleMesh& mesh,
                                const Eigen::Isometry3d& pose,
                                const haptics::FieldGrid& grid);

/// Writes \a image to \a path (.png), drawn off screen with OpenGL. Without OpenGL it writes the
/// slice and the points without text, and \a message says so. Returns false if nothing could be
/// written; \a message then says why.
bool writeFieldImage(const std::string& path,
                     const FieldImage& image,
                     std::string* message = nullptr);

} // namespace midair::samples
