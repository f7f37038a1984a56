#include "engine-bridge/playing/EarBound.h"

#include "engine-bridge/playing/FieldBounds.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace midair::bridge
{

namespace
{

// Error of single precision, relative to the pressure of all transducers in phase.
constexpr double kSumError = 1e-5;

} // namespace

EarBound::EarBound(double limit_dB, std::shared_ptr<haptics::Exposure> exposure) :
    _limit_dB(limit_dB),
    _limit_Pa(std::sqrt(haptics::meanSquareOf_Pa2(limit_dB))),
    _exposure(std::move(exposure))
{
}

// The peak pressures at the loudest spot of each place (n), whichever parts of the array sound.
Eigen::VectorXf EarBound::loudest_Pa(const Eigen::VectorXcf& played,
                                     const device::DriveAbility& ability) const
{
    const int parts =
        ability.part.empty() ? 1 : 1 + *std::max_element(ability.part.begin(), ability.part.end());
    const Eigen::Index spots = haptics::Exposure::kSpots * _exposure->size();
    Eigen::MatrixXcf p(spots, parts);
    for (int part = 0; part < parts; ++part)
    {
        Eigen::VectorXcf q = played;
        for (Eigen::Index i = 0; parts > 1 && i < q.size(); ++i)
            if (ability.part[static_cast<std::size_t>(i)] != part) q[i] = 0.0f;
        const Eigen::MatrixXcf each = _exposure->spots_Pa(q);
        p.col(part) = Eigen::Map<const Eigen::VectorXcf>(each.data(), spots);
    }
    const Eigen::VectorXf most = mostOfParts(p);
    return Eigen::Map<const Eigen::MatrixXf>(
               most.data(), haptics::Exposure::kSpots, _exposure->size())
        .colwise()
        .maxCoeff()
        .transpose();
}

double EarBound::excess(const Eigen::VectorXcf& played,
                        float rounding,
                        const device::DriveAbility& ability) const
{
    if (!played.allFinite()) return std::nan("");
    if (played.isZero(0.0f)) return 0.0;
    const Eigen::VectorXf squares = played.cwiseAbs2();
    const Eigen::VectorXf incoherent_Pa2 = _exposure->incoherentOf_Pa2(squares);
    const Eigen::VectorXf loudest = loudest_Pa(played, ability);
    Eigen::VectorXf rounded_Pa2 = Eigen::VectorXf::Zero(squares.size());
    if (rounding > 0.0f)
        rounded_Pa2 = _exposure->incoherentOf_Pa2(squares.cwiseMin(rounding * rounding));
    double most = 0.0;
    for (Eigen::Index l = 0; l < loudest.size(); ++l)
    {
        const double mean_Pa = std::sqrt(static_cast<double>(incoherent_Pa2[l]));
        const double spread = std::sqrt(haptics::Exposure::kSpeckle);
        double coherent_Pa = static_cast<double>(loudest[l]) / std::sqrt(2.0);
        coherent_Pa += kSumError * std::sqrt(static_cast<double>(played.size())) * mean_Pa;
        if (rounding > 0.0f) coherent_Pa += spread * std::sqrt(static_cast<double>(rounded_Pa2[l]));
        // Not max(), which may ignore NaN.
        for (const double one_Pa : {coherent_Pa, spread * mean_Pa})
            if (const double ratio = one_Pa / _limit_Pa; !(ratio <= most)) most = ratio;
    }
    return most;
}

} // namespace midair::bridge
