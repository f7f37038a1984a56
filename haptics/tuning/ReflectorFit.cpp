#include "haptics/tuning/ReflectorFit.h"

#include "haptics/array/Medium.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Range.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/tuning/TuningResponses.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr int kPlateUnknowns = 5; // unknowns of the reflector: shift, two tilts, reflection, phase
constexpr int kPlatePhase = 4;    // of them
constexpr double kPlateReadingError =
    0.05;                              // rms, over the rms of the readings, before a tuned array
constexpr int kPlateTransducers = 60;  // transducers that choose among the starts
constexpr int kPlateStarts = 12;       // to each side of the guess
constexpr int kPlateSlips = 4;         // eighths of a wavelength
constexpr int kPlateRefined = 6;       // starts that are refined
constexpr int kPlateSteps = 40;        // most steps of each
constexpr double kPlateTiltStep = 0.5; // of the wavelength over half of the size, for starts

/// What is unknown. Vectors hold shift (m), tilts (rad), reflection, its phase (rad), the places'
/// errors (m) and that of the temperature (K), in this order.
struct PlateUnknowns
{
    double shift_m = 0.0, tiltAlong = 0.0, tiltAcross = 0.0, reflection = 0.5, phase_rad = 0.0;
    Eigen::Matrix3Xd places;
    double temperature_C = 20.0;

    int count() const { return kPlateUnknowns + 3 * static_cast<int>(places.cols()) + 1; }
    double& at(int k)
    {
        double* const own[] = {&shift_m, &tiltAlong, &tiltAcross, &reflection, &phase_rad};
        if (k < kPlateUnknowns) return *own[k];
        k -= kPlateUnknowns;
        return k < places.size() ? places(k % 3, k / 3) : temperature_C;
    }
    /// Place of the microphone that unknown \a k belongs to; -1: all.
    int placeOf(int k) const
    {
        return k < kPlateUnknowns || k + 1 == count() ? -1 : (k - kPlateUnknowns) / 3;
    }
};

Reflector movedPlate(const Reflector& guess, const PlateUnknowns& by)
{
    Reflector result = guess;
    const Eigen::Vector3d across = guess.across();
    result.position += by.shift_m * guess.normal;
    result.normal =
        (guess.normal + by.tiltAcross * guess.along - by.tiltAlong * across).normalized();
    result.along = (guess.along - guess.along.dot(result.normal) * result.normal).normalized();
    result.reflection = std::clamp(by.reflection, 0.0, 1.0);
    result.reflectionPhase_rad = std::remainder(by.phase_rad, base::kTwoPi);
    return result;
}

// Half of the size over which a tilt counts; that of the array for planes without end.
double plateHalfSize(const Reflector& guess, const TransducerArray& array)
{
    const double size_m = guess.size_m.maxCoeff();
    if (std::isfinite(size_m)) return 0.5 * size_m;
    const Eigen::Vector3d low = array.positions.rowwise().minCoeff(),
                          high = array.positions.rowwise().maxCoeff();
    return 0.5 * (high - low).norm();
}

/// What a refinement looks at and changes.
struct PlateScope
{
    std::vector<std::size_t> places; ///< of the microphone, whose readings count
    bool hasReflector = true;        ///< changes shift, tilts, reflection and its phase
    bool hasAir = true;              ///< changes the temperature

    bool isFree(const PlateUnknowns& at, int k) const
    {
        if (k < kPlateUnknowns) return hasReflector;
        if (k + 1 == at.count()) return hasAir;
        const auto place = static_cast<std::size_t>(at.placeOf(k));
        return std::find(places.begin(), places.end(), place) != places.end();
    }
};

/// Sums of least squares.
struct PlateSums
{
    Eigen::MatrixXd JJ;
    Eigen::VectorXd Jr;
    double sum = 0.0; // of squares
};

class PlateFitter
{
public:
    PlateFitter(const TransducerArray& tuned,
                const TuningPlan& plan,
                const Reflector& guess,
                const ReflectorFitOptions& options) :
        _array(tuned),
        _guess(guess),
        _options(options),
        _half_m(plateHalfSize(guess, tuned)),
        _planned(plan.places)
    {
        _array.reflectors.push_back(guess);
    }

