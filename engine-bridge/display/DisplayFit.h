#pragma once

#include "engine-bridge/display/Display.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Positions of the twelve crosses on the screen: as shares of its width and height, from the lower
/// left corner.
const std::vector<Eigen::Vector2d>& displayCrosses();

/// A fingertip that touched a cross where it is seen, or covered it for one eye.
struct CrossTouch
{
    int cross = 0;                                          ///< index into displayCrosses()
    Eigen::Vector3d tip = Eigen::Vector3d::Zero();          ///< world, m
    Eigen::Isometry3d head = Eigen::Isometry3d::Identity(); ///< then, for sights; see Head::pose
};

/// Reads lines of four columns: cross (1 .. 12), x, y, z of the fingertip; for sights (\a
/// areSights) eleven: also the head's x, y, z and the quaternion qx, qy, qz, qw of its orientation.
/// Separators, comments and headings: see readPointPairs(). \a name appears in messages. Throws
/// base::InputError.
std::vector<CrossTouch> readTouches(std::istream& in, const std::string& name, bool areSights);
/// Returns such a line, with its end.
std::string touchLine(const CrossTouch& touch, bool isSight);

/// Options of the fits below.
struct DisplayFitOptions
{
    double edge_m = 0.1;        ///< > 0; of the workspace, from the picture's middle
    double mostError_m = 0.005; ///< > 0; a larger likely error at that edge makes a fit unusable
    int eye = 1; ///< for sights: -1 the left eye, 1 the right one, 0 the middle between them
    bool fitsEye = false; ///< for sights: also fits the eye's offset from the head
    std::uint64_t seed = 1;
};

/// Fitted screen of a display, with its accuracy.
struct DisplayFit
{
    bool usable = false;            ///< false: display must not be used
    Display display;                ///< the given display with the fitted screen
    std::string method;             ///< "touched crosses"
    std::vector<std::string> names; ///< of the measurements: "cross 3"
    Eigen::VectorXd residuals;      ///< of each; metres, for tags pixels
    bool areInPixels = false;       ///< residuals and noise
    std::vector<bool> outlier;      ///< of each: excluded
    double noise = 0.0;             ///< standard deviation per coordinate
    double edge_m = 0.0;            ///< from the options
    double errorMedian_m = 0.0;     ///< likely error at the worst place at edge_m from the middle
    double error95_m = 0.0;         ///< its 95 % quantile
    Eigen::Vector3d eyeOffset =
        Eigen::Vector3d::Zero();       ///< in the head's frame, m, if it was fitted
    std::vector<std::string> problems; ///< why it isn't usable
    std::vector<std::string> notes;    ///< other remarks

    Eigen::Vector3d middle() const; ///< of the picture, world, m
    std::string text() const;       ///< a few lines for the user, like CalibrationReport::text()
};

/// Finds the screen of \a display from \a touches of its crosses in the picture, where the optics
/// show it: a rigid fit in the picture's plane, whose corners are then reflected back. The screen's
/// size and the optics' planes are those of \a display; its screen pose is an initial guess that
/// reveals exchanged crosses. Outliers are excluded.
DisplayFit fitTouches(const Display& display,
                      const std::vector<CrossTouch>& touches,
                      const DisplayFitOptions& options = {});

/// Does the same from fingertips that cover a cross for one eye, for pictures out of reach. Needs
/// three places of the head, 0.1 m apart, to determine the picture's distance.
DisplayFit fitSights(const Display& display,
                     const std::vector<CrossTouch>& sights,
                     const DisplayFitOptions& options = {});

/// \{ Shared by the fits. The frame of a picture: x to the right along its width, y up, the origin
/// in its middle.
Eigen::Vector3d inPicture(const Display& display, const Eigen::Vector2d& share);
Eigen::Isometry3d pictureOf(const Display& display);
/// Returns \a display with its screen placed so that optics show the picture at \a picture.
Display withPicture(const Display& display, const Eigen::Isometry3d& picture);
/// Completes \a fit for a picture found at \a picture: its display, errors from the covariance \a
/// pose of rotation (in the picture's frame) and shift (6 x 6, for a noise of 1), and the resulting
/// problems. \a freedom: degrees of freedom of the noise.
void concludeFit(DisplayFit& fit,
                 const Eigen::Isometry3d& picture,
                 const Eigen::MatrixXd& pose,
                 int freedom,
                 const DisplayFitOptions& options);
/// \}

} // namespace midair::bridge
