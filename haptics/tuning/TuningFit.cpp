#include "haptics/tuning/TuningFit.h"

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kMostDeadGain = 0.4; // three times the error may raise the limit to this
constexpr double kMostUnsure = 0.2;   // of the transducers

/// Responses of the transducers without distance and directivity.
class Fitter
{
public:
    Fitter(const TransducerArray& array,
           const TuningPlan& plan,
           const TuningReadings& readings,
           const TuningFitOptions& options) :
        _array(array),
        _plan(plan),
        _options(options)
    {
        Medium medium;
        medium.temperature_C = options.prior.temperature_C;
        medium.relativeHumidity = options.relativeHumidity;
        _beta = medium.attenuation(array.frequency_Hz);
        Eigen::MatrixXd expected(plan.places.cols(), array.size());
        for (Eigen::Index p = 0; p < expected.rows(); ++p)
            for (Eigen::Index i = 0; i < expected.cols(); ++i)
                expected(p, i) = way(plan.places.col(p), i);
        _responses = responsesOf(plan, readings, expected, options.clip);
        _fit.notes = readings.notes();
        _fit.notes.insert(_fit.notes.end(), _responses.notes.begin(), _responses.notes.end());
        _fit.refusal = _responses.refusal;
    }

    TuningFit run()
    {
        if (!_fit.usable()) return std::move(_fit);
        combine(_plan.places, 0.0, {}); // amplitudes only
        const std::vector<bool> live = liveOnes();
        _fit.microphone = fitMicrophone(_array, _plan.places, _responses, live, _options.prior);
        _fit.refusal = _fit.microphone.refusal;
        if (!_fit.usable())
        {
            _responses.y = _responses.y.conjugate().eval();
            if (fitMicrophone(_array, _plan.places, _responses, live, _options.prior)
                    .refusal.empty())
                _fit.refusal = "the phases agree with the opposite sign: the instrument uses e^{-j "
                               "omega t} instead of e^{+j omega t}; change the sign of im";
            return std::move(_fit);
        }
        const MicrophoneFit& microphone = _fit.microphone;
        combine(microphone.places,
                base::kTwoPi * _array.frequency_Hz / microphone.soundSpeed_m_s,
                microphone.phase_rad);
        judge();
        if (_fit.usable()) writeArray();
        if (_fit.usable()) tellSpreads();
        return std::move(_fit);
    }

private:
    // D/R e^{-beta R}, the amplitude at a place of a transducer of gain 1.
    double way(const Eigen::Vector3d& place, Eigen::Index i) const
    {
        const Eigen::Vector3d d = place - _array.positions.col(i);
        const double R = std::max(d.norm(), kNearestDistance_m);
        const double cosTheta = std::clamp(d.dot(_array.normals.col(i)) / R, -1.0, 1.0);
        return directivity(_array.directivity, cosTheta) / R * std::exp(-_beta * R);
    }

    /// Sets _h to each transducer's gain and phase: the mean over places of y/(C g), weighted with
    /// |g|^2, the inverse variance for uniform noise. C is a factor per place: its median
    /// amplitude, its phase and, if \a phase_rad is given, its polarity.
    void combine(const Eigen::Matrix3Xd& places, double k, const Eigen::VectorXd& phase_rad)
    {
        const Eigen::Index m = _array.size(), P = places.cols();
        const bool hasPhases = phase_rad.size() > 0;
        Eigen::VectorXcd sum = Eigen::VectorXcd::Zero(m);
        Eigen::VectorXd weights = Eigen::VectorXd::Zero(m), square = weights;
        for (Eigen::Index p = 0; p < P; ++p)
        {
            Eigen::VectorXcd h(m);
            Eigen::VectorXd g(m);
            std::vector<double> amplitudes;
            for (Eigen::Index i = 0; i < m; ++i)
            {
                g[i] = std::max(1e-9, way(places.col(p), i));
                const double R = (places.col(p) - _array.positions.col(i)).norm();
                const std::complex<double> y = _responses.y(p, i) / g[i];
                h[i] = hasPhases ? y * std::polar(1.0, k * R - phase_rad[p]) : std::abs(y);
                if (std::isfinite(h[i].real())) amplitudes.push_back(std::abs(h[i]));
            }
            double C = base::percentile(amplitudes, 0.5);
            if (p > 0 && (h.array().isFinite())
                                 .select(h.array() * sum.array().conjugate(), 0.0)
                                 .sum()
                                 .real() < 0.0)
                C = -C;
            for (Eigen::Index i = 0; i < m; ++i)
            {
                if (!std::isfinite(h[i].real())) continue;
                sum[i] += g[i] * g[i] * h[i] / C;
                weights[i] += g[i] * g[i];
                square[i] += std::pow(g[i] * _responses.noise[p] / C, 2.0);
            }
        }
        _h = sum.cwiseQuotient(weights.cast<std::complex<double>>());
        _fit.gainErrors = square.cwiseSqrt().cwiseQuotient(weights);
    }

