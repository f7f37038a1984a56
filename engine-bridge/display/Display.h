#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::bridge
{

/// A plane between the screen and the eye, which shows the screen's picture elsewhere.
struct Optic
{
    enum class Kind
    {
        HALF_MIRROR, ///< reflects: the picture is a virtual image behind it
        /// a plate of micro mirrors or a retro-reflective set-up: light passes, and the picture is
        /// a real image before it, at the place that is symmetric to the screen
        PLATE
    };

    Kind kind = Kind::HALF_MIRROR;
    Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< on the plane, world, m
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ(); ///< unit; its sign says nothing
    std::vector<Eigen::Vector3d> outline;              ///< convex, in the plane; none: no edge
};

/// How two eyes see two pictures on one screen: what OSG's DisplaySettings has.
enum class StereoMode
{
    NONE, ///< one picture, for the place between the eyes
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

/// Names of stereo modes in files, in the order of StereoMode.
const std::vector<std::string>& stereoNames();

/// A screen in the world, the optics that it is seen by, and whose eyes see it. Places are metres
/// in the world of the scene. The corners are named as somebody sees them who stands before the
/// lit screen, whatever optics come after it.
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
    StereoMode stereo = StereoMode::NONE;
};

/// Throws base::InputError, whose text begins with \a source, if \a display is none: corners that
/// are no rectangle within 1 % (and which are swapped, if that is why), numbers that aren't finite,
/// outlines that aren't in their plane or not convex. Normals are made unit vectors.
void checkDisplay(Display& display, const std::string& source);

/// Reads a display from JSON (samples/guides/DISPLAYS.md), and checks it. \a source is its name in
/// messages. Throws base::InputError.
Display readDisplay(const std::string& text, const std::string& source);
/// Reads the file \a path. Throws base::InputError.
Display loadDisplay(const std::string& path);

} // namespace midair::bridge
