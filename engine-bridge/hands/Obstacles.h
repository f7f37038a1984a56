#pragma once

#include "engine-bridge/hands/Hand.h"
#include "haptics/array/TransducerArray.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace midair::bridge
{

/// How shadows are computed; isValid() names the first setting that is out of its range.
struct ShadowOptions
{
    double wavelength_m = 8.58e-3; ///< > 0
    /// >= 1; the approximate number of paths tested against capsules one by one. If there are more,
    /// only some of the points are used, which bounds the time.
    int maxTests = 20000;

    bool isValid(std::string* error = nullptr) const;
};

/// What shadowGains() computed and what it could skip.
struct ShadowCounters
{
    long pairs = 0;  ///< paths from transducers to points used, times capsules
    long tested = 0; ///< pairs that were tested one by one; the others were culled
    int spots = 0;   ///< points used
};

/// The share of the amplitude, 0 .. 1, that gets from \a source to \a point past \a obstacle. At a
/// wavelength of 8.6 mm diffraction fills a finger's shadow, so it is not just 0 or 1. The obstacle
/// is replaced by the rectangle that it covers across the straight path, and the share is what
/// passes that (see Fresnel.h), with v = h sqrt(2 (d1 + d2)/(lambda d1 d2)), h the height of an
/// edge over the path and d1, d2 its distances from both ends, at least lambda/8.
///
/// A point inside an obstacle is moved to the nearest place on its skin. Sound that reaches skin
/// from its own side passes in full; sound from below its horizon fades as behind an edge, with 1/2
/// at the horizon.
double shadowWeight(const Eigen::Vector3d& source,
                    const Eigen::Vector3d& point,
                    const Capsule& obstacle,
                    double wavelength_m);

/// The shares of all paths, n x m, as factors for the entries of G. The product over the obstacles
/// is exact if they are apart and too small if they overlap. Slow and simple; use shadowGains() at
/// run time.
Eigen::MatrixXd shadowWeights(const Eigen::Matrix3Xd& points,
                              const haptics::TransducerArray& array,
                              const std::vector<Capsule>& obstacles,
                              double wavelength_m);

/// A factor for each transducer (m), by which to multiply TransducerArray::gain: the root mean
/// square of its shares to \a points (3 x n). Paths that stay clear of a capsule are culled by
/// their angle first; if too many are left, only some of the points are used, picked evenly. All
/// ones without obstacles. Throws base::InputError if \a options are not valid.
Eigen::VectorXd shadowGains(const Eigen::Matrix3Xd& points,
                            const haptics::TransducerArray& array,
                            const std::vector<Capsule>& obstacles,
                            const ShadowOptions& options,
                            ShadowCounters* counters = nullptr);

} // namespace midair::bridge