    double deadBelow(Eigen::Index i) const
    {
        return std::max(_options.deadGain, std::min(kMostDeadGain, 3.0 * _fit.gainErrors[i]));
    }

    std::vector<bool> liveOnes() const
    {
        std::vector<bool> live;
        for (Eigen::Index i = 0; i < _h.size(); ++i)
            live.push_back(std::abs(_h[i]) >= deadBelow(i)); // false for NaN
        return live;
    }

    // Determines states, and the common phase: the mean of the doubled phases is 0, and most are
    // not reversed.
    void judge()
    {
        _fit.states.assign(static_cast<std::size_t>(_h.size()), TransducerState::NOT_MEASURED);
        const std::vector<bool> live = liveOnes();
        std::complex<double> doubled = 0.0;
        std::vector<double> gains;
        for (Eigen::Index i = 0; i < _h.size(); ++i)
            if (live[static_cast<std::size_t>(i)])
            {
                doubled += _h[i] * _h[i] / std::abs(_h[i]);
                gains.push_back(std::abs(_h[i]));
            }
        std::complex<double> common = std::polar(1.0, 0.5 * std::arg(doubled));
        double majority = 0.0;
        for (Eigen::Index i = 0; i < _h.size(); ++i)
            if (live[static_cast<std::size_t>(i)])
                majority += (_h[i] * std::conj(common)).real() < 0.0 ? -1.0 : 1.0;
        if (majority < 0.0) common = -common;
        const double median = base::percentile(gains, 0.5);
        _h *= std::conj(common) / median;
        _fit.gainErrors /= median;
        for (Eigen::Index i = 0; i < _h.size(); ++i)
        {
            TransducerState& state = _fit.states[static_cast<std::size_t>(i)];
            if (!std::isfinite(_h[i].real())) continue;
            const bool isUnsure = 3.0 * _fit.gainErrors[i] > kMostDeadGain;
            if (!live[static_cast<std::size_t>(i)])
                state = isUnsure ? TransducerState::UNSURE : TransducerState::DEAD;
            else if (isUnsure)
                state = TransducerState::UNSURE;
            else
                state = _h[i].real() < 0.0 ? TransducerState::REVERSED : TransducerState::FINE;
        }
        for (const int i : _array.dead)
            _fit.states[static_cast<std::size_t>(i)] = TransducerState::DEAD;
        const std::size_t unsure = _fit.of(TransducerState::UNSURE).size();
        if (double(unsure) > kMostUnsure * double(_h.size()))
            _fit.refusal = fmt::format("{} of {} transducers are lost in noise: use a longer "
                                       "--integrate, the method hadamard, or more places",
                                       unsure,
                                       _h.size());
    }

