#include "haptics/probe/FingertipForce.h"

#include "haptics/base/Units.h"
#include "haptics/propagation/FingertipVibration.h"
#include "haptics/propagation/PressureField.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

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
        const double radius_m = kFingertipPad_m * std::sqrt((i + 0.5) / kPlaces);
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
                     radiationForce(std::sqrt(square_Pa2[k]),
                                    base::kPi * kFingertipPad_m * kFingertipPad_m,
                                    medium);
    felt.force_N = force_N.mean();
    constexpr double kSlowest_Hz = 20.0; // what is slower isn't felt as a vibration
    constexpr double kFastest_Hz = 1000.0;
    const double repeat_Hz = sequence.modulation.fieldRate_Hz / static_cast<double>(force_N.size());
    if (!isContact && force_N.size() > 1 && repeat_Hz >= kSlowest_Hz && repeat_Hz <= kFastest_Hz)
        felt.alternating_N = 0.5 * (force_N.maxCoeff() - force_N.minCoeff());
    return felt;
}

namespace
{

/// Returns the point with the largest sum of squared pressures within a pad's radius, of at most
/// kTried points: a guess, which doesn't know the pressures between the points.
int likelyPoint(const Eigen::Matrix3Xd& places, const Eigen::VectorXd& achieved_Pa)
{
    constexpr Eigen::Index kTried = 200;
    const Eigen::Index step = 1 + places.cols() / kTried;
    Eigen::Index best = 0;
    double most = -1.0;
    for (Eigen::Index i = 0; i < places.cols(); i += step)
    {
        const auto isCovered = (places.colwise() - places.col(i)).colwise().squaredNorm().array() <=
                               kFingertipPad_m * kFingertipPad_m;
        const double sum = isCovered.select(achieved_Pa.transpose().array().square(), 0.0).sum();
        if (sum <= most) continue;
        most = sum;
        best = i;
    }
    return static_cast<int>(best);
}

FingertipForce forceAt(Eigen::Index point,
                       const ControlPoints& points,
                       const TransducerArray& array,
                       const Medium& medium,
                       const FieldSequence& sequence,
                       bool isContact)
{
    const Eigen::Vector3d normal = points.normals.cols() > point
                                       ? Eigen::Vector3d(points.normals.col(point))
                                       : Eigen::Vector3d::Zero();
    return fingertipForce(points.positions.col(point), normal, array, medium, sequence, isContact);
}

} // namespace

FingertipForce FingertipSearch::begin(const ControlPoints& points,
                                      const Eigen::VectorXd& achieved_Pa,
                                      const TransducerArray& array,
                                      const Medium& medium,
                                      const FieldSequence& sequence,
                                      bool isContact,
                                      int most)
{
    _left = 0;
    _most = {};
    const int n = points.size();
    if (n == 0 || achieved_Pa.size() != n || !(achieved_Pa.maxCoeff() > 0.0) || sequence.isEmpty())
        return _most;
    const int likely = likelyPoint(points.positions, achieved_Pa), last = std::min(_best, n - 1);
    _left = n; // these two come again, in their turn
    _best = likely;
    _most = forceAt(likely, points, array, medium, sequence, isContact);
    if (last != likely) take(last, forceAt(last, points, array, medium, sequence, isContact));
    return goOn(points, array, medium, sequence, isContact, most);
}

FingertipForce FingertipSearch::goOn(const ControlPoints& points,
                                     const TransducerArray& array,
                                     const Medium& medium,
                                     const FieldSequence& sequence,
                                     bool isContact,
                                     int most)
{
    for (; most > 0 && _left > 0; --most, --_left, ++_next)
    {
        if (_next >= points.size()) _next = 0;
        take(_next, forceAt(_next, points, array, medium, sequence, isContact));
    }
    return _most;
}

void FingertipSearch::take(int point, const FingertipForce& force)
{
    if (!(force.force_N > _most.force_N)) return;
    _most = force;
    _best = point;
}

FingertipForce strongestForce(const ControlPoints& points,
                              const Eigen::VectorXd& achieved_Pa,
                              const TransducerArray& array,
                              const Medium& medium,
                              const FieldSequence& sequence)
{
    return FingertipSearch().begin(
        points, achieved_Pa, array, medium, sequence, false, points.size());
}

} // namespace midair::haptics
