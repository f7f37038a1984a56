#include "engine-bridge/playing/EarWatch.h"

#include "engine-bridge/playing/PressureCap.h"

namespace midair::bridge
{

namespace
{

// True if both sound alike at any place.
bool areAlike(const haptics::TransducerArray& a, const haptics::TransducerArray& b)
{
    return a.size() == b.size() && a.frequency_Hz == b.frequency_Hz &&
           a.heardAmplitude_Pa_m() == b.heardAmplitude_Pa_m() && a.directivity == b.directivity &&
           a.board == b.board && a.gain.size() == b.gain.size() && a.gain == b.gain &&
           a.phaseOffset_rad.size() == b.phaseOffset_rad.size() &&
           a.phaseOffset_rad == b.phaseOffset_rad && a.positions == b.positions &&
           a.normals == b.normals;
}

Eigen::Matrix3Xd joined(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b)
{
    Eigen::Matrix3Xd all(3, a.cols() + b.cols());
    all << a, b;
    return all;
}

} // namespace

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
    const Eigen::Index first = _exposure->size() - _ears.cols();
    for (Eigen::Index l = 0; l < _ears.cols(); ++l)
        _exposure->move(first + l, _ears.col(l));
}

void EarWatch::listen()
{
    if (_exposure) return;
    const Eigen::Matrix3Xd around = joined(haptics::placesAround(_array, kAround), _places);
    _exposure = std::make_shared<haptics::Exposure>(_array, _medium, joined(around, _ears));
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
    // Silence before all sound needs no places; after it, it counts.
    if (isNothing && !_exposure && _meter.read(now_s).places == 0) return;
    listen();
    _meter.play(now_s,
                _exposure->places(),
                isNothing ? Eigen::VectorXd::Zero(_exposure->size()).eval()
                          : _exposure->heard_Pa2(fields));
}

haptics::ExposureFigures EarWatch::reading(double now_s) const
{
    haptics::ExposureFigures figures = _meter.read(now_s);
    figures.limit_dB = _limit_dB;
    return figures;
}

} // namespace midair::bridge
