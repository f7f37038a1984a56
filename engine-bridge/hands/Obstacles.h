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
    /// >= 1; about how many ways are tested against capsules one by one. With more, fewer of the
    /// points stand for all of them, which bounds the time.
    int maxTests = 20000;

    bool isValid(std::string* error = nullptr) const;
};

/// What shadowGains() computed and what it could leave out.
struct ShadowCounters
{
    long pairs = 0;  ///< ways from transducers to spots, times capsules
    long tested = 0; ///< those that were tested one by one; the others were culled
    int spots = 0;   ///< points that stood for all of them
};

/// Share of the amplitude, 0 .. 1, that comes from \a source to \a point past \a obstacle. At 8.6
/// mm a yes or no would be crude: a finger's shadow is filled by diffraction. The obstacle is taken
/// for the rectangle that it fills across the straight way, and the weight is what passes that (see
/// Fresnel.h), with v = h sqrt(2 (d1 + d2)/(lambda d1 d2)), h the height of an edge over the way
/// and d1, d2 its distances from both ends, at least lambda/8.
///
/// A point inside an obstacle is felt on its skin: it is moved out to the nearest spot of it. What
/// comes to skin from its own side is let through in full, what comes from below its horizon fades
/// like behind an edge, by 1/2 at the horizon.
double shadowWeight(const Eigen::Vector3d& source,
                    const Eigen::Vector3d& point,
                    const Capsule& obstacle,
                    double wavelength_m);

/// The weights of all ways, n x m, by which the entries of G are multiplied. The product over the
/// obstacles is exact where they are apart and too dark where they overlap. Slow and plain;
/// shadowGains() is for use at run time.
Eigen::MatrixXd shadowWeights(const Eigen::Matrix3Xd& points,
                              const haptics::TransducerArray& array,
                              const std::vector<Capsule>& obstacles,
                              double wavelength_m);

/// A weight for each transducer (m): the root mean square of its weights to \a points (3 x n), to
/// multiply TransducerArray::gain by. Ways that stay clear of a capsule are culled by their angle
/// first; where too many are left, some of the points, evenly picked, stand for all. All ones
/// without obstacles. Throws base::InputError where \a options are wrong.
Eigen::VectorXd shadowGains(const Eigen::Matrix3Xd& points,
                            const haptics::TransducerArray& array,
                            const std::vector<Capsule>& obstacles,
                            const ShadowOptions& options,
                            ShadowCounters* counters = nullptr);

} // namespace midair::bridge
