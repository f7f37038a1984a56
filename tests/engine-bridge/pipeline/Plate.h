#pragma once

#include "haptics/surface/FlatFaces.h"

#include <Eigen/Core>

/// A plate between the boards of the octagon, across its axis at \a y_m: below the points.
inline midair::haptics::FlatFace plateAt(double y_m, double accuracy_mm = 0.2)
{
    midair::haptics::FlatFace face;
    face.rectangle.name = "plate";
    face.rectangle.position = {0.0, y_m, 0.0};
    face.rectangle.normal = Eigen::Vector3d::UnitY();
    face.rectangle.along = Eigen::Vector3d::UnitX();
    face.rectangle.size_m = {0.2, 0.15};
    face.rectangle.accuracy_mm = accuracy_mm;
    return face;
}
