#pragma once

#include "engine-bridge/hands/Hand.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>

#include <complex>
#include <cstdint>
#include <string>
#include <vector>

namespace midair::bridge
{

/// The field behind the edge of a half-plane divided by the field without it: F(v) = (1 + j)/2
/// integral from v to infinity of e^{-j pi t^2/2} dt (Fresnel-Kirchhoff; ITU-R P.526, equation 7b).
/// v is the height of the edge over the straight path in units of the first Fresnel zone's
/// sqrt(lambda d1 d2/(2 (d1 + d2))): F is 1 at -infinity, 1/2 at 0, 0 at infinity. Good to 2e-3,
/// the error of the rational approximations in Abramowitz & Stegun, 7.3.32 and 7.3.33.
std::complex<double> knifeEdge(double v);

/// Returns the share 0 .. 1 of the amplitude that passes a rectangle from x1 to x2 across and from
/// y1 to y2 along, all in units of v: |1 - (F(x1) - F(x2)) (F(y1) - F(y2))|, by Babinet's
/// principle. x1 > -x2 (the nearer edge is x1). Ignores the ripples of a few percent outside the
/// shadow: returns 1 from x1 = kLit on.
double pastRectangle(double x1, double x2, double y1, double y2);

/// An edge this far off the straight path, in units of v, doesn't attenuate (|1 - F(v)| is first 1
/// at 0.6).
constexpr double kLit = 0.8;

/// Options for shadows; isValid() names the first setting that is out of its range.
struct ShadowOptions
{
    double wavelength_m = 8.58e-3; ///< > 0
    /// >= 1; the approximate number of paths tested against capsules one by one. Beyond it only
    /// some of the points are used, which bounds the time.
    int maxTests = 20000;

    bool isValid(std::string* error = nullptr) const;
};

/// Work of shadowGains(), done and skipped.
struct ShadowCounters
{
    long pairs = 0;  ///< paths from transducers to points used, times capsules
    long tested = 0; ///< pairs tested one by one; the others were culled
    int spots = 0;   ///< points used
};

/// Returns the share of the amplitude, 0 .. 1, that reaches \a point from \a source past \a
/// obstacle. At a wavelength of 8.6 mm diffraction fills a finger's shadow, so it is not just 0 or
/// 1. The obstacle is replaced by the rectangle that it covers across the straight path; the share
/// is the part that passes it (knifeEdge()), with v = h sqrt(2 (d1 + d2)/(lambda d1 d2)), h the
/// height of an edge over the path and d1, d2 its distances from both ends, at least lambda/8.
///
/// A point inside an obstacle is moved to the nearest place on its skin. Sound that reaches skin
/// from its own side passes fully; sound from below its horizon is attenuated as behind an edge,
/// with 1/2 at the horizon.
double shadowWeight(const Eigen::Vector3d& source,
                    const Eigen::Vector3d& point,
                    const Capsule& obstacle,
                    double wavelength_m);

/// Returns the shares of all paths, n x m, as factors for the entries of G. The product over the
/// obstacles is exact if they are apart and too small if they overlap. Slow reference; use
/// shadowGains() at run time.
Eigen::MatrixXd shadowWeights(const Eigen::Matrix3Xd& points,
                              const haptics::TransducerArray& array,
                              const std::vector<Capsule>& obstacles,
                              double wavelength_m);

/// Returns a factor for each transducer (m), for multiplying TransducerArray::gain: the root mean
/// square of its shares to \a points (3 x n). Culls paths clear of a capsule by their angle; if too
/// many remain, uses only some of the points, evenly selected. All ones without obstacles. Throws
/// base::InputError if \a options are not valid.
Eigen::VectorXd shadowGains(const Eigen::Matrix3Xd& points,
                            const haptics::TransducerArray& array,
                            const std::vector<Capsule>& obstacles,
                            const ShadowOptions& options,
                            ShadowCounters* counters = nullptr);

/// Approximates \a mesh by capsules, in its frame, for computing shadows (see Obstacles.h).
///
/// The box along the mesh's principal axes, lengths a >= b >= c, is cut into at most \a most (>= 1)
/// strips along a, each about as wide as the box is thick or as \a leastWidth_m (> 0), whichever is
/// larger. Each strip that contains a part of the surface becomes a capsule as long as that part.
/// Strips under two wavelengths would let sound through, because shadows of several obstacles are
/// multiplied as if they were far apart. Therefore plates count as leastWidth_m thick, and hollow
/// or bent shapes as filled between their ends. Returns none for a mesh without triangles.
std::vector<Capsule>
capsulesOf(const haptics::TriangleMesh& mesh, double leastWidth_m = 0.018, int most = 24);

/// The hands and props in the array frame, and their effects on the field.
struct HandsAndObstacles
{
    std::vector<HandCapsule> hands;
    /// real objects that block sound, unlike rendered ones
    std::vector<Capsule> props;
    /// > 0: only points within this of a hand's skin are solved; 0: all, hands or none
    double reach_m = 0.0;
    bool shadows = false; ///< hands and props shadow transducers
};

/// Hands and props that moved by at most this, m, count as unmoved. It is at most a fifth of a
/// wavelength for existing devices.
constexpr double kHandTolerance_m = 1e-3;

/// Returns true if the field for \a a also fits \a b: everything that affects it is equal, or moved
/// by at most kHandTolerance_m.
bool equivalent(const HandsAndObstacles& a, const HandsAndObstacles& b);

/// Applies a HandsAndObstacles to control points and to the array.
class ReachAndShadow
{
public:
    /// Returns true if \a now is equivalent to the argument of the last begin().
    bool unmoved(const HandsAndObstacles& now) const { return equivalent(now, _last); }

    /// Sets the hands and props for the following calls.
    void begin(const HandsAndObstacles& now) { _last = now; }

    /// Moves points farther than reach_m from all hands from \a points to \a skipped, and returns
    /// their number. If reach_m is 0, all points stay.
    std::uint64_t keepWithinReach(haptics::ControlPoints& points, Eigen::Matrix3Xd& skipped) const;

    /// Returns a copy of \a array with lower gains for transducers that hands and props shadow from
    /// \a points, or \a array itself without shadows; valid until the next call.
    const haptics::TransducerArray& shadowed(const haptics::ControlPoints& points,
                                             const haptics::TransducerArray& array,
                                             double wavelength_m);

private:
    HandsAndObstacles _last;
    haptics::TransducerArray _shadowed;
};

} // namespace midair::bridge