    ReflectorFit run(TuningResponses responses, std::vector<std::string> notes)
    {
        ReflectorFit fit;
        fit.notes = std::move(notes);
        fit.notes.insert(fit.notes.end(), responses.notes.begin(), responses.notes.end());
        fit.refusal = responses.refusal;
        if (!fit.usable()) return fit;
        take(responses);
        const PlateUnknowns start = withoutReflector(responses, fit.refusal);
        if (!fit.usable()) return fit;
        PlateScope all;
        for (std::size_t p = 0; p < _y.size(); ++p)
            all.places.push_back(p);
        PlateScope bareScope = all;
        bareScope.hasReflector = false;
        PlateUnknowns bare = start;
        bare.reflection = 0.0;
        refine(bare, bareScope);
        fit.before = leftOf(bare, all);
        PlateUnknowns best = foundAtFirstPlace(start);
        for (std::size_t p = 1; p < _y.size(); ++p)
            findPlace(best, p);
        refine(best, all);
        fit.after = leftOf(best, all);
        if (!(fit.after < kWorthIt * fit.before))
        {
            fit.refusal = fmt::format("the readings are explained no better with the reflector, "
                                      "{:.1f} % of them is left over, than without it, {:.1f} %: "
                                      "it isn't there, reflects little, or is farther from its "
                                      "guess than {:.1f} mm and {:.1f} degrees",
                                      100.0 * fit.after,
                                      100.0 * fit.before,
                                      1e3 * _options.search_m,
                                      base::toDegrees(_options.tilt_rad));
            return fit;
        }
        tell(best, all, fit);
        return fit;
    }

private:
    static constexpr double kWorthIt = 0.9;

    // Keeps what was measured of transducers that play, each place at an rms of 1.
    void take(const TuningResponses& responses)
    {
        const Eigen::MatrixXcd& y = responses.y;
        _y.resize(static_cast<std::size_t>(y.rows()));
        _live.resize(_y.size());
        for (std::size_t p = 0; p < _y.size(); ++p)
        {
            const auto row = static_cast<Eigen::Index>(p);
            for (int i = 0; i < _array.size(); ++i)
                if (std::isfinite(y(row, i).real()) && std::isfinite(y(row, i).imag()) &&
                    gainOf(i) > 0.0)
                    _live[p].push_back(i);
            _y[p].resize(static_cast<Eigen::Index>(_live[p].size()));
            for (std::size_t k = 0; k < _live[p].size(); ++k)
                _y[p][static_cast<Eigen::Index>(k)] = y(row, _live[p][k]);
            const double rms = _y[p].norm() / std::sqrt(std::max<double>(1.0, _y[p].size()));
            if (rms > 0.0) _y[p] /= rms;
        }
    }

    double gainOf(int i) const { return _array.gain.size() > 0 ? _array.gain[i] : 1.0; }

    Medium airAt(double temperature_C) const
    {
        Medium medium;
        medium.temperature_C = temperature_C;
        medium.relativeHumidity = _options.relativeHumidity;
        return medium;
    }

    double wavelengthAt(double temperature_C) const
    {
        return airAt(temperature_C).wavelength(_array.frequency_Hz);
    }

    // Moves a place of the microphone away from the array, by eighths of a wavelength.
    void slip(PlateUnknowns& at, std::size_t p, int eighths) const
    {
        const Eigen::Vector3d ahead = _array.normals.rowwise().mean().normalized();
        at.places.col(static_cast<Eigen::Index>(p)) +=
            eighths * wavelengthAt(at.temperature_C) / 8.0 * ahead;
    }