    void writeArray()
    {
        TransducerArray& array = _fit.array = _array;
        const Eigen::Index m = _h.size();
        if (array.phaseOffset_rad.size() == 0) array.phaseOffset_rad.setZero(m);
        if (array.gain.size() == 0) array.gain.setOnes(m);
        for (Eigen::Index i = 0; i < m; ++i)
        {
            const TransducerState state = _fit.states[static_cast<std::size_t>(i)];
            if (state == TransducerState::NOT_MEASURED || state == TransducerState::DEAD) continue;
            array.phaseOffset_rad[i] = std::arg(_h[i]);
            array.gain[i] = std::abs(_h[i]);
        }
        array.setDead(_fit.of(TransducerState::DEAD));
        for (const int i : array.dead)
            array.phaseOffset_rad[i] = 0.0;
    }

    void tellSpreads()
    {
        const MicrophoneFit& microphone = _fit.microphone;
        const Eigen::VectorXd before = _array.phaseOffset_rad.size() > 0
                                           ? _array.phaseOffset_rad
                                           : Eigen::VectorXd::Zero(_array.size());
        double phases = 0.0, gains = 0.0, gainSum = 0.0, all = 0.0;
        std::complex<double> focus = 0.0;
        int count = 0;
        for (Eigen::Index i = 0; i < _h.size(); ++i)
        {
            const TransducerState state = _fit.states[static_cast<std::size_t>(i)];
            if (state != TransducerState::FINE && state != TransducerState::REVERSED) continue;
            ++count;
            phases += std::pow(wrappedToHalfTurn(std::arg(_h[i])), 2.0);
            gainSum += std::abs(_h[i]);
            gains += std::norm(_h[i]);
            const double loud = way(microphone.places.col(0), i);
            focus += loud * _h[i] * std::polar(1.0, -before[i]);
            all += loud * std::abs(_h[i]);
        }
        if (count == 0) return;
        _fit.phaseSpread_rad = std::sqrt(phases / count);
        _fit.gainSpread = std::sqrt(std::max(0.0, gains / count - std::pow(gainSum / count, 2.0)));
        _fit.focusBefore = std::abs(focus) / all;
        // Each parameter shared by all places absorbs its part of the spread.
        const double P = double(microphone.places.cols());
        _fit.expectedError_rad = std::sqrt(5.0 * std::pow(_fit.phaseSpread_rad, 2.0) / count +
                                           std::pow(microphone.scatter_rad, 2.0) / P);
    }

    const TransducerArray& _array;
    const TuningPlan& _plan;
    const TuningFitOptions& _options;
    TuningResponses _responses;
    double _beta = 0.0;  ///< Np/m
    Eigen::VectorXcd _h; ///< m, NaN: not measured
    TuningFit _fit;
};

void check(const TransducerArray& array, const TuningPlan& plan, const TuningFitOptions& options)
{
    if (array.size() != plan.transducers)
        throw base::InputError(
            fmt::format("the plan is for the {} transducers of array \"{}\", array \"{}\" has {}",
                        plan.transducers,
                        plan.array,
                        array.name,
                        array.size()));
    if (plan.method == TuningMethod::FOCUS)
        throw base::InputError("the plan is one of foci, for \"midair-tune check\"; fit needs the "
                               "method single, hadamard or levels");
    std::string error;
    if (!base::RangeCheck()
             .within("search_m", options.prior.search_m, 0.0, 0.05)
             .within("temperature", options.prior.temperature_C, -40.0, 60.0)
             .within("temperatureError", options.prior.temperatureError_C, 0.0, 50.0)
             .within("relativeHumidity", options.relativeHumidity, 0.0, 1.0)
             .within("deadGain", options.deadGain, 0.01, 0.5)
             .atLeast("clip", options.clip, 0.0)
             .passed(&error))
        throw base::InputError(error);
}

double temperatureOf(double soundSpeed_m_s)
{
    // c = 331.3 sqrt(1 + T/273.15)
    return base::kZeroCelsius_K * (std::pow(soundSpeed_m_s / 331.3, 2.0) - 1.0);
}

std::string listed(const std::vector<int>& which)
{
    return which.empty() ? std::string() : ": " + rangesText(which);
}

