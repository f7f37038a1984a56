#pragma once

#include "engine-bridge/contact/ContactPatch.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::bridge
{

/// How foci circle; isValid() names the first setting that is out of its range.
///
/// Foci that turn slowly in small steps are felt as steady pressure (Morisaki, Fujiwara, Makino,
/// Shinoda, IEEE Transactions on Haptics 15(2), 2022); the path is shrunk and the foci shared out
/// as in github.com/shinolab/midair-haptics-unity, FbiElipseMultiSTM.cs.
struct ContactPathOptions
{
    double rate_Hz = 5.0;        ///< 0 .. 100; turns a second
    double mostRate_Hz = 10.0;   ///< 0 .. 100; of what softness adds to the rate
    double mostRadius_m = 0.01;  ///< 1e-3 .. 0.1; of a radius that softness gives
    double focusSize_m = 2.5e-3; ///< 0 .. 0.02; what the focus's own size adds to the ellipse
    double leastRadius_m = 1e-3; ///< 1e-4 .. 0.02; no semi-axis of the path is shorter
    double focusEach_m = 8.5e-3; ///< 1e-3 .. 1; circumference of the path a focus
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
    double weight = 1.0; ///< 0 .. 1; under 1 while it comes or goes; factor on the pressure
};

/// The foci of one contact: they turn together on the patch's ellipse, projected on the skin.
///
/// The angle goes on whatever the patch does: the plane's axes are carried along without a twist,
/// and the ellipse is a symmetric matrix in them, (2 C^1/2 - focusSize) with the patch's covariance
/// C, which changes smoothly where its axes swap. No focus moves by more than the largest step:
/// where a circle is too long for the time between two fields it turns more slowly
/// (turningRate_Hz()), and where the hand is too fast the foci follow it (lag_m()). Where the way
/// is longer than 5 mm, as where the skin has a step, a focus fades and comes again there.
class ContactPath
{
public:
    /// Throws InputError for options that are not valid. \a patch has an own capsule and finite
    /// numbers, as those of ContactFinder. \a angle_rad: where the first focus starts.
    ContactPath(const ContactPathOptions& options, const ContactPatch& patch, double angle_rad = 0);

    /// Circles from now on on a circle of \a radius_m (0: the patch's ellipse; else clipped to the
    /// options' range) with \a more_Hz (>= 0) turns a second beside the options' rate. Numbers that
    /// aren't finite count as 0.
    void soften(double radius_m, double more_Hz);

    /// Takes the newest patch; the foci go to it in the next fields.
    void fit(const ContactPatch& patch);
    /// Goes on by \a dt_s (finite, >= 0), the time between two fields. Returns false, and changes
    /// nothing, for other numbers.
    bool advance(double dt_s);

    const std::vector<PathFocus>& foci() const { return _foci; }
    double angle_rad() const { return _angle_rad; }    ///< 0 .. 2 pi
    double turningRate_Hz() const { return _rate_Hz; } ///< in the last advance()
    /// m; how far the last of the foci still has to go to its place
    double lag_m() const { return _lag_m; }
    double semiMajor_m() const { return _ellipse.semiMajor_m; } ///< of the path
    double semiMinor_m() const { return _ellipse.semiMinor_m; }
    const ContactPatch& patch() const { return _patch; }

private:
    /// What is known of a focus besides its place.
    struct Turning
    {
        double offset_rad = 0.0; ///< behind the first
        bool isLeaving = false;
        bool isPlaced = false;                            ///< its position is on the path
        Eigen::Vector3d wanted = Eigen::Vector3d::Zero(); ///< where it should have been last
        bool isJumping = false; ///< it fades, to come again where it should be
    };

    /// The path, in a plane whose axes are carried along across the normal.
    struct Ellipse
    {
        Eigen::Vector3d u = Eigen::Vector3d::Zero();
        Eigen::Vector3d v = Eigen::Vector3d::Zero();
        Eigen::Matrix2d fromCircle = Eigen::Matrix2d::Zero(); ///< unit circle -> path, in u and v
        double semiMajor_m = 0.0;
        double semiMinor_m = 0.0;
    };
    /// What soften() was given.
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
