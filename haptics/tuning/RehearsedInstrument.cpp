#include "haptics/tuning/RehearsedInstrument.h"

#include "haptics/base/DutyLaw.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

constexpr int kWalls = 3;
constexpr double kNearestWall_m = 0.3; // from the microphone
constexpr double kFarthestWall_m = 0.8;

Eigen::Vector3d direction(std::mt19937& random)
{
    std::normal_distribution<double> normal;
    const double x = normal(random), y = normal(random), z = normal(random);
    return Eigen::Vector3d(x, y, z).normalized();
}

void check(const TransducerArray& array, const TuningPlan& plan, const RehearsalOptions& options)
{
    plan.requireFor(array);
    std::string error;
    if (!base::RangeCheck("rehearsal's ")
             .within("detuning_Hz", options.detuning_Hz, 0.0, 20e3)
             .within("reversed", options.reversed, 0.0, 1.0)
             .within("dead", options.dead, 0.0, 1.0)
             .within("gainSpread", options.gainSpread, 0.0, 0.3)
             .within("placeError_m", options.placeError_m, 0.0, 0.1)
             .within("displacement_m", options.displacement_m, 0.0, 0.1)
             .within("temperature_C", options.temperature_C, -40.0, 60.0)
             .within("noise_dB", options.noise_dB, -300.0, 100.0)
             .within("reflections_dB", options.reflections_dB, -300.0, 20.0)
             .atLeast("clip", options.clip, 0.0)
             .above("sensitivity", options.sensitivity, 0.0)
             .passed(&error))
        throw base::InputError(error);
}

} // namespace

RehearsedInstrument::RehearsedInstrument(const TransducerArray& array,
                                         const TuningPlan& plan,
                                         const RehearsalOptions& options) :
    _plan(plan),
    _options(options),
    _truth(array),
    _places(plan.places),
    _random(options.seed)
{
    check(array, plan, options);
    hideErrors();
    std::normal_distribution<double> normal(0.0, options.placeError_m / std::sqrt(3.0));
    for (Eigen::Index p = 0; p < _places.cols(); ++p)
    {
        Eigen::Vector3d off = options.displacement_m * direction(_random);
        if (options.displacement_m == 0.0)
            for (double& coordinate : off)
                coordinate = normal(_random);
        _places.col(p) += off;
    }
    _mirrors.resize(3, 2 * kWalls);
    std::uniform_real_distribution<double> distance(kNearestWall_m, kFarthestWall_m);
    for (Eigen::Index wall = 0; wall < kWalls; ++wall)
    {
        const Eigen::Vector3d n = direction(_random);
        _mirrors.col(2 * wall) = plan.places.col(0) + distance(_random) * n;
        _mirrors.col(2 * wall + 1) = n;
    }
}

void RehearsedInstrument::hideErrors()
{
    const int m = _truth.size();
    _truth.phaseOffset_rad.setZero(m);
    _truth.gain.setOnes(m);
    _reversed.assign(static_cast<std::size_t>(m), false);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    std::vector<int> dead = _truth.dead;
    for (int i = 0; i < m; ++i)
    {
        const double detuning = _options.detuning_Hz * normal(_random);
        const double phase = std::atan(2.0 * kRehearsedQuality * detuning / _truth.frequency_Hz);
        const double own = std::max(0.2, 1.0 + _options.gainSpread * normal(_random));
        const bool isReversed = chance(_random) < _options.reversed;
        _reversed[static_cast<std::size_t>(i)] = isReversed;
        _truth.phaseOffset_rad[i] = phase + (isReversed ? base::kPi : 0.0);
        _truth.gain[i] = own * std::cos(phase);
        if (chance(_random) < _options.dead) dead.push_back(i);
    }
    _truth.setDead(dead);
}

// Reflections are the signals of point sources at the microphone's mirror images in the walls;
// their rms is scaled to the option.
void RehearsedInstrument::standAt(int place)
{
    _place = place;
    Medium medium;
    medium.temperature_C = _options.temperature_C;
    const Eigen::Vector3d at = _places.col(place);
    _heard = referencePropagationMatrix(at, _truth, medium).row(0).transpose();
    std::vector<double> loud;
    for (const std::complex<double> p_Pa : _heard)
        if (std::abs(p_Pa) > 0.0) loud.push_back(std::abs(p_Pa));
    _noise_Pa = std::pow(10.0, _options.noise_dB / 20.0) * base::percentile(loud, 0.5);

    TransducerArray points = _truth;
    points.directivity = Directivity::POINT;
    Eigen::VectorXcd reflected = Eigen::VectorXcd::Zero(_truth.size());
    for (Eigen::Index wall = 0; wall < kWalls; ++wall)
    {
        const Eigen::Vector3d n = _mirrors.col(2 * wall + 1);
        const Eigen::Vector3d image = at - 2.0 * (at - _mirrors.col(2 * wall)).dot(n) * n;
        reflected += referencePropagationMatrix(image, points, medium).row(0).transpose();
    }
    if (reflected.norm() > 0.0)
        _heard += reflected * (std::pow(10.0, _options.reflections_dB / 20.0) * _heard.norm() /
                               reflected.norm());
    // Common phase of cables and clock, different for each place.
    _heard *= std::polar(1.0, 2.0 + 1.7 * place);
}

std::complex<double> RehearsedInstrument::reading(int row, const TransducerArray* tuned)
{
    const TuningRow& planned = _plan.rows.at(static_cast<std::size_t>(row));
    if (planned.place != _place) standAt(planned.place);
    const TuningDrive drive = driveOf(_plan, planned, tuned);
    std::complex<double> p_Pa = 0.0;
    for (std::size_t i = 0; i < drive.duty.size(); ++i)
        if (drive.duty[i] > 0)
            p_Pa += _heard[static_cast<Eigen::Index>(i)] *
                    std::polar(base::dutyAmplitude(drive.duty[i]),
                               base::kTwoPi * drive.phase[i] / 256.0);
    std::seed_seq seeds{_options.seed, static_cast<std::uint32_t>(row)};
    std::mt19937 random(seeds);
    std::normal_distribution<double> noise(0.0, _noise_Pa / std::sqrt(2.0));
    const double re = noise(random), im = noise(random);
    p_Pa += std::complex<double>(re, im);
    if (_options.clip > 0.0 && std::abs(p_Pa) > _options.clip)
        p_Pa *= _options.clip / std::abs(p_Pa);
    p_Pa *= _options.sensitivity;
    return needsPhases(_plan.method) ? p_Pa : std::complex<double>(std::abs(p_Pa), 0.0);
}

} // namespace midair::haptics
