#pragma once

#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <string>

namespace midair::samples
{

/// One slice of a field with what belongs to it, as a figure: axes in mm, colour bar in Pa, outline
/// and control points.
struct FieldImage
{
    haptics::FieldGrid grid;       ///< u and v perpendicular to each other
    Eigen::VectorXcf pressure_Pa;  ///< columns * rows, peak, in the order of grid.points()
    haptics::ControlPoints points; ///< array frame; may be empty
    Eigen::VectorXf
        achieved_Pa; ///< points.size() or empty: points are then coloured by achieved over wanted
    double level_Pa =
        0.0; ///< wanted where the target is largest (SolveReport::level_Pa); with achieved_Pa
    Eigen::Matrix3Xd
        outline; ///< 3 x 2 s, metres: segments of the object's outline in the plane; may be empty
    std::string title;
    std::string caption; ///< one line below the picture; may be empty
};

/// The rectangle that shows \a points best: through their centroid, across the direction in which
/// they spread least (the wider view of the array frame's planes where two are alike), \a margin_m
/// wider than the points on every side and samples \a step_m apart. With no points: the plane y =
/// 0, 2 margin_m wide.
haptics::FieldGrid bestSlice(const haptics::ControlPoints& points, double margin_m, double step_m);

/// Where \a mesh (moved by \a pose into the array frame) meets the plane of \a grid; where it lies
/// in that plane, its boundary and creases. 3 x 2 s, a pair of columns a segment.
Eigen::Matrix3Xd outlineInPlane(const haptics::TriangleMesh& mesh,
                                const Eigen::Isometry3d& pose,
                                const haptics::FieldGrid& grid);

/// Writes \a image to \a path (.png), drawn off screen through OpenGL. Where there is no OpenGL the
/// slice and the points are written without text, and \a message says so. False when nothing could
/// be written; \a message then says why.
bool writeFieldImage(const std::string& path,
                     const FieldImage& image,
                     std::string* message = nullptr);

} // namespace midair::samples