    // The microphone's places from the direct sound alone, whose errors the reflected one blurs.
    PlateUnknowns withoutReflector(TuningResponses responses, std::string& refusal) const
    {
        std::vector<bool> live(static_cast<std::size_t>(_array.size()), false);
        for (const std::vector<int>& ones : _live)
            for (const int i : ones)
                live[static_cast<std::size_t>(i)] = true;
        for (int i = 0; i < _array.size(); ++i)
            if (gainOf(i) > 0.0 && _array.phaseOffset_rad.size() > 0)
                responses.y.col(i) *= std::polar(1.0 / gainOf(i), -_array.phaseOffset_rad[i]);
        const MicrophoneFit microphone =
            fitMicrophone(_array, _planned, responses, live, _options.prior);
        PlateUnknowns start;
        refusal = microphone.refusal;
        start.places = refusal.empty() ? microphone.places : _planned;
        start.temperature_C = _options.prior.temperature_C;
        return start;
    }

    /// Model of what one place hears of its transducers, at full drive.
    Eigen::VectorXcd heard(const PlateUnknowns& at, std::size_t p, std::size_t stride = 1) const
    {
        TransducerArray part;
        part.directivity = _array.directivity;
        part.frequency_Hz = _array.frequency_Hz;
        part.reflectors = _array.reflectors;
        part.reflectors.back() = movedPlate(_guess, at);
        const std::vector<int>& live = _live[p];
        const auto count = static_cast<Eigen::Index>((live.size() + stride - 1) / stride);
        part.positions.resize(3, count);
        part.normals.resize(3, count);
        part.gain.resize(count);
        part.phaseOffset_rad.resize(count);
        for (Eigen::Index k = 0; k < count; ++k)
        {
            const int i = live[static_cast<std::size_t>(k) * stride];
            part.positions.col(k) = _array.positions.col(i);
            part.normals.col(k) = _array.normals.col(i);
            part.gain[k] = gainOf(i);
            part.phaseOffset_rad[k] =
                _array.phaseOffset_rad.size() > 0 ? _array.phaseOffset_rad[i] : 0.0;
        }
        return referencePropagationMatrix(
                   at.places.col(static_cast<Eigen::Index>(p)), part, airAt(at.temperature_C))
            .row(0)
            .transpose();
    }

    // What the best factor c_p leaves of the readings of one place.
    static Eigen::VectorXcd left(const Eigen::VectorXcd& y, const Eigen::VectorXcd& h)
    {
        const double square = h.squaredNorm();
        return square > 0.0 ? Eigen::VectorXcd(y - h * (h.dot(y) / square)) : y;
    }

    double squareOf(const PlateUnknowns& at, const PlateScope& scope) const
    {
        double sum = priorOf(at);
        for (const std::size_t p : scope.places)
            sum += left(_y[p], heard(at, p)).squaredNorm();
        return sum;
    }

    /// A share of the sum of squares that is known beforehand, of one unknown.
    struct Prior
    {
        int unknown;
        double value, weight;
    };
    // The air's temperature, and the phase of the reflection, which the shift along the normal
    // nearly compensates. Their errors count like those of readings.
    std::array<Prior, 2> priors() const
    {
        const auto weight = [](double error)
        { return std::pow(kPlateReadingError / std::max(1e-3, error), 2.0); };
        const int temperature = kPlateUnknowns + 3 * static_cast<int>(_planned.cols());
        return {{{kPlatePhase, _guess.reflectionPhase_rad, weight(_options.phaseError_rad)},
                 {temperature,
                  _options.prior.temperature_C,
                  weight(_options.prior.temperatureError_C)}}};
    }

    double priorOf(PlateUnknowns at) const
    {
        double sum = 0.0;
        for (const Prior& prior : priors())
            sum += prior.weight * std::pow(at.at(prior.unknown) - prior.value, 2.0);
        return sum;
    }

    double readings(const PlateScope& scope) const
    {
        double count = 0.0;
        for (const std::size_t p : scope.places)
            count += static_cast<double>(_y[p].size());
        return std::max(1.0, count);
    }

    double leftOf(const PlateUnknowns& at, const PlateScope& scope) const
    {
        return std::sqrt(squareOf(at, scope) / readings(scope));
    }

