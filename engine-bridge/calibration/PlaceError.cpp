#include "engine-bridge/calibration/PlaceError.h"

#include "haptics/base/SmallMatrices.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace midair::bridge
{

namespace
{

constexpr int kErrorDraws = 4000; ///< gives the 95 % quantile to about 1.5 %
constexpr int kEdgeDirections = 256;

} // namespace

Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v)
{
    Eigen::Matrix3d m;
    m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return m;
}

PlaceError placeError(const Eigen::Matrix3d& C, double noise_m, int freedom, std::uint64_t seed)
{
    const base::SymmetricAxes<3> axes = base::symmetricAxes(C);
    const Eigen::Vector3d sigmas = noise_m * axes.values.cwiseMax(0.0).cwiseSqrt();
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::chi_squared_distribution<double> chi2(freedom);
    std::vector<double> errors(kErrorDraws);
    for (double& error : errors)
    {
        const Eigen::Vector3d z(normal(random), normal(random), normal(random));
        error = sigmas.cwiseProduct(z).norm() * std::sqrt(freedom / chi2(random));
    }
    std::sort(errors.begin(), errors.end());
    return {errors[kErrorDraws / 2], errors[kErrorDraws * 95 / 100]};
}

Eigen::Matrix3d worstAtRadius(double radius,
                              const std::function<Eigen::Matrix3d(const Eigen::Vector3d&)>& at)
{
    // A Fibonacci lattice spreads the places evenly.
    Eigen::Matrix3d worst = at(Eigen::Vector3d(0, 0, radius));
    const double golden = base::kPi * (3.0 - std::sqrt(5.0));
    for (int i = 0; i < kEdgeDirections; ++i)
    {
        const double z = 1.0 - (2.0 * i + 1.0) / kEdgeDirections;
        const double ring = std::sqrt(1.0 - z * z);
        const Eigen::Vector3d u(ring * std::cos(golden * i), ring * std::sin(golden * i), z);
        const Eigen::Matrix3d here = at(radius * u);
        if (here.trace() > worst.trace()) worst = here;
    }
    return worst;
}

} // namespace midair::bridge
