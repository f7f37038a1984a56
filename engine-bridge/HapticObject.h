#pragma once

#include "haptics/surface/SurfaceSampler.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <string>

namespace midair::bridge
{

/// Which side of an object's faces is felt: that which is turned to where most of the array's sound
/// comes from, or the other.
enum class Side
{
    BOTH,
    FRONT,
    BACK
};

/// How an object is to be felt; ranges are checked where they are set.
struct HapticProperties
{
    double pressure = 1.0; ///< > 0; Pa if pressureInPa, else relative to the scene's other objects
    bool pressureInPa = false;
    double spacing_m = 0.0; ///< >= 0; 0: one wavelength
    haptics::Sampling sampling = haptics::Sampling::SURFACE;
    Side side = Side::BOTH;
    int priority = 0;                    ///< larger wins where points are too near or too many
    double modulationFrequency_Hz = 0.0; ///< >= 0; 0: a steady pressure
    /// 0 .. 1; by how much of itself the pressure on the skin goes down
    double modulationDepth = 1.0;
};

bool operator==(const HapticProperties& a, const HapticProperties& b);
inline bool operator!=(const HapticProperties& a, const HapticProperties& b)
{
    return !(a == b);
}

/// One instance (one node path) of a haptic object, or a part of it that moves by itself. The mesh
/// is shared and never changes; a new shape is a new mesh and a new meshId.
struct HapticObject
{
    std::uint64_t id = 0;     ///< of this instance, or of a part of it; stable from frame to frame
    std::uint64_t whole = 0;  ///< of the instance, for touches: its parts share it; 0: id
    std::string path;         ///< node path for messages
    std::uint64_t meshId = 0; ///< equal ids: the same mesh
    /// equal ids: the same triangles, vertices may have moved; 0: none like it
    std::uint64_t topologyId = 0;
    std::shared_ptr<const haptics::TriangleMesh> mesh;      ///< metres, scale baked in
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array frame
    HapticProperties properties;
    bool touchEvents = false; ///< hands are measured against it; changes nothing about the field

    std::uint64_t touchId() const { return whole ? whole : id; }
};

} // namespace midair::bridge