    // The normal equations at \a at; what isn't free stays.
    PlateSums normalAt(PlateUnknowns at, const PlateScope& scope) const
    {
        constexpr double kPlaceStep = 1e-6, kStep = 1e-5;
        const int unknowns = at.count();
        PlateSums normal;
        normal.JJ = Eigen::MatrixXd::Identity(unknowns, unknowns) * 1e-12;
        normal.Jr = Eigen::VectorXd::Zero(unknowns);
        for (const std::size_t p : scope.places)
        {
            const Eigen::VectorXcd r = left(_y[p], heard(at, p));
            Eigen::MatrixXcd J = Eigen::MatrixXcd::Zero(r.size(), unknowns);
            for (int k = 0; k < unknowns; ++k)
            {
                const int place = at.placeOf(k);
                if (!scope.isFree(at, k) || (place >= 0 && place != static_cast<int>(p))) continue;
                const double step = place >= 0 || k == 0 ? kPlaceStep : kStep;
                const double before = at.at(k);
                at.at(k) = before - step;
                const Eigen::VectorXcd below = left(_y[p], heard(at, p));
                at.at(k) = before + step;
                J.col(k) = (left(_y[p], heard(at, p)) - below) / (2.0 * step);
                at.at(k) = before;
            }
            normal.JJ += (J.adjoint() * J).real();
            normal.Jr += (J.adjoint() * r).real();
            normal.sum += r.squaredNorm();
        }
        for (const Prior& prior : priors())
        {
            if (!scope.isFree(at, prior.unknown)) continue;
            normal.JJ(prior.unknown, prior.unknown) += prior.weight;
            normal.Jr[prior.unknown] += prior.weight * (at.at(prior.unknown) - prior.value);
        }
        normal.sum += priorOf(at);
        return normal;
    }

    // Levenberg-Marquardt (Marquardt 1963).
    void refine(PlateUnknowns& at, const PlateScope& scope) const
    {
        double damping = 1e-3;
        PlateSums normal = normalAt(at, scope);
        for (int made = 0; made < kPlateSteps && damping < 1e6; ++made)
        {
            Eigen::MatrixXd JJ = normal.JJ;
            JJ.diagonal() *= 1.0 + damping;
            const Eigen::VectorXd step = JJ.ldlt().solve(-normal.Jr);
            PlateUnknowns next = at;
            for (int k = 0; k < at.count(); ++k)
                next.at(k) += step[k];
            next.reflection = std::clamp(next.reflection, 0.0, 1.0);
            const double sum = squareOf(next, scope);
            if (!(sum < normal.sum))
            {
                damping *= 8.0;
                continue;
            }
            const bool isDone = sum > (1.0 - 1e-7) * normal.sum;
            at = next;
            if (isDone) return;
            damping = std::max(1e-9, 0.2 * damping);
            normal = normalAt(at, scope);
        }
    }

    // The sum of squares of a part of the first place's readings with the reflection that fits them
    // best, which is written to \a at.
    double coarse(PlateUnknowns& at) const
    {
        const std::size_t stride = std::max<std::size_t>(1, _live[0].size() / kPlateTransducers);
        at.phase_rad = 0.0;
        at.reflection = 0.0;
        const Eigen::VectorXcd direct = heard(at, 0, stride);
        at.reflection = 1.0;
        const Eigen::VectorXcd image = heard(at, 0, stride) - direct;
        Eigen::VectorXcd y(direct.size());
        for (Eigen::Index k = 0; k < y.size(); ++k)
            y[k] = _y[0][k * static_cast<Eigen::Index>(stride)];
        // y = c (direct + R image), for any c and R.
        const Eigen::VectorXcd a = left(image, direct), b = left(y, direct);
        const double square = a.squaredNorm();
        const std::complex<double> cR = square > 0.0 ? a.dot(b) / square : 0.0;
        const std::complex<double> c = direct.dot(y - cR * image) / direct.squaredNorm();
        const std::complex<double> R = c != 0.0 ? cR / c : 0.0;
        at.reflection = std::min(1.0, std::abs(R));
        at.phase_rad = std::arg(R);
        return (b - cR * a).squaredNorm();
    }

