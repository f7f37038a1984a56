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

/// Returns the slice \a grid of a field as a picture without text and outline. \a pressure_Pa is in
/// the order of grid.points(). \a points (array frame) are drawn on top. If \a achieved_Pa is
/// given, points are coloured by the ratio of achieved to wanted pressure; \a level_Pa is the
/// wanted pressure at the largest target (SolveReport::level_Pa).
osgMidair::FieldPicture fieldPicture(const haptics::FieldGrid& grid,
                                     const Eigen::VectorXf& pressure_Pa,
                                     const haptics::ControlPoints& points = {},
                                     const Eigen::VectorXd& achieved_Pa = {},
                                     double level_Pa = 0.0);

/// Returns the rectangle that shows \a points best: through their centre, perpendicular to their
/// direction of least spread (or in a plane of the array frame if they are not flat), with a margin
/// of \a margin_m on every side and samples \a step_m apart. Without points: the plane y = 0, 2
/// margin_m wide.
haptics::FieldGrid bestSlice(const haptics::ControlPoints& points, double margin_m, double step_m);

/// Returns the intersection of \a mesh (moved by \a pose into the array frame) with the plane of
/// \a grid as segments, two places each, without duplicates. Faces in the plane contribute their
/// edges except those shared by two such faces.
std::vector<osg::Vec3d> outlineInPlane(const haptics::TriangleMesh& mesh,
                                       const Eigen::Isometry3d& pose,
                                       const haptics::FieldGrid& grid);

/// Writes \a picture to \a path (.png), drawn off screen with OpenGL. Without OpenGL it writes the
/// slice and the points without text and sets \a message. Returns false and sets \a message if
/// nothing could be written.
bool writeFieldPicture(const std::string& path,
                       const osgMidair::FieldPicture& picture,
                       std::string& message);

} // namespace midair::samples