std::string shiftText(const Eigen::Vector3d& error_m)
{
    return fmt::format(
        "note        a uniform phase gradient across the array looks like a displaced microphone,\n"
        "            so phases are known up to a shift of the whole field: about {:.2f}, {:.2f}, "
        "{:.2f} mm in x, y, z\n"
        "            from the transducers' own spread, and more where warm air tilts the phases.\n"
        "            midair-calibrate corrects such a shift, from where the field is felt.\n",
        1e3 * error_m.x(),
        1e3 * error_m.y(),
        1e3 * error_m.z());
}

std::string placesText(const MicrophoneFit& microphone)
{
    std::string text;
    auto out = std::back_inserter(text);
    for (Eigen::Index p = 0; p < microphone.places.cols(); ++p)
        fmt::format_to(out,
                       "place {:<6}({:.5f}, {:.5f}, {:.5f}) m, +- {:.2f}, {:.2f}, {:.2f} mm\n",
                       p,
                       microphone.places(0, p),
                       microphone.places(1, p),
                       microphone.places(2, p),
                       1e3 * microphone.placeErrors(0, p),
                       1e3 * microphone.placeErrors(1, p),
                       1e3 * microphone.placeErrors(2, p));
    fmt::format_to(out,
                   "sound       {:.2f} +- {:.2f} m/s, as at {:.1f} C\n",
                   microphone.soundSpeed_m_s,
                   microphone.soundSpeedError_m_s,
                   temperatureOf(microphone.soundSpeed_m_s));
    return text;
}

} // namespace

std::vector<int> TuningFit::of(TransducerState state) const
{
    std::vector<int> which;
    for (std::size_t i = 0; i < states.size(); ++i)
        if (states[i] == state) which.push_back(static_cast<int>(i));
    return which;
}

TuningFit fitTuning(const TransducerArray& array,
                    const TuningPlan& plan,
                    const TuningReadings& readings,
                    const TuningFitOptions& options)
{
    check(array, plan, options);
    return Fitter(array, plan, readings, options).run();
}

std::string TuningFit::text() const
{
    std::string text;
    for (const std::string& note : notes)
        text += "note        " + note + "\n";
    if (!usable()) return text + "refused     " + refusal + "\n";
    auto out = std::back_inserter(text);
    const auto reversed = of(TransducerState::REVERSED), dead = of(TransducerState::DEAD);
    const auto unsure = of(TransducerState::UNSURE), none = of(TransducerState::NOT_MEASURED);
    fmt::format_to(out,
                   "array       {}, {} transducers: {} fine, {} reversed, {} dead{}\n",
                   array.name,
                   array.size(),
                   of(TransducerState::FINE).size(),
                   reversed.size(),
                   dead.size(),
                   listed(dead));
    if (!unsure.empty())
        fmt::format_to(out, "unsure      {} in too much noise{}\n", unsure.size(), listed(unsure));
    if (!none.empty())
        fmt::format_to(out,
                       "unmeasured  {}, which keep what the array's file says{}\n",
                       none.size(),
                       listed(none));
    fmt::format_to(out,
                   "spread      phases {:.1f} degrees (polarity aside), gains {:.1f} %\n",
                   base::toDegrees(phaseSpread_rad),
                   100.0 * gainSpread);
    text += placesText(microphone);
    if (microphone.places.cols() > 1)
        fmt::format_to(out,
                       "residual    {:.1f} degrees rms between places; expected error of a phase "
                       "{:.1f} degrees\n",
                       base::toDegrees(microphone.scatter_rad),
                       base::toDegrees(expectedError_rad));
    else
        fmt::format_to(out,
                       "residual    not known from one place: reflections look like phases of "
                       "transducers; expected error\n            {:.1f} degrees without them. Four "
                       "places 5 cm apart halve their effect.\n",
                       base::toDegrees(expectedError_rad));
    fmt::format_to(out,
                   "focus       {:.3f} of what the same transducers can do, before these offsets\n",
                   focusBefore);
    return text + shiftText(microphone.shiftError);
}

} // namespace midair::haptics
