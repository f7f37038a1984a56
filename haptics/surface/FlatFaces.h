#pragma once

#include "haptics/array/Reflector.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

#include <memory>
#include <string>
#include <vector>

namespace midair::haptics
{

/// Most triangles of a mesh that becomes a ReflectingBody.
constexpr Eigen::Index kMostOfBody = 10000;

/// A closed rigid body of any form, which fields at rest are solved for.
struct ReflectingBody
{
    std::shared_ptr<const TriangleMesh> mesh;               ///< metres
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array
    bool operator==(const ReflectingBody& other) const
    {
        return mesh == other.mesh && pose.matrix() == other.pose.matrix();
    }
};

/// A rectangle of a mesh that sound reflects from.
struct FlatFace
{
    Reflector rectangle; ///< place, normal, along and size; the rest has its defaults
    /// Of a closed mesh: the normal points out of it, and sound reaches it from there alone.
    bool isOfBody = false;
    /// True: its body is among those that fields at rest are solved for.
    bool isSolvedAtRest = false;

    /// Returns the face where \a pose takes it.
    FlatFace movedBy(const Eigen::Isometry3d& pose) const;
    bool operator==(const FlatFace& other) const
    {
        return rectangle == other.rectangle && isOfBody == other.isOfBody &&
               isSolvedAtRest == other.isSolvedAtRest;
    }
};

/// The flat faces of a mesh.
struct FlatFaces
{
    std::vector<FlatFace> faces; ///< at most kMostReflectors
    std::string problem;         ///< why there are none; empty: there are, or the mesh is empty
    /// The mesh without seams, if it is closed and has at most kMostOfBody triangles; else null.
    std::shared_ptr<const TriangleMesh> body;
};

/// Finds the rectangles that \a mesh consists of, however finely they are divided into triangles. A
/// mesh that has another face, one that is curved (faces that meet at less than 40 degrees), bent
/// by more than 0.1 degrees or 0.1 mm, or no rectangle to 1 % of its area, gives none of its faces:
/// the rectangle around such a face would reflect where nothing is. So does one with more than
/// kMostReflectors faces. Faces narrower than 10 mm, about a wavelength, are left out: sound passes
/// the edge of a plate unreflected.
FlatFaces flatFacesOf(const TriangleMesh& mesh);

} // namespace midair::haptics
