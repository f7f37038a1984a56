#include "haptics/tuning/PlaceSearch.h"

#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <complex>

namespace midair::haptics
{

namespace
{

// Starts lie at most 1.04 mm from the place at 40 kHz, where a ring of transducers still agrees by
// J0(2 k 1.04 mm) = 0.5; its side lobes reach 0.4.
constexpr double kStepPerWavelength = 0.14;
constexpr int kRefined = 12;          // of the starts, the best
constexpr Eigen::Index kCoarse = 600; // transducers that the starts are judged by
constexpr int kSearchIterations = 15;
constexpr double kLeastScale_rad = 0.01;

std::complex<double>
meanOf(const HeardPhases& heard, const Eigen::Vector3d& place, Eigen::Index step)
{
    std::complex<double> sum = 0.0;
    Eigen::Index count = 0;
    for (Eigen::Index i = 0; i < heard.phase_rad.size(); i += step, ++count)
        sum += std::polar(1.0,
                          2.0 * (heard.phase_rad[i] +
                                 heard.wavenumber * (place - heard.positions.col(i)).norm()));
    return count > 0 ? sum / double(count) : sum;
}

FoundPlace judged(const HeardPhases& heard, const Eigen::Vector3d& place, Eigen::Index step)
{
    const std::complex<double> mean = meanOf(heard, place, step);
    return {place, std::abs(mean), 0.5 * std::arg(mean), 0};
}

// Gauss-Newton on rho_i = wrap(arg y_i + k R_i - gamma), with Tukey's biweight at 4.7 times the
// median deviation: d rho/d r = k (r - r_i)/R_i, d rho/d gamma = -1.
FoundPlace
refined(const HeardPhases& heard, FoundPlace at, const Eigen::Vector3d& planned, double search_m)
{
    const Eigen::Index n = heard.phase_rad.size();
    Eigen::VectorXd rho(n);
    Eigen::MatrixX4d J(n, 4);
    for (int iteration = 0; iteration < kSearchIterations; ++iteration)
    {
        std::vector<double> sizes;
        for (Eigen::Index i = 0; i < n; ++i)
        {
            const Eigen::Vector3d d = at.place - heard.positions.col(i);
            const double R = d.norm();
            rho[i] = wrappedToHalfTurn(heard.phase_rad[i] + heard.wavenumber * R - at.phase_rad);
            J.row(i) << heard.wavenumber * d.transpose() / R, -1.0;
            sizes.push_back(std::abs(rho[i]));
        }
        const double scale =
            4.7 * std::max(kLeastScale_rad, 1.4826 * base::percentile(std::move(sizes), 0.5));
        const Eigen::ArrayXd t = (rho.array() / scale).square().min(1.0);
        const Eigen::VectorXd w = (1.0 - t).square();
        // The prior on the place keeps what the phases don't determine where it was planned.
        Eigen::Matrix4d A = J.transpose() * w.asDiagonal() * J;
        Eigen::Vector4d b = -J.transpose() * w.cwiseProduct(rho);
        const double weight = std::pow(scale / (4.7 * std::max(1e-6, 0.5 * search_m)), 2.0);
        A.topLeftCorner<3, 3>().diagonal().array() += weight;
        b.head<3>() -= weight * (at.place - planned);
        const Eigen::Vector4d step = A.ldlt().solve(b);
        if (!step.allFinite()) break;
        at.place += step.head<3>();
        at.phase_rad += step[3];
        if (step.head<3>().norm() < 1e-7) break;
    }
    return judged(heard, at.place, 1);
}

} // namespace

double wrappedToHalfTurn(double angle_rad)
{
    return angle_rad - base::kPi * std::round(angle_rad / base::kPi);
}

FoundPlace findPlace(const HeardPhases& heard, const Eigen::Vector3d& planned, double search_m)
{
    const double step_m = kStepPerWavelength * base::kTwoPi / heard.wavenumber;
    const int reach = static_cast<int>(std::ceil(search_m / step_m));
    const Eigen::Index stride = std::max<Eigen::Index>(1, heard.phase_rad.size() / kCoarse);
    std::vector<FoundPlace> starts;
    for (int x = -reach; x <= reach; ++x)
        for (int y = -reach; y <= reach; ++y)
            for (int z = -reach; z <= reach; ++z)
            {
                const Eigen::Vector3d d = step_m * Eigen::Vector3d(x, y, z);
                if (d.norm() <= search_m + 0.5 * step_m)
                    starts.push_back(judged(heard, planned + d, stride));
            }
    const auto best = starts.begin() + std::min<std::ptrdiff_t>(
                                           kRefined, static_cast<std::ptrdiff_t>(starts.size()));
    std::partial_sort(starts.begin(),
                      best,
                      starts.end(),
                      [](const FoundPlace& a, const FoundPlace& b)
                      { return a.agreement > b.agreement; });
    FoundPlace found;
    for (auto start = starts.begin(); start != best; ++start)
    {
        const FoundPlace candidate = refined(heard, *start, planned, search_m);
        if (candidate.agreement > found.agreement) found = candidate;
    }
    found.starts = static_cast<int>(starts.size());
    return found;
}

} // namespace midair::haptics