    // Starts along the normal, tilted, and with the microphone farther and nearer, because the
    // reflected sound blurs its distance; the best are refined.
    PlateUnknowns foundAtFirstPlace(const PlateUnknowns& start) const
    {
        const double wave_m = wavelengthAt(start.temperature_C);
        const auto stepsFor = [](double range, double step)
        { return std::min(kPlateStarts, static_cast<int>(std::ceil(range / step))); };
        const int shifts = stepsFor(_options.search_m, wave_m / 16.0);
        const int tilts = stepsFor(_options.tilt_rad, kPlateTiltStep * wave_m / (4.0 * _half_m));
        const auto part = [](int k, int of, double range) { return of > 0 ? k * range / of : 0.0; };
        std::vector<std::pair<double, PlateUnknowns>> starts;
        for (int a = -tilts; a <= tilts; ++a)
            for (int b = -tilts; b <= tilts; ++b)
                for (int eighths = -kPlateSlips; eighths <= kPlateSlips; ++eighths)
                    for (int k = -shifts; k <= shifts; ++k)
                    {
                        PlateUnknowns at = start;
                        at.shift_m = part(k, shifts, _options.search_m);
                        at.tiltAlong = part(a, tilts, _options.tilt_rad);
                        at.tiltAcross = part(b, tilts, _options.tilt_rad);
                        slip(at, 0, eighths);
                        const double sum = coarse(at);
                        starts.emplace_back(sum, at);
                    }
        return bestRefined(std::move(starts), {{0}, true, true});
    }

    // Finds another place of the microphone with the reflector that the ones before found.
    void findPlace(PlateUnknowns& at, std::size_t p) const
    {
        const PlateScope scope{{p}, false, false};
        std::vector<std::pair<double, PlateUnknowns>> starts;
        for (int eighths = -2 * kPlateSlips; eighths <= 2 * kPlateSlips; ++eighths)
        {
            PlateUnknowns moved = at;
            slip(moved, p, eighths);
            const double sum = squareOf(moved, scope);
            starts.emplace_back(sum, moved);
        }
        at = bestRefined(std::move(starts), scope);
    }

    PlateUnknowns bestRefined(std::vector<std::pair<double, PlateUnknowns>> starts,
                              const PlateScope& scope) const
    {
        const auto isLess = [](const auto& one, const auto& other)
        { return one.first < other.first; };
        const auto few = std::min<std::size_t>(kPlateRefined, starts.size());
        std::partial_sort(starts.begin(),
                          starts.begin() + static_cast<std::ptrdiff_t>(few),
                          starts.end(),
                          isLess);
        starts.resize(few);
        for (auto& [sum, at] : starts)
        {
            refine(at, scope);
            sum = squareOf(at, scope);
        }
        return std::min_element(starts.begin(), starts.end(), isLess)->second;
    }

    void tell(const PlateUnknowns& best, const PlateScope& scope, ReflectorFit& fit) const
    {
        fit.reflector = movedPlate(_guess, best);
        fit.places = best.places;
        fit.soundSpeed_m_s = airAt(best.temperature_C).soundSpeed();
        const PlateSums normal = normalAt(best, scope);
        // What is wrong about a transducer is wrong at each place, so places don't average it.
        const double variance =
            static_cast<double>(_y.size()) * normal.sum /
            std::max(1.0, 2.0 * readings(scope) - static_cast<double>(best.count()));
        const Eigen::MatrixXd covariance =
            variance *
            normal.JJ.ldlt().solve(Eigen::MatrixXd::Identity(best.count(), best.count()));
        const auto error = [&](int k) { return std::sqrt(covariance(k, k)); };
        fit.placeError_m = error(0);
        fit.tiltErrors_rad = {error(1), error(2)};
        fit.reflectionError = error(3);
        fit.reflectionPhaseError_rad = error(4);
        // The mean over a square of half the side b: b^2/3 for each tilt.
        fit.reflector.accuracy_mm =
            1e3 * std::sqrt(std::pow(fit.placeError_m, 2.0) +
                            fit.tiltErrors_rad.squaredNorm() * _half_m * _half_m / 3.0);
        // Errors that can't be told are NaN, and must not look like those of a sure fit.
        areValid({fit.reflector}, &fit.refusal);
    }

