#pragma once

#include "engine-bridge/tags/TagDetector.h"

#include <Eigen/Geometry>

#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Model of a camera: a pinhole with radial distortion, as camera calibrations give it. In the
/// camera's frame x is to the right, y down, z forward, m.
struct CameraModel
{
    int width = 0;
    int height = 0;
    double fx = 0.0, fy = 0.0; ///< focal lengths, pixels
    double cx = 0.0, cy = 0.0; ///< principal point, pixels
    double k1 = 0.0, k2 = 0.0; ///< factor 1 + k1 r^2 + k2 r^4 at r = tan of the angle off the axis

    Eigen::Vector2d project(const Eigen::Vector3d& place) const;
    /// Returns (x/z, y/z) of the ray through \a pixel.
    Eigen::Vector2d ray(const Eigen::Vector2d& pixel) const;
};

/// A printed tag, in the scene's world.
struct PlacedTag
{
    int id = 0;
    double size_m = 0.0; ///< edge of the black square
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::UnitX(); ///< unit; of the tag as printed
    Eigen::Vector3d up = Eigen::Vector3d::UnitY();    ///< unit, across right

    /// Corner \a k of TagSeen::corners.
    Eigen::Vector3d corner(int k) const;
};

/// A camera, the tags that it may see, and the source of its images.
struct TagRig
{
    CameraModel camera;
    std::string device;              ///< "/dev/video0"; empty: images
    std::vector<std::string> images; ///< PGM files, used in turn
    std::vector<PlacedTag> tags;
    /// m; midpoint between the eyes, in the frame of a head that looks like the camera (x right, y
    /// up, z back)
    Eigen::Vector3d eyes = Eigen::Vector3d::Zero();

    const PlacedTag* find(int id) const;
};

/// Reads a rig from JSON (samples/guides/DISPLAYS.md). \a source: its name in messages; image names
/// are relative to its folder. Throws base::InputError.
TagRig readTagRig(const std::string& text, const std::string& source);
TagRig loadTagRig(const std::string& path);

/// A place of the world, or of a plane, and its pixel.
struct SeenPlace
{
    Eigen::Vector3d place;
    Eigen::Vector2d pixel;
};

/// Returns the pose (to the camera's frame) of the plane z = 0 with the seen \a places, at least
/// four and not on a line; none: there is no such pose. Uses a homography, as a start for fits.
std::optional<Eigen::Isometry3d> planePose(const CameraModel& camera,
                                           const std::vector<SeenPlace>& places);

/// Returns the pose from the world to the camera that fits the rig's tags in \a seen by least
/// squares over their corners; none: no tag of the rig is seen, or the error exceeds \a most_px
/// (rms), so that one isn't where the rig says.
std::optional<Eigen::Isometry3d>
cameraPose(const TagRig& rig, const std::vector<TagSeen>& seen, double most_px = 3.0);

/// Returns the pose of the head that carries the camera, see Head::pose; from \a worldToCamera.
Eigen::Isometry3d headOf(const TagRig& rig, const Eigen::Isometry3d& worldToCamera);

} // namespace midair::bridge
