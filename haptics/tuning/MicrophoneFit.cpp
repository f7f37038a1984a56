#include "haptics/tuning/MicrophoneFit.h"

#include "haptics/array/Medium.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <complex>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// Starts are at most 1.04 mm from the place at 40 kHz, where a ring of transducers still agrees by
// J0(2 k 1.04 mm) = 0.5; its side lobes reach 0.4.
constexpr double kStepPerWavelength = 0.14;
constexpr int kRefined = 12;          // number of best starts to refine
constexpr Eigen::Index kCoarse = 600; // transducers for judging the starts
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
        // The prior keeps components that the phases don't determine at the planned place.
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

constexpr double kMostSpread_rad = base::kPi / 4.0;
// exp(-kCertainty) is about the probability that chance agrees as well as an accepted fit.
constexpr double kCertainty = 7.0;
constexpr int kLeastTransducers = 8;
constexpr double kLeastScatter_rad = 2e-3;
constexpr int kIterations = 25;
constexpr double kBiweight = 4.7;

double biweight(double residual, double sigma)
{
    const double t = residual / (kBiweight * sigma);
    return t * t < 1.0 ? (1.0 - t * t) * (1.0 - t * t) : 0.0;
}

double deviationOf(std::vector<double> sizes)
{
    return 1.4826 * base::percentile(std::move(sizes), 0.5);
}

/// All places and the speed of sound together. Parameters: each place (3 P), each place's phase
/// (P), ln c. A transducer's residuals at its places share its own phase, of variance s^2, and
/// differ by scatter, of variance sigma^2; so their mean, of variance s^2 + sigma^2/P_i, and the
/// deviations from it are fitted separately.
class JointFit
{
public:
    JointFit(const TransducerArray& array,
             const Eigen::Matrix3Xd& planned,
             const TuningResponses& responses,
             const std::vector<bool>& live,
             const MicrophonePrior& prior) :
        _array(array),
        _planned(planned),
        _responses(responses),
        _live(live),
        _prior(prior)
    {
        Medium medium;
        medium.temperature_C = prior.temperature_C;
        _c0 = medium.soundSpeed();
        // c ~ sqrt(T): dc/c = dT/(2 T).
        _speedError =
            std::max(1e-7, 0.5 * prior.temperatureError_C / base::toKelvin(prior.temperature_C));
    }

    MicrophoneFit run()
    {
        MicrophoneFit fit;
        fit.places = _planned;
        fit.phase_rad.setZero(_planned.cols());
        fit.soundSpeed_m_s = _c0;
        for (int place = 0; place < _planned.cols() && fit.refusal.empty(); ++place)
            startAt(place, fit);
        if (!fit.refusal.empty()) return fit;
        fit.spread_rad = 0.25;
        fit.scatter_rad = 0.05;
        for (int iteration = 0; iteration < kIterations; ++iteration)
            if (improve(fit) < 1e-7) break;
        if (_planned.cols() == 1) fit.scatter_rad = 0.0;
        return fit;
    }

private:
    void startAt(int place, MicrophoneFit& fit) const
    {
        std::vector<Eigen::Index> which;
        for (Eigen::Index i = 0; i < _array.size(); ++i)
            if (_live[static_cast<std::size_t>(i)] && std::isfinite(_responses.y(place, i).real()))
                which.push_back(i);
        if (static_cast<int>(which.size()) < kLeastTransducers)
        {
            fit.refusal = fmt::format("only {} transducers were heard at place {}; a fit needs {}",
                                      which.size(),
                                      place,
                                      kLeastTransducers);
            return;
        }
        const Eigen::VectorXcd y = _responses.y.row(place)(which).transpose();
        const HeardPhases heard{_array.positions(Eigen::all, which),
                                y.array().arg(),
                                base::kTwoPi * _array.frequency_Hz / _c0};
        const FoundPlace found = findPlace(heard, _planned.col(place), _prior.search_m);
        fit.places.col(place) = found.place;
        fit.phase_rad[place] = found.phase_rad;
        fit.refusal = doubtOf(found, place, static_cast<int>(which.size()));
    }

