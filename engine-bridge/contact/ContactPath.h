#pragma once

#include "engine-bridge/contact/ContactPatch.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::bridge
{

/// Options for circling foci; isValid() names the first setting that is out of its range.
///
/// Foci that turn slowly in small steps feel like steady pressure (Morisaki, Fujiwara, Makino,
/// Shinoda, IEEE Transactions on Haptics 15(2), 2022); shrinking the path and distributing the foci
/// follow github.com/shinolab/midair-haptics-unity, FbiElipseMultiSTM.cs.
struct ContactPathOptions
{
    double rate_Hz = 5.0;        ///< 0 .. 100; turns per second
    double mostRate_Hz = 10.0;   ///< 0 .. 100; limit of the rate with softness
    double mostRadius_m = 0.01;  ///< 1e-3 .. 0.1; limit of a radius from softness
    double focusSize_m = 2.5e-3; ///< 0 .. 0.02; taken off the ellipse for the focus's own size
    double leastRadius_m = 1e-3; ///< 1e-4 .. 0.02; least semi-axis of the path
    double focusEach_m = 8.5e-3; ///< 1e-3 .. 1; circumference of the path per focus
    int mostFoci = 10;           ///< 1 .. 10
    double largestStep_m = 5e-4; ///< 5e-5 .. 5e-3; of each focus from one field to the next
    double settle_s = 0.25;      ///< 0 .. 10; the number of foci follows the size this slowly
    double fade_s = 0.02;        ///< 0 .. 1; foci that come or go fade over this time

    bool isValid(std::string* error = nullptr) const;
};

/// One focus at one moment.
struct PathFocus
{
    Eigen::Vector3d position = Eigen::Vector3d::Zero(); ///< m, array frame; on the skin
    double weight = 1.0; ///< 0 .. 1; below 1 while it comes or goes; factor on the pressure
};

/// The foci of one contact: they circle together on the patch's ellipse, projected on the skin.
///
/// The angle continues whatever the patch does: the plane's axes are transported without a twist,
/// and the ellipse is a symmetric matrix in them, (2 C^1/2 - focusSize) with the patch's covariance
/// C, which changes smoothly where its axes swap. No focus moves by more than the largest step: if
/// a circle is too long for the time between two fields it turns more slowly (turningRate_Hz()),
/// and if the hand is too fast the foci lag (lag_m()). For moves of more than 5 mm, as at a step of
/// the skin, a focus fades out and in again.
class ContactPath
{
public:
    /// Throws InputError for options that are not valid. \a patch has an own capsule and finite
    /// numbers, like those of ContactFinder. \a angle_rad: angle of the first focus.
    ContactPath(const ContactPathOptions& options, const ContactPatch& patch, double angle_rad = 0);

    /// Circles on a circle of \a radius_m (0: the patch's ellipse; otherwise clamped to the
    /// options' range) with \a more_Hz (>= 0) turns per second in addition to the options' rate.
    /// Numbers that aren't finite count as 0.
    void soften(double radius_m, double more_Hz);

    /// Sets the newest patch; the foci move to it in the next fields.
    void fit(const ContactPatch& patch);
    /// Advances by \a dt_s (finite, >= 0), the time between two fields. Returns false and changes
    /// nothing for other numbers.
    bool advance(double dt_s);

    const std::vector<PathFocus>& foci() const { return _foci; }
    double angle_rad() const { return _angle_rad; }    ///< 0 .. 2 pi
    double turningRate_Hz() const { return _rate_Hz; } ///< in the last advance()
    /// m; largest remaining distance of a focus to its place
    double lag_m() const { return _lag_m; }
    double semiMajor_m() const { return _ellipse.semiMajor_m; } ///< of the path
    double semiMinor_m() const { return _ellipse.semiMinor_m; }
    const ContactPatch& patch() const { return _patch; }

private:
    /// State of a focus besides its position.
    struct Turning
    {
        double offset_rad = 0.0; ///< behind the first
        bool isLeaving = false;
        bool isPlaced = false;                            ///< its position is on the path
        Eigen::Vector3d wanted = Eigen::Vector3d::Zero(); ///< its last target position
        bool isJumping = false;                           ///< fades out, to appear at its target
    };

    /// The path, in a plane whose axes are transported across the normal.
    struct Ellipse
    {
        Eigen::Vector3d u = Eigen::Vector3d::Zero();
        Eigen::Vector3d v = Eigen::Vector3d::Zero();
        Eigen::Matrix2d fromCircle = Eigen::Matrix2d::Zero(); ///< unit circle -> path, in u and v
        double semiMajor_m = 0.0;
        double semiMinor_m = 0.0;
    };
    /// Arguments of soften().
    struct Softness
    {
        double radius_m = 0.0; ///< 0: the patch's ellipse
        double more_Hz = 0.0;
    };

    double wantedRate_Hz() const;
    void shape();
    int wantedFoci() const;
    void setCount(int count);
    void spread(double most_rad, double dt_s);
    Eigen::Vector3d placeAt(double angle_rad) const;
    void place();

    ContactPathOptions _options;
    ContactPatch _patch;
    Ellipse _ellipse;
    Softness _softness;
    double _steadyLength_m = 0.0; ///< circumference, smoothed
    double _angle_rad = 0.0;
    double _rate_Hz = 0.0;
    double _lag_m = 0.0;
    bool _isFitted = false;        ///< since the last advance()
    std::vector<Turning> _turning; ///< of each of _foci
    std::vector<PathFocus> _foci;
};

} // namespace midair::bridge
