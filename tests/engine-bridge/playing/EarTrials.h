#pragma once

#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/EarBound.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/base/Limits.h"
#include "tests/engine-bridge/pipeline/DoubleField.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <random>
#include <vector>

/// Random drives of an array whose boards hide nothing from the places, held to an ear limit, and
/// looked at by brute force: the model's sum in double precision for what is played.
class EarTrials
{
public:
    /// What came of one drive.
    struct Outcome
    {
        double limit_dB = 0.0;
        double before_dB = 0.0;  ///< the loudest field at the loudest place, without the limit
        double loudest_dB = 0.0; ///< with it
        double factor = 1.0;
        bool isModulated = false;
    };

    EarTrials(const midair::haptics::TransducerArray& array, unsigned int seed, int places) :
        _array(array),
        _random(seed),
        _places(before(places, 0.3, 0.9)),
        _exposure(
            std::make_shared<midair::haptics::Exposure>(array, midair::haptics::Medium(), _places))
    {
    }

    Outcome next()
    {
        using namespace midair;
        haptics::FieldSequence sequence;
        const int kind = whole(0, 5);
        const int count = kind == 0 ? 3 : 1;
        for (int k = 0; k < count; ++k)
            sequence.fields.push_back(kind < 3 ? focus(kind == 1) : speckle(kind == 3));
        Outcome outcome;
        outcome.isModulated = whole(0, 1) == 1;
        outcome.before_dB = loudest_dB(sequence, {1.0});
        outcome.limit_dB = std::max(
            base::kLeastEarLimit_dB,
            outcome.before_dB + std::uniform_real_distribution<double>(-25.0, 9.0)(_random));
        const bridge::EarBound bound(outcome.limit_dB, _exposure);
        const Eigen::Matrix3Xd nowhere(3, 0);
        const haptics::Medium medium;
        bridge::CappedPlaces where{nowhere, {&_array}, medium, outcome.isModulated};
        where.ears = &bound;
        device::DriveAbility ability;
        outcome.factor =
            bridge::PressureCap(base::kMostPressure_Pa, played, ability).hold(where, sequence);
        outcome.loudest_dB =
            loudest_dB(sequence,
                       outcome.isModulated
                           ? std::vector<double>{1.0, 0.93, 0.8, 0.64, 0.5, 0.31, 0.2, 0.1, 0.04}
                           : std::vector<double>{1.0});
        return outcome;
    }

private:
    static Eigen::VectorXcf played(const midair::device::DriveSignal& signal)
    {
        std::vector<std::complex<float>> q;
        midair::device::decode(signal, q);
        return Eigen::Map<Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size()));
    }

    int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(_random); }

    /// Places in front of the array's middle.
    Eigen::Matrix3Xd before(int count, double near_m, double far_m)
    {
        std::uniform_real_distribution<double> across(-0.4, 0.4);
        std::uniform_real_distribution<double> off(near_m, far_m);
        const Eigen::Vector3d middle = _array.positions.rowwise().mean();
        const Eigen::Vector3d normal = _array.normals.col(0);
        const Eigen::Vector3d u = normal.unitOrthogonal();
        Eigen::Matrix3Xd places(3, count);
        for (int l = 0; l < count; ++l)
            places.col(l) = middle + off(_random) * normal + across(_random) * u +
                            across(_random) * normal.cross(u);
        return places;
    }

    /// All in phase at a point in the workspace, or at an ear.
    Eigen::VectorXcf focus(bool atEar)
    {
        const Eigen::Vector3d at =
            atEar ? Eigen::Vector3d(_places.col(whole(0, static_cast<int>(_places.cols()) - 1)))
                  : Eigen::Vector3d(before(1, 0.1, 0.2));
        const double k = 2.0 * M_PI * _array.frequency_Hz / midair::haptics::Medium().soundSpeed();
        const bool isEven = whole(0, 1) == 0;
        std::uniform_real_distribution<double> amplitude(0.0, 1.0);
        Eigen::VectorXcf q(_array.size());
        for (Eigen::Index i = 0; i < q.size(); ++i)
        {
            const double offset =
                _array.phaseOffset_rad.size() > 0 ? _array.phaseOffset_rad[i] : 0.0;
            q[i] =
                std::complex<float>(std::polar(isEven ? 1.0 : amplitude(_random),
                                               k * (at - _array.positions.col(i)).norm() - offset));
        }
        return q;
    }

    Eigen::VectorXcf speckle(bool isEven)
    {
        std::uniform_real_distribution<float> phase(0.0f, 6.28f);
        std::uniform_real_distribution<float> amplitude(0.0f, 1.0f);
        Eigen::VectorXcf q(_array.size());
        for (std::complex<float>& one : q)
            one = std::polar(isEven ? 0.7f : amplitude(_random), phase(_random));
        return q;
    }

    /// The loudest of the fields as 8-bit duties, at \a gains of their amplitudes, in dB.
    double loudest_dB(const midair::haptics::FieldSequence& sequence,
                      const std::vector<double>& gains) const
    {
        double most_Pa = 0.0;
        for (const Eigen::VectorXcf& q : sequence.fields)
        {
            midair::device::DriveSignal signal;
            midair::device::DriveSignal lower;
            midair::device::encode(q.data(), static_cast<int>(q.size()), signal);
            for (const double gain : gains)
            {
                midair::device::scaleDuties(signal, gain, lower);
                most_Pa = std::max(
                    most_Pa,
                    loudestInDouble(_places, _array, midair::haptics::Medium(), played(lower)));
            }
        }
        most_Pa *= earFactor(_array);
        return midair::haptics::soundLevel_dB(0.5 * most_Pa * most_Pa);
    }

    midair::haptics::TransducerArray _array;
    std::mt19937 _random;
    Eigen::Matrix3Xd _places;
    std::shared_ptr<midair::haptics::Exposure> _exposure;
};