    // For random phases the largest of K means of n has |mean|^2 n of about ln K (Rayleigh).
    std::string doubtOf(const FoundPlace& found, int place, int count) const
    {
        const double spread_rad = found.agreement > 0.0
                                      ? std::sqrt(-0.5 * std::log(std::min(1.0, found.agreement)))
                                      : 9.0;
        const double chance = std::sqrt((std::log(std::max(1, found.starts)) + kCertainty) / count);
        if (spread_rad <= kMostSpread_rad && found.agreement > chance) return {};
        if (spread_rad <= kMostSpread_rad)
            return fmt::format(
                "the phases at place {} agree no better than chance might: {:.2f} with "
                "{} transducers, where {:.2f} is needed",
                place,
                found.agreement,
                count,
                chance);
        return fmt::format(
            "the phases at place {} spread by more than 45 degrees wherever the microphone is "
            "looked "
            "for within {:.1f} mm of ({:.4f}, {:.4f}, {:.4f}) m: it is elsewhere (--search), the "
            "array is another one, or the readings aren't against the drive's clock",
            place,
            1e3 * _prior.search_m,
            _planned(0, place),
            _planned(1, place),
            _planned(2, place));
    }

    /// Residuals of one transducer at the places that measured it.
    struct Seen
    {
        std::vector<int> place;
        Eigen::VectorXd rho; ///< unwrapped about the first
        Eigen::MatrixXd J;   ///< places x parameters
    };

    Seen see(Eigen::Index i, const MicrophoneFit& fit) const
    {
        Seen seen;
        const Eigen::Index P = _planned.cols();
        for (int p = 0; p < P; ++p)
            if (std::isfinite(_responses.y(p, i).real())) seen.place.push_back(p);
        const double k = base::kTwoPi * _array.frequency_Hz / fit.soundSpeed_m_s;
        const auto count = static_cast<Eigen::Index>(seen.place.size());
        seen.rho.resize(count);
        seen.J.setZero(count, 4 * P + 1);
        for (Eigen::Index row = 0; row < count; ++row)
        {
            const int p = seen.place[static_cast<std::size_t>(row)];
            const Eigen::Vector3d d = fit.places.col(p) - _array.positions.col(i);
            const double R = d.norm();
            const double rho = std::arg(_responses.y(p, i)) + k * R - fit.phase_rad[p];
            const double near = row > 0 ? seen.rho[0] : 0.0;
            seen.rho[row] = near + wrappedToHalfTurn(rho - near);
            seen.J.block<1, 3>(row, 3 * p) = k * d.transpose() / R;
            seen.J(row, 3 * P + p) = -1.0;
            seen.J(row, 4 * P) = -k * R;
        }
        if (count > 1) // the mean may have left the range about 0
        {
            const double mean = seen.rho.mean();
            seen.rho.array() += wrappedToHalfTurn(mean) - mean;
        }
        return seen;
    }

    std::vector<Seen> seeAll(const MicrophoneFit& fit) const
    {
        std::vector<Seen> all;
        for (Eigen::Index i = 0; i < _array.size(); ++i)
            if (_live[static_cast<std::size_t>(i)])
            {
                all.push_back(see(i, fit));
                if (all.back().place.empty()) all.pop_back();
            }
        return all;
    }

    static void estimateSpreads(const std::vector<Seen>& all, MicrophoneFit& fit)
    {
        std::vector<double> means, deviations;
        for (const Seen& seen : all)
        {
            means.push_back(std::abs(seen.rho.mean()));
            const auto count = static_cast<double>(seen.rho.size());
            if (seen.rho.size() > 1)
                for (const double rho : seen.rho)
                    deviations.push_back(std::abs(rho - seen.rho.mean()) *
                                         std::sqrt(count / (count - 1.0)));
        }
        fit.spread_rad = std::max(kLeastScatter_rad, deviationOf(means));
        fit.scatter_rad = deviations.empty() ? kLeastScatter_rad
                                             : std::max(kLeastScatter_rad, deviationOf(deviations));
    }

