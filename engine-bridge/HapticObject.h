#pragma once

#include "engine-bridge/SharedMesh.h"
#include "haptics/sensation/Sensation.h"
#include "haptics/surface/SurfaceSampler.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// How an object feels when touched; isValid() names the first number that is out of range. The
/// defaults describe a soft object without a texture.
struct HapticMaterial
{
    double stiffness_N_m = 10.0; ///< 0 .. 1e4; applied force over depth
    double mostForce_N = 0.02;   ///< 0 .. 1; where the force stops growing
    /// m; 0: foci circle on the patch's own ellipse; 1e-3 .. 0.02: on a circle that has this radius
    /// when the touch begins, and grows with the depth
    double radius_m = 0.0;
    double radiusGrowth = 0.0; ///< 0 .. 10; metres of radius per metre of depth, up to 10 mm
    /// 0 .. 1e4, Hz/m; turns per second added per metre of depth, up to 10 Hz
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
    INHERIT, ///< the scene's setting
    OBJECT,  ///< its whole surface, touched or not: needs no tracked hands
    CONTACT, ///< foci that circle on the skin where a hand touches it, nothing elsewhere
    AUTO     ///< CONTACT while hands are tracked accurately enough, else OBJECT
};

/// A sensation that is played instead of an object's surface.
struct SensationProperties
{
    /// The frame of its samples.
    enum class Attach
    {
        PLACE,   ///< the object's own
        SURFACE, ///< on the surface, where it is touched or under the object's origin
        HAND     ///< of a joint of a hand, z out of the palm
    };
    /// When it begins and ends.
    enum class Trigger
    {
        ALWAYS,      ///< at once; one that has stopped begins anew
        PROGRAM,     ///< when plays changes
        TOUCH_BEGIN, ///< when a hand begins to touch the object
        TOUCH_STAY,  ///< while a hand touches the object
        TOUCH_END    ///< when a hand ends to touch the object
    };

    bool isMeant = false;                              ///< false: the object has no sensation
    std::shared_ptr<const haptics::Sensation> pattern; ///< null though meant: it is silent
    Attach attach = Attach::PLACE;
    int joint = 0; ///< HandJointName, for HAND
    Trigger trigger = Trigger::ALWAYS;
    double speed = 1.0;                                     ///< 0 .. 10; factor
    int seed = 1;                                           ///< of random intensities
    std::vector<std::pair<std::string, double>> parameters; ///< set by the program
    int plays = 0; ///< another number above 0 begins it anew, 0 ends it

    /// Returns true if it doesn't play without hands.
    bool needsHands() const;
    /// Returns true if hands change how it plays: needsHands(), a surface that it leaves for
    /// touches, or a pattern that knows one of kHandParameters.
    bool usesHands() const;

    /// parameters that the kit sets from hands, where a pattern has them
    static constexpr const char* kHandParameters[] = {"proximity", "depth", "speed"};
};

bool operator==(const SensationProperties& a, const SensationProperties& b);

/// How an object should feel. Ranges are checked where the members are set.
struct HapticProperties
{
    /// > 0; peak Pa if pressureInPa, otherwise relative to the scene's other objects
    double pressure = 1.0;
    bool pressureInPa = false;
    double spacing_m = 0.0; ///< >= 0; distance of the control points; 0: one wavelength
    haptics::Sampling sampling = haptics::Sampling::SURFACE;
    Side side = Side::BOTH;
    int priority = 0; ///< where points are too near or too many, the larger number wins
    double modulationFrequency_Hz = 0.0; ///< >= 0; 0: a steady pressure
    /// 0 .. 1; largest share of the pressure on the skin that the modulation removes
    double modulationDepth = 1.0;
    Render render = Render::INHERIT;
    HapticMaterial material; ///< used when touched
    SensationProperties sensation;
};

bool operator==(const HapticProperties& a, const HapticProperties& b);
inline bool operator!=(const HapticProperties& a, const HapticProperties& b)
{
    return !(a == b);
}

/// Returns true if hands change how an object of \a properties is played, in a scene whose Render
/// is \a ofScene.
bool followsHands(const HapticProperties& properties, Render ofScene);

/// One instance (one node path) of a haptic object, or a part of it that moves separately. The mesh
/// is shared and immutable; a new shape is a new mesh with a new meshId.
struct HapticObject
{
    std::uint64_t id = 0;     ///< identifies this instance or part; constant from frame to frame
    std::uint64_t whole = 0;  ///< identifies the whole instance for touches; 0: the same as id
    std::string path;         ///< node path for messages
    std::uint64_t meshId = 0; ///< objects with equal ids have the same mesh
    /// meshes with equal ids have the same triangles, but maybe other vertices; 0: unknown
    std::uint64_t topologyId = 0;
    SharedMesh mesh;                                        ///< metres, scale baked in
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array frame
    HapticProperties properties;
    /// planes (n, d) in the array frame; parts of the object with n x + d < 0 for any plane are
    /// neither seen nor felt
    std::vector<Eigen::Vector4d> clips;
    /// 0 .. 1; factor on the pressure of the object as a whole while contacts replace it; 0: no
    /// control points
    double share = 1.0;
    /// measure the distance of hands to this object; doesn't affect the field
    bool touchEvents = false;
    /// tag of the caller, returned in HologramResult::origins; not read
    std::shared_ptr<const void> origin;

    std::uint64_t touchId() const { return whole ? whole : id; }
};

/// True if one of \a clips cuts off the place (array frame).
bool isClipped(const std::vector<Eigen::Vector4d>& clips, const Eigen::Vector3d& place);

} // namespace midair::bridge
