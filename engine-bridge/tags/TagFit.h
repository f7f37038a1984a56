#pragma once

#include "engine-bridge/display/DisplayFit.h"
#include "engine-bridge/tags/TagRig.h"

#include <Eigen/Core>

#include <array>
#include <vector>

namespace midair::bridge
{

/// A tag shown by a screen, near one of displayCrosses().
struct ShownTag
{
    int id = 0;
    /// Corners in the order of TagSeen, as shares of the screen's width and height from its lower
    /// left.
    std::array<Eigen::Vector2d, 4> corners;
};

/// Returns the tags that \a display shows to locate its picture: the highest twelve numbers of the
/// family, which printed tags must not use. If the optics mirror the picture, they are mirrored on
/// the screen, so that a camera sees them correctly.
std::vector<ShownTag> shownTags(const Display& display);

/// Tags of a rig and of a screen, seen by a camera.
struct TagPhoto
{
    std::vector<TagSeen> seen;
    int mirrored = 0; ///< number of screen tags seen in the mirrored image
};

/// Returns the tags that \a detector finds in \a image.
TagPhoto takePhoto(TagDetector& detector, const GrayImage& image, const Display& display);

/// Finds the screen of \a display from \a photos by the camera of \a rig, which is where eyes will
/// be and sees the tags on the screen, through its optics, and printed ones on the array. Fits all
/// poses of the camera and that of the picture together, by least squares in pixels. Photos with
/// fewer than four tags, or without one of each kind, are left out; three must remain.
DisplayFit fitTags(const Display& display,
                   const TagRig& rig,
                   const std::vector<TagPhoto>& photos,
                   const DisplayFitOptions& options = {});

} // namespace midair::bridge