    /// Makes one step; returns its length in metres.
    double improve(MicrophoneFit& fit) const
    {
        const Eigen::Index P = _planned.cols();
        const Eigen::Index n = 4 * P + 1;
        const std::vector<Seen> all = seeAll(fit);
        estimateSpreads(all, fit);
        Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
        Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
        const auto add = [&](const Eigen::RowVectorXd& J, double rho, double sigma)
        {
            const double w = biweight(rho, sigma) / (sigma * sigma);
            A += w * J.transpose() * J;
            b -= w * rho * J.transpose();
        };
        for (const Seen& seen : all)
        {
            const Eigen::RowVectorXd mean = seen.J.colwise().mean();
            const double middle = seen.rho.mean();
            add(mean, middle, fit.spread_rad);
            for (Eigen::Index row = 0; row < seen.rho.size() && seen.rho.size() > 1; ++row)
                add(seen.J.row(row) - mean, seen.rho[row] - middle, fit.scatter_rad);
        }
        addPriors(fit, A, b);
        const Eigen::LDLT<Eigen::MatrixXd> solver(A);
        const Eigen::VectorXd step = solver.solve(b);
        if (!step.allFinite()) return 0.0;
        for (Eigen::Index p = 0; p < P; ++p)
            fit.places.col(p) += step.segment<3>(3 * p);
        fit.phase_rad += step.segment(3 * P, P);
        fit.soundSpeed_m_s *= std::exp(step[4 * P]);
        tellErrors(solver.solve(Eigen::MatrixXd::Identity(n, n)), fit);
        return step.head(3 * P).cwiseAbs().maxCoeff();
    }

    void addPriors(const MicrophoneFit& fit, Eigen::MatrixXd& A, Eigen::VectorXd& b) const
    {
        const Eigen::Index P = _planned.cols();
        const double place = std::pow(std::max(1e-6, 0.5 * _prior.search_m), -2.0);
        for (Eigen::Index p = 0; p < P; ++p)
        {
            A.diagonal().segment<3>(3 * p).array() += place;
            b.segment<3>(3 * p) -= place * (fit.places.col(p) - _planned.col(p));
        }
        const double speed = std::pow(_speedError, -2.0);
        A(4 * P, 4 * P) += speed;
        b[4 * P] -= speed * std::log(fit.soundSpeed_m_s / _c0);
    }

    static void tellErrors(const Eigen::MatrixXd& covariance, MicrophoneFit& fit)
    {
        const Eigen::Index P = fit.places.cols();
        fit.placeErrors.resize(3, P);
        Eigen::Vector3d common = Eigen::Vector3d::Zero();
        for (Eigen::Index p = 0; p < P; ++p)
        {
            fit.placeErrors.col(p) =
                covariance.diagonal().segment<3>(3 * p).cwiseMax(0.0).cwiseSqrt();
            for (Eigen::Index q = 0; q < P; ++q)
                common += covariance.block<3, 3>(3 * p, 3 * q).diagonal();
        }
        fit.shiftError = (common / double(P * P)).cwiseMax(0.0).cwiseSqrt();
        fit.soundSpeedError_m_s =
            fit.soundSpeed_m_s * std::sqrt(std::max(0.0, covariance(4 * P, 4 * P)));
    }

    const TransducerArray& _array;
    const Eigen::Matrix3Xd& _planned;
    const TuningResponses& _responses;
    const std::vector<bool>& _live;
    const MicrophonePrior& _prior;
    double _c0 = 0.0;
    double _speedError = 0.0; ///< of ln c
};

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

MicrophoneFit fitMicrophone(const TransducerArray& array,
                            const Eigen::Matrix3Xd& planned,
                            const TuningResponses& responses,
                            const std::vector<bool>& live,
                            const MicrophonePrior& prior)
{
    return JointFit(array, planned, responses, live, prior).run();
}

} // namespace midair::haptics
