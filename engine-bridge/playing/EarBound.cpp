#include "engine-bridge/playing/EarBound.h"

#include "engine-bridge/playing/FieldBounds.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/base/text/Quantity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace midair::bridge
{

namespace
{

// Error of single precision, relative to the pressure of all transducers in phase.
constexpr double kSumError = 1e-5;

// True if both produce the same sound everywhere.
bool areAlike(const haptics::TransducerArray& a, const haptics::TransducerArray& b)
{
    return a.size() == b.size() && a.frequency_Hz == b.frequency_Hz &&
           a.heardAmplitude_Pa_m() == b.heardAmplitude_Pa_m() && a.directivity == b.directivity &&
           a.board == b.board && a.gain.size() == b.gain.size() && a.gain == b.gain &&
           a.phaseOffset_rad.size() == b.phaseOffset_rad.size() &&
           a.phaseOffset_rad == b.phaseOffset_rad && a.positions == b.positions &&
           a.normals == b.normals && a.reflectors == b.reflectors;
}

Eigen::Matrix3Xd joined(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b)
{
    Eigen::Matrix3Xd all(3, a.cols() + b.cols());
    all << a, b;
    return all;
}

} // namespace

bool readPlaces(const std::string& text, Eigen::Matrix3Xd& places)
{
    std::vector<std::array<double, 3>> read;
    if (!base::parsePlaces(text, read)) return false;
    places.resize(3, static_cast<Eigen::Index>(read.size()));
    for (std::size_t l = 0; l < read.size(); ++l)
        places.col(static_cast<Eigen::Index>(l)) = Eigen::Vector3d::Map(read[l].data());
    return true;
}

EarBound::EarBound(double limit_dB, std::shared_ptr<haptics::Exposure> exposure) :
    _limit_dB(limit_dB),
    _limit_Pa(std::sqrt(haptics::meanSquareOf_Pa2(limit_dB))),
    _exposure(std::move(exposure))
{
}

// Peak pressures at the loudest spot of each place (n), for any combination of the array's parts.
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

void EarWatch::setPlace(const haptics::TransducerArray& array,
                        const haptics::Medium& medium,
                        const Eigen::Matrix3Xd& places)
{
    const bool areSame =
        areAlike(array, _array) && places.cols() == _places.cols() && places == _places;
    if (areSame && medium == _medium) return;
    if (areSame && _exposure)
    {
        _medium = medium;
        _exposure->setMedium(medium);
        return;
    }
    _array = array;
    _medium = medium;
    _places = places;
    _exposure.reset();
    _bound.reset();
}

void EarWatch::setLimit(double limit_dB)
{
    _limit_dB = limit_dB;
    _bound.reset();
}

bool EarWatch::isUnmoved(const Eigen::Matrix3Xd& ears) const
{
    if (ears.cols() != _ears.cols()) return false;
    return ears.cols() == 0 || (ears - _ears).colwise().norm().maxCoeff() <= kTolerance_m;
}

void EarWatch::setEars(const Eigen::Matrix3Xd& ears)
{
    const Eigen::Matrix3Xd known = ears.allFinite() ? ears : Eigen::Matrix3Xd(3, 0);
    if (isUnmoved(known)) return;
    const bool isAlike = known.cols() == _ears.cols();
    _ears = known;
    if (!isAlike)
    {
        _exposure.reset();
        _bound.reset();
    }
    if (!_exposure) return;
    const Eigen::Index first = unnamed();
    for (Eigen::Index l = 0; l < _ears.cols(); ++l)
        _exposure->move(first + l, _ears.col(l));
}

// Order: the places around the array, the ears, the user's places.
void EarWatch::listen()
{
    if (_exposure) return;
    const Eigen::Matrix3Xd around = joined(haptics::placesAround(_array, kAround), _ears);
    _exposure = std::make_shared<haptics::Exposure>(_array, _medium, joined(around, _places));
}

Eigen::Index EarWatch::unnamed() const
{
    return _exposure->size() - _ears.cols() - _places.cols();
}

const EarBound* EarWatch::bound()
{
    if (!(_limit_dB > 0.0)) return nullptr;
    listen();
    if (!_bound) _bound = std::make_unique<EarBound>(_limit_dB, _exposure);
    return _bound.get();
}

void EarWatch::play(const std::vector<Eigen::VectorXcf>& fields, double now_s)
{
    const bool isNothing = isSilent(fields);
    // Silence before the first sound needs no places; later silence counts.
    if (isNothing && !_exposure && _meter.read(now_s).places == 0) return;
    listen();
    _meter.play(now_s,
                _exposure->places(),
                isNothing ? Eigen::VectorXd::Zero(_exposure->size()).eval()
                          : _exposure->heard_Pa2(fields),
                unnamed());
}

haptics::ExposureFigures EarWatch::reading(double now_s) const
{
    haptics::ExposureFigures figures = _meter.read(now_s);
    figures.limit_dB = _limit_dB;
    return figures;
}

} // namespace midair::bridge