    TransducerArray _array; // with the reflector at last
    const Reflector _guess;
    const ReflectorFitOptions& _options;
    const double _half_m;
    const Eigen::Matrix3Xd _planned;
    std::vector<Eigen::VectorXcd> _y;    // readings of each place
    std::vector<std::vector<int>> _live; // their transducers
};

void checkPlate(const TransducerArray& tuned,
                const TuningPlan& plan,
                const TuningReadings& readings,
                const Reflector& guess,
                const ReflectorFitOptions& options)
{
    plan.requireFor(tuned);
    if (!needsPhases(plan.method) || readings.areLevels)
        throw base::InputError("a reflector is found by phases: the plan must be of the method "
                               "single or hadamard, with complex readings");
    if (!isRoomIn(tuned.reflectors))
        throw base::InputError(fmt::format(
            "the array has {} reflectors, which leaves no place for another", kMostReflectors));
    std::string error;
    if (!areValid({guess}, &error)) throw base::InputError(error);
    if (!base::RangeCheck()
             .within("search", options.search_m, 0.0, 0.02)
             .within("tilt", options.tilt_rad, 0.0, 0.1)
             .within("relativeHumidity", options.relativeHumidity, 0.0, 1.0)
             .within("temperature", options.prior.temperature_C, -40.0, 60.0)
             .atLeast("clip", options.clip, 0.0)
             .passed(&error))
        throw base::InputError(error);
}

} // namespace

ReflectorFit fitReflector(const TransducerArray& tuned,
                          const TuningPlan& plan,
                          const TuningReadings& readings,
                          const Reflector& guess,
                          const ReflectorFitOptions& options)
{
    checkPlate(tuned, plan, readings, guess, options);
    Medium medium;
    medium.temperature_C = options.prior.temperature_C;
    medium.relativeHumidity = options.relativeHumidity;
    const Eigen::MatrixXd expected =
        referencePropagationMatrix(plan.places, tuned, medium).cwiseAbs();
    return PlateFitter(tuned, plan, guess, options)
        .run(responsesOf(plan, readings, expected, options.clip), readings.notes());
}

std::string ReflectorFit::text() const
{
    std::string text;
    for (const std::string& note : notes)
        text += "note        " + note + "\n";
    if (!usable()) return text + "refused     " + refusal + "\n";
    fmt::format_to(
        std::back_inserter(text),
        "readings    {:.1f} % left without the reflector, {:.1f} % with it\n"
        "reflector   {}: centre ({:.5f}, {:.5f}, {:.5f}) m, +- {:.2f} mm along its normal\n"
        "normal      ({:.5f}, {:.5f}, {:.5f}), +- {:.3f} degrees about along, {:.3f} about across\n"
        "reflection  {:.3f} +- {:.3f}, phase {:.1f} +- {:.1f} degrees\n"
        "accuracy    {:.2f} mm over its size: {}\n",
        100.0 * before,
        100.0 * after,
        reflector.called(0),
        reflector.position.x(),
        reflector.position.y(),
        reflector.position.z(),
        1e3 * placeError_m,
        reflector.normal.x(),
        reflector.normal.y(),
        reflector.normal.z(),
        base::toDegrees(tiltErrors_rad.x()),
        base::toDegrees(tiltErrors_rad.y()),
        reflector.reflection,
        reflectionError,
        base::toDegrees(reflector.reflectionPhase_rad),
        base::toDegrees(reflectionPhaseError_rad),
        reflector.accuracy_mm,
        isUseful() ? "fields are corrected for it"
                   : "too far from sure to correct fields, so it is told only");
    return text;
}

} // namespace midair::haptics
