#pragma once

#include "engine-bridge/SharedMesh.h"
#include "haptics/surface/SurfaceSampler.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// How an object feels where it is touched; isValid() names the first number that is out of its
/// range. The defaults are those of a soft thing without a texture.
struct HapticMaterial
{
    double stiffness_N_m = 10.0; ///< 0 .. 1e4; applied force over depth
    double mostForce_N = 0.02;   ///< 0 .. 1; where the force stops growing
    /// m; 0: foci circle on the patch's own ellipse; 1e-3 .. 0.02: on a circle of this radius where
    /// the touch begins, which grows with the depth
    double radius_m = 0.0;
    double radiusGrowth = 0.0; ///< 0 .. 10; metres of radius a metre of depth; it ends at 10 mm
    /// 0 .. 1e4, Hz/m; turns a second that a metre of depth adds; they end at 10 Hz
    double rateGrowth_Hz_m = 0.0;
    double roughness = 0.0;        ///< 0 .. 1; share of the pressure that the texture takes away
    double texturePeriod_m = 1e-3; ///< 1e-5 .. 1; wavelength of the texture
    double lowVibration = 0.0;     ///< 0 .. 1; share that a vibration of low_Hz takes away
    double low_Hz = 30.0;          ///< 1 .. 500
    double highVibration = 0.0;    ///< 0 .. 1
    double high_Hz = 150.0;        ///< 1 .. 500

    bool isValid(std::string* error = nullptr) const;
};

bool operator==(const HapticMaterial& a, const HapticMaterial& b);

/// Which faces of an object are felt. FRONT: those whose normals point to where most of the array's
/// sound comes from; BACK: the others.
enum class Side
{
    BOTH,
    FRONT,
    BACK
};

/// How an object is rendered.
enum class Render
{
    INHERIT, ///< as the scene is
    OBJECT,  ///< its whole surface, whoever touches it: no hands need to be known
    CONTACT, ///< foci that circle on the skin where a hand touches it, nothing elsewhere
    AUTO     ///< CONTACT while hands are known well enough, else OBJECT
};

/// How an object should feel. Ranges are checked where the members are set.
struct HapticProperties
{
    /// > 0; peak Pa if pressureInPa, else relative to the scene's other objects
    double pressure = 1.0;
    bool pressureInPa = false;
    double spacing_m = 0.0; ///< >= 0; distance of the control points; 0: one wavelength
    haptics::Sampling sampling = haptics::Sampling::SURFACE;
    Side side = Side::BOTH;
    int priority = 0;                    ///< where points are too near or too many, the larger wins
    double modulationFrequency_Hz = 0.0; ///< >= 0; 0: a steady pressure
    /// 0 .. 1; the share of the pressure on the skin that the modulation takes away at its lowest
    double modulationDepth = 1.0;
    Render render = Render::INHERIT;
    HapticMaterial material; ///< where it is touched
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
    std::uint64_t id = 0;     ///< identifies this instance or part; stable from frame to frame
    std::uint64_t whole = 0;  ///< identifies the whole instance for touches; 0: the same as id
    std::string path;         ///< node path for messages
    std::uint64_t meshId = 0; ///< objects with equal ids have the same mesh
    /// meshes with equal ids have the same triangles, their vertices may differ; 0: unknown
    std::uint64_t topologyId = 0;
    SharedMesh mesh;                                        ///< metres, scale baked in
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array frame
    HapticProperties properties;
    /// planes (n, d) in the array frame; what of the object is at n x + d < 0 for any is neither
    /// seen nor felt
    std::vector<Eigen::Vector4d> clips;
    /// 0 .. 1; factor on the pressure of the object as a whole, while it gives way to contacts; 0:
    /// it has no control points
    double share = 1.0;
    /// if true, the distance of hands to this object is measured; the field doesn't depend on it
    bool touchEvents = false;
    /// what the caller wants to find again in the result (HologramResult::origins); not read
    std::shared_ptr<const void> origin;

    std::uint64_t touchId() const { return whole ? whole : id; }
};

/// True for a place in the array frame that one of \a clips cuts off.
bool isClipped(const std::vector<Eigen::Vector4d>& clips, const Eigen::Vector3d& place);

} // namespace midair::bridge
