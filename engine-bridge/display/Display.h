#pragma once

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace midair::bridge
{

/// A plane between the screen and the eye that shows the screen's picture elsewhere.
struct Optic
{
    enum class Kind
    {
        HALF_MIRROR, ///< reflects: the picture is a virtual image behind it
        /// a plate of micro mirrors or a retro-reflective set-up: light passes through, and the
        /// picture is a real image in front of it, at the place symmetric to the screen
        PLATE
    };

    Kind kind = Kind::HALF_MIRROR;
    Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< on the plane, world, m
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ(); ///< unit; its sign doesn't matter
    std::vector<Eigen::Vector3d> outline;              ///< convex, in the plane; none: unlimited
};

/// How two eyes see two pictures on one screen, as in OSG's DisplaySettings.
enum class StereoMode
{
    NONE, ///< one picture, for the middle between the eyes
    QUAD_BUFFER,
    ANAGLYPH,
    SIDE_BY_SIDE,
    TOP_BOTTOM, ///< the left eye's picture is the upper one
    LEFT_EYE,
    RIGHT_EYE,
    HORIZONTAL_INTERLACE,
    VERTICAL_INTERLACE,
    CHECKERBOARD
};

/// Names of the stereo modes in files, in the order of StereoMode.
const std::vector<std::string>& stereoNames();

/// A screen in the world, its optics, and its viewer's eyes. Places are metres in the scene's
/// world. The corners are named as seen by a viewer in front of the lit screen, regardless of the
/// optics.
struct Display
{
    Eigen::Vector3d lowerLeft = Eigen::Vector3d::Zero();
    Eigen::Vector3d lowerRight = Eigen::Vector3d::Zero();
    Eigen::Vector3d upperLeft = Eigen::Vector3d::Zero();
    int width = 1920; ///< pixels of the whole screen
    int height = 1080;
    std::vector<Optic> optics; ///< in the order in which the screen's light meets them
    std::string eye;           ///< a head source: "fixed X Y Z", "osc:" ..
    double ipd_m = 0.063;      ///< 0 .. 0.1; between the pupils
    bool isIpdGiven = false;   ///< the distance was measured
    StereoMode stereo = StereoMode::NONE;
    /// Expected errors of the picture's position and of its rotation around its middle (half of all
    /// are smaller). None: unknown; a missing rotation error is included in the position's.
    std::optional<double> accuracy_m;
    std::optional<double> accuracy_rad;
};

/// Throws base::InputError, whose text begins with \a source, for an invalid \a display: corners
/// that are no rectangle within 1 % (naming swapped ones, if that is the reason), numbers that
/// aren't finite, outlines that aren't in their plane or not convex. Normalizes the normals.
void checkDisplay(Display& display, const std::string& source);

/// Reads a display from JSON (samples/guides/DISPLAYS.md), and checks it. \a source is its name in
/// messages. Throws base::InputError.
Display readDisplay(const std::string& text, const std::string& source);
/// Reads the file \a path. Throws base::InputError.
Display loadDisplay(const std::string& path);

/// Returns the display file \a text with the screen corners of \a display, to a micrometre,
/// otherwise unchanged. \a source: see readDisplay(). Throws base::InputError.
std::string withScreen(const std::string& text, const std::string& source, const Display& display);

} // namespace midair::bridge
