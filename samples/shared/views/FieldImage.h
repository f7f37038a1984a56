#pragma once

#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/surface/TriangleMesh.h"

#include <osgMidair/FieldPicture>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace midair::samples
{

/// Returns the slice \a grid of a field as a picture without words and outline. \a pressure_Pa: in
/// the order of grid.points(). \a points: array frame, drawn over it. \a achieved_Pa: at them, or
/// empty; if given, points are coloured by achieved over wanted pressure, which is \a level_Pa
/// where the target is largest (SolveReport::level_Pa).
osgMidair::FieldPicture fieldPicture(const haptics::FieldGrid& grid,
                                     const Eigen::VectorXf& pressure_Pa,
                                     const haptics::ControlPoints& points = {},
                                     const Eigen::VectorXd& achieved_Pa = {},
                                     double level_Pa = 0.0);

/// Returns the rectangle that shows \a points best: through their centre, perpendicular to the
/// direction in which they spread least (or in a plane of the array frame if they are not flat), \a
/// margin_m wider than the points on every side, with samples \a step_m apart. Without points: the
/// plane y = 0, 2 margin_m wide.
haptics::FieldGrid bestSlice(const haptics::ControlPoints& points, double margin_m, double step_m);

/// Returns the intersection of \a mesh (moved by \a pose into the array frame) with the plane of \a
/// grid, each segment once; of faces in that plane, all edges but those between two of them. A pair
/// of places per segment.
std::vector<osg::Vec3d> outlineInPlane(const haptics::TriangleMesh& mesh,
                                       const Eigen::Isometry3d& pose,
                                       const haptics::FieldGrid& grid);

/// Writes \a picture to \a path (.png), drawn off screen with OpenGL. Without OpenGL it writes the
/// slice and the points without text, and \a message says so. Returns false if nothing could be
/// written; \a message then says why.
bool writeFieldPicture(const std::string& path,
                       const osgMidair::FieldPicture& picture,
                       std::string& message);

} // namespace midair::samples
