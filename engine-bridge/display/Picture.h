#pragma once

#include "engine-bridge/display/Display.h"

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace midair::bridge
{

/// The picture of a display's screen where it is seen: the screen, reflected at the plane of each
/// optic in the order of the light. The virtual image of a half mirror and the real image of a
/// plate are at the same place. A point of it is corner + u right + v up with u and v of the
/// screen, 0 .. 1 from its lower left corner.
///
/// As seen from the eye: an odd number of half mirrors exchanges left and right. A plate exchanges
/// nothing, because its picture is seen from the other side.
class Picture
{
public:
    explicit Picture(const Display& display);

    Eigen::Vector3d at(double u, double v) const { return _corner + u * _right + v * _up; }
    /// Intersects the ray from \a eye through \a place with the picture's plane; returns u and v.
    /// Returns false if there is no intersection.
    bool meets(const Eigen::Vector3d& eye, const Eigen::Vector3d& place, Eigen::Vector2d& uv) const;

    /// Returns why \a eye doesn't see the picture's middle; empty: it does. Ignores the outlines of
    /// the optics.
    std::string whyUnseen(const Eigen::Vector3d& eye) const;
    /// Returns true if light of the screen reaches \a eye from the direction of \a place: within
    /// the screen, and through the outlines of all optics.
    bool shows(const Eigen::Vector3d& eye, const Eigen::Vector3d& place) const;
    /// Returns the share (0 .. 1) of the box from \a low to \a high (m) that the picture can show
    /// to \a eye.
    double share(const Eigen::Vector3d& eye,
                 const Eigen::Vector3d& low,
                 const Eigen::Vector3d& high) const;
    /// Returns the part of the picture that \a eye sees through the outlines: a convex polygon in
    /// the picture's plane; empty: none.
    std::vector<Eigen::Vector3d> visiblePart(const Eigen::Vector3d& eye) const;

    const Eigen::Vector3d& right() const { return _right; } ///< m, the screen's whole width
    const Eigen::Vector3d& up() const { return _up; }       ///< m, the screen's whole height
    const Eigen::Vector3d& front() const { return _front; } ///< unit; direction of its light
    bool isFlipped() const { return _isFlipped; }

private:
    /// An optic as the eye sees it through those after it.
    struct Seen
    {
        Optic optic;
        Eigen::Vector3d middle; ///< of the outline
    };

    std::string whyNoLight(const Eigen::Vector3d& eye, const Eigen::Vector3d& place) const;
    std::string swapped() const;

    Eigen::Vector3d _corner;
    Eigen::Vector3d _right;
    Eigen::Vector3d _up;
    Eigen::Vector3d _front;
    bool _isFlipped = false;
    double _pixelAspect;     ///< width over height
    std::vector<Seen> _seen; ///< in the order along the line of sight: the last one first
};

/// How one eye sees a picture.
struct EyeView
{
    Eigen::Isometry3d view;     ///< world to eye: x to the picture's right, y up, z to the eye
    Eigen::Matrix4d projection; ///< OpenGL's; includes the flip of a picture that isFlipped()
};

/// Returns the generalised perspective projection (Kooima 2009) of \a picture for \a eye, in
/// metres; the eye has to be in front of it (Picture::whyUnseen()).
EyeView eyeView(const Picture& picture, const Eigen::Vector3d& eye, double near_m, double far_m);

/// Returns the position of an eye of a head with \a pose, whose origin is between the eyes and
/// whose x points right. \a side: -1 the left eye, 1 the right one, 0 the middle.
inline Eigen::Vector3d eyeOf(const Eigen::Isometry3d& pose, double ipd_m, int side)
{
    return pose * Eigen::Vector3d(0.5 * ipd_m * side, 0.0, 0.0);
}

} // namespace midair::bridge
