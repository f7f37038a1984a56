#include "haptics/probe/FingertipForce.h"

#include "haptics/base/Units.h"
#include "haptics/propagation/PressureField.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

constexpr double kPad_m = 0.007; // half the breadth of a fingertip

/// Returns the point around which a fingertip covers the strongest points: with the largest sum of
/// squared pressures within a pad's radius, of at most kTried points.
Eigen::Index strongestPlace(const Eigen::Matrix3Xd& places, const Eigen::VectorXd& achieved_Pa)
{
    constexpr Eigen::Index kTried = 200;
    const Eigen::Index step = 1 + places.cols() / kTried;
    Eigen::Index best = 0;
    double most = -1.0;
    for (Eigen::Index i = 0; i < places.cols(); i += step)
    {
        const auto isCovered =
            (places.colwise() - places.col(i)).colwise().squaredNorm().array() <= kPad_m * kPad_m;
        const double sum = isCovered.select(achieved_Pa.transpose().array().square(), 0.0).sum();
        if (sum <= most) continue;
        most = sum;
        best = i;
    }
    return best;
}

/// Returns places on a fingertip's pad, each with the same share of it: a sunflower's seeds (Vogel
/// 1979), a third of a focus apart.
Eigen::Matrix3Xd padAt(const Eigen::Vector3d& place, const Eigen::Vector3d& normal)
{
    constexpr int kPlaces = 61;
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(
        Eigen::Vector3d::UnitZ(), normal.norm() > 0.0 ? normal : Eigen::Vector3d::UnitZ());
    Eigen::Matrix3Xd pad(3, kPlaces);
    for (int i = 0; i < kPlaces; ++i)
    {
        const double radius_m = kPad_m * std::sqrt((i + 0.5) / kPlaces);
        const double angle = i * base::kPi * (3.0 - std::sqrt(5.0));
        pad.col(i) =
            place +
            turn * Eigen::Vector3d(radius_m * std::cos(angle), radius_m * std::sin(angle), 0.0);
    }
    return pad;
}

} // namespace

Strength FingertipForce::strength() const
{
    return std::max(strengthOf(force_N, how, threshold_N),
                    strengthOf(alternating_N, PlayedAs::VIBRATING, threshold_N));
}

FingertipForce fingertipForce(const Eigen::Vector3d& place,
                              const Eigen::Vector3d& normal,
                              const TransducerArray& array,
                              const Medium& medium,
                              const FieldSequence& sequence,
                              bool isContact)
{
    FingertipForce felt;
    felt.how = isContact                                    ? PlayedAs::CIRCLING
               : sequence.modulation.amplitudeRate_Hz > 0.0 ? PlayedAs::VIBRATING
                                                            : PlayedAs::HELD;
    if (sequence.fields.empty()) return felt;
    const Eigen::VectorXd square_Pa2 =
        pressuresAt(padAt(place, normal), array, medium, sequence.fields)
            .cwiseAbs2()
            .cast<double>()
            .colwise()
            .mean();
    Eigen::VectorXd force_N(square_Pa2.size()); // of each field
    for (Eigen::Index k = 0; k < force_N.size(); ++k)
        force_N[k] = sequence.report.ringingShare *
                     radiationForce(std::sqrt(square_Pa2[k]), base::kPi * kPad_m * kPad_m, medium);
    felt.force_N = force_N.mean();
    constexpr double kSlowest_Hz = 20.0; // what is slower isn't felt as a vibration
    constexpr double kFastest_Hz = 1000.0;
    const double repeat_Hz = sequence.modulation.fieldRate_Hz / static_cast<double>(force_N.size());
    if (!isContact && force_N.size() > 1 && repeat_Hz >= kSlowest_Hz && repeat_Hz <= kFastest_Hz)
        felt.alternating_N = 0.5 * (force_N.maxCoeff() - force_N.minCoeff());
    return felt;
}

FingertipForce strongestForce(const ControlPoints& points,
                              const Eigen::VectorXd& achieved_Pa,
                              const TransducerArray& array,
                              const Medium& medium,
                              const FieldSequence& sequence,
                              int foci)
{
    if (points.size() == 0 || achieved_Pa.size() != points.size() ||
        !(achieved_Pa.maxCoeff() > 0.0))
        return {};
    const Eigen::Index where = strongestPlace(points.positions, achieved_Pa);
    const Eigen::Vector3d normal = points.normals.cols() > where
                                       ? Eigen::Vector3d(points.normals.col(where))
                                       : Eigen::Vector3d::Zero();
    return fingertipForce(points.positions.col(where),
                          normal,
                          array,
                          medium,
                          sequence,
                          where >= points.size() - foci);
}

} // namespace midair::haptics
