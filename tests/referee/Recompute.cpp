#include "tests/referee/Recompute.h"

#include "haptics/propagation/ReferencePropagation.h"
#include "tests/referee/Surface.h"

#include <algorithm>
#include <cmath>

namespace midair::referee
{

namespace
{

constexpr double kShort = 0.01;     // a point that is short by more counts
constexpr double kUncertain = 1e-5; // of a shortfall, since products are in single precision
// Of an error: a pressure rounds by this share of a usual one (floorOf), so that of a point with a
// target below the rms of all is less certain in proportion.
constexpr double kRounding = 4e-5;
constexpr double kOutOfReach = 1e-3;             // of the best point's sum of magnitudes
constexpr double kLeastOfLargest = 1e-3;         // lower targets count as this share of the largest
constexpr double kOwnFrom = 0.01 * (1.0 - 1e-6); // lower ones have their errors of the largest
// Relative difference of the mean pressures on and off one surface in one field, told and
// recomputed: 1e-6 is usual. Those of two updates hardly ever agree so well, both at once.
constexpr double kSameSurface = 2e-5;

void set(Recomputed& result, const char* name, double value)
{
    result.figures[name] = {value, value, false};
}

void setCount(Recomputed& result, const char* name, Eigen::Index least, Eigen::Index most)
{
    result.figures[name] = {double(least), double(most), true};
}

void setCount(Recomputed& result, const char* name, Eigen::Index value)
{
    setCount(result, name, value, value);
}

// Si(x), the integral of sin(t)/t from 0 to x, by Simpson's rule in steps of about 1/50.
double sineIntegral(double x)
{
    const int n = 2 * static_cast<int>(25.0 * x + 10.0);
    const double h = x / n;
    const auto sinc = [](double t) { return t == 0.0 ? 1.0 : std::sin(t) / t; };
    double sum = sinc(0.0) + sinc(x);
    for (int k = 1; k < n; ++k)
        sum += (k % 2 == 1 ? 4.0 : 2.0) * sinc(k * h);
    return sum * h / 3.0;
}

// The integral of (sin(pi t)/(pi t))^2 from -x to x, by parts:
// 2/pi (Si(2 pi x) - sin^2(pi x)/(pi x)).
double energyWithin(double x)
{
    const double sine = std::sin(M_PI * x);
    return 2.0 / M_PI * (sineIntegral(2.0 * M_PI * x) - sine * sine / (M_PI * x));
}

/// Errors of pressures y for targets a at the level s, and how many points are short of s a.
struct Errors
{
    double rms = 0.0, max = 0.0, rmsOfLargest = 0.0, maxOfLargest = 0.0, worstShortfall = 0.0;
    double surelyMax = 0.0, perhapsMax = 0.0; // within what rounds
    int surelyShort = 0, perhapsShort = 0;
};

Errors errorsOf(const Eigen::VectorXd& y, const Eigen::VectorXd& a, double s);

/// Adds what 1 K costs the field \a q for \a points to \a figures.
void rateKelvin(const Recorded& recorded,
                const haptics::ControlPoints& points,
                const Eigen::VectorXcd& q,
                std::map<std::string, Truth>& figures)
{
    haptics::Medium warmer = recorded.medium;
    warmer.temperature_C += 1.0;
    const auto pressures = [&](const haptics::Medium& air) -> Eigen::VectorXd
    {
        return (haptics::referencePropagationMatrix(points.positions, recorded.array, air) * q)
            .cwiseAbs();
    };
    const Eigen::VectorXd a = points.targets.cwiseMax(kLeastOfLargest * points.targets.maxCoeff());
    const Eigen::VectorXd y = pressures(warmer);
    const double level = y.dot(a) / a.dot(a);
    const double rms = errorsOf(y, a, points.absolute ? 1.0 : level).rms;
    const double share = y.dot(a) / pressures(recorded.medium).dot(a);
    figures["kelvinRms"] = {rms, rms, false};
    figures["kelvinLevel"] = {share, share, false};
}

Errors errorsOf(const Eigen::VectorXd& y, const Eigen::VectorXd& a, double s)
{
    Errors errors;
    const double usual = std::sqrt(a.squaredNorm() / static_cast<double>(a.size()));
    for (Eigen::Index l = 0; l < y.size(); ++l)
    {
        const double e = y[l] / (s * a[l]) - 1.0;
        const double ofLargest = std::fabs(y[l] - s * a[l]) / (s * a.maxCoeff());
        const bool isOwn = a[l] >= kOwnFrom * a.maxCoeff();
        const double shown = isOwn ? std::fabs(e) : ofLargest;
        const double doubt = isOwn ? kRounding * std::max(0.0, usual / a[l] - 1.0) : 0.0;
        errors.rms += shown * shown / static_cast<double>(y.size());
        errors.max = std::max(errors.max, shown);
        errors.surelyMax = std::max(errors.surelyMax, shown - doubt);
        errors.perhapsMax = std::max(errors.perhapsMax, shown + doubt);
        errors.rmsOfLargest += ofLargest * ofLargest / static_cast<double>(y.size());
        errors.maxOfLargest = std::max(errors.maxOfLargest, ofLargest);
        errors.worstShortfall = std::max(errors.worstShortfall, -e);
        errors.surelyShort += -e > kShort + kUncertain ? 1 : 0;
        errors.perhapsShort += -e > kShort - kUncertain ? 1 : 0;
    }
    errors.rms = std::sqrt(errors.rms);
    errors.rmsOfLargest = std::sqrt(errors.rmsOfLargest);
    return errors;
}

Eigen::Matrix3Xd chosen(const Eigen::Matrix3Xd& all, const std::vector<int>& which)
{
    Eigen::Matrix3Xd some(3, static_cast<Eigen::Index>(which.size()));
    for (std::size_t k = 0; k < which.size(); ++k)
        some.col(static_cast<Eigen::Index>(k)) = all.col(which[k]);
    return some;
}

} // namespace

double audiblePart(double rate_Hz)
{
    return energyWithin(20e3 / rate_Hz) - energyWithin(20.0 / rate_Hz);
}

Recomputer::Recomputer(const Recorded& recorded) :
    _recorded(recorded),
    _audibleShare(audiblePart(recorded.fieldRate_Hz))
{
}

// A device makes of phase level L and duty level D: sin(pi D / 510) e^{j 2 pi L / 256}.
Eigen::VectorXcd Recomputer::playedIn(const Part& part) const
{
    const device::DriveSignal& signal = _recorded.fields[part.field];
    Eigen::VectorXcd q(static_cast<Eigen::Index>(signal.phase.size()));
    for (std::size_t i = 0; i < signal.phase.size(); ++i)
        q[static_cast<Eigen::Index>(i)] = std::polar(std::sin(M_PI * signal.duty[i] / 510.0),
                                                     2.0 * M_PI * signal.phase[i] / 256.0);
    return q;
}

// A row of G is kept while its point stays within the skip tolerance of where it was built.
Recomputer::Rows& Recomputer::choosePlaces(const Part& part, const Update& update)
{
    const haptics::ControlPoints& points = part.points;
    Rows& rows = _rows[part.rows];
    if (update.isJoined && rows.solvedFor.cols() == points.size() &&
        rows.solvedFor == points.positions)
        return rows;
    std::vector<int> active;
    for (int l = 0; l < points.size(); ++l)
        if (points.targets[l] > 0.0) active.push_back(l);
    const Eigen::MatrixXcd all = haptics::referencePropagationMatrix(
        chosen(points.positions, active), _recorded.array, _recorded.medium);
    const Eigen::VectorXd sums = all.cwiseAbs().rowwise().sum();
    std::vector<int> reached;
    for (std::size_t k = 0; k < active.size(); ++k)
        if (sums[static_cast<Eigen::Index>(k)] > kOutOfReach * sums.maxCoeff())
            reached.push_back(active[k]);
    const bool anew = static_cast<Eigen::Index>(reached.size()) != rows.places.cols();
    const Eigen::Matrix3Xd asked = chosen(points.positions, reached);
    rows.asked.resize(asked.cols(), all.cols());
    for (std::size_t k = 0, row = 0; k < active.size() && row < reached.size(); ++k)
        if (active[k] == reached[row])
            rows.asked.row(static_cast<Eigen::Index>(row++)) =
                all.row(static_cast<Eigen::Index>(k));
    if (anew)
    {
        rows.places = asked;
        rows.kept = rows.asked;
    }
    int built = anew ? static_cast<int>(reached.size()) : 0;
    rows.worstMove_m = 0.0;
    for (Eigen::Index l = 0; l < asked.cols(); ++l)
    {
        const double moved_m = (asked.col(l) - rows.places.col(l)).norm();
        if (moved_m <= _recorded.skipTolerance_m)
        {
            rows.worstMove_m = std::max(rows.worstMove_m, moved_m);
            continue;
        }
        rows.places.col(l) = asked.col(l);
        rows.kept.row(l) = rows.asked.row(l);
        ++built;
    }
    rows.active = reached;
    if (update.isRepeat) return rows; // nobody solved
    rows.solvedFor = points.positions;
    rows.built = built;
    return rows;
}

void Recomputer::ratePart(const Part& part, const Rows& rows, Sums& sums, Recomputed& result) const
{
    const haptics::ControlPoints& points = part.points;
    const Eigen::VectorXcd q = playedIn(part);
    const Eigen::VectorXd y = (rows.kept * q).cwiseAbs();
    Eigen::VectorXd a(static_cast<Eigen::Index>(rows.active.size()));
    for (std::size_t k = 0; k < rows.active.size(); ++k)
        a[static_cast<Eigen::Index>(k)] = points.targets[rows.active[k]];
    a = a.cwiseMax(kLeastOfLargest * a.maxCoeff()).eval();
    const auto n = static_cast<double>(a.size());
    const double s = y.dot(a) / a.dot(a);
    const Errors errors = errorsOf(y, a, points.absolute ? 1.0 : s);
    sums.points += points.size();
    sums.rated += static_cast<int>(a.size());
    sums.built += rows.built;
    sums.squares += n * errors.rms * errors.rms;
    sums.surelyMax = std::max(sums.surelyMax, errors.surelyMax);
    sums.perhapsMax = std::max(sums.perhapsMax, errors.perhapsMax);
    sums.squaresOfLargest += n * errors.rmsOfLargest * errors.rmsOfLargest;
    sums.maxOfLargest = std::max(sums.maxOfLargest, errors.maxOfLargest);
    sums.level_Pa = std::max(sums.level_Pa, s * a.maxCoeff());
    sums.loudness += s * a.norm() / rows.kept.cwiseAbs().rowwise().sum().mean();
    if (points.absolute)
    {
        sums.worstShortfall = std::max(sums.worstShortfall, errors.worstShortfall);
        sums.surelyShort += errors.surelyShort;
        sums.perhapsShort += errors.perhapsShort;
    }
    const Eigen::VectorXd there = (rows.asked * q).cwiseAbs();
    const Errors asked = errorsOf(there, a, points.absolute ? 1.0 : there.dot(a) / a.dot(a));
    sums.squaresAsked += n * asked.rms * asked.rms;
    sums.maxAsked = std::max(sums.maxAsked, asked.max);
    result.worstMove_m = std::max(result.worstMove_m, rows.worstMove_m);
    result.loudest_Pa = std::max(result.loudest_Pa, y.maxCoeff());
}

// Of several fields the points count together, each in the field that is for it.
void Recomputer::setAll(const Sums& sums, Recomputed& result)
{
    const double rated = std::max(1, sums.rated);
    _level_Pa = sums.level_Pa;
    set(result, "rms", std::sqrt(sums.squares / rated));
    result.figures["max"] = {sums.surelyMax, sums.perhapsMax, false};
    set(result, "rmsOfLargest", std::sqrt(sums.squaresOfLargest / rated));
    set(result, "maxOfLargest", sums.maxOfLargest);
    set(result, "level_Pa", _level_Pa);
    set(result, "loudness", sums.loudness / static_cast<double>(_q.size()));
    set(result, "worstShortfall", sums.worstShortfall);
    setCount(result, "shortPoints", sums.surelyShort, sums.perhapsShort);
    setCount(result, "points", sums.points);
    setCount(result, "leftOut", sums.points - sums.rated);
    setCount(result, "rowsBuilt", sums.built);
    result.rmsAsked = std::sqrt(sums.squaresAsked / rated);
    result.maxAsked = sums.maxAsked;
}

// A held field follows the last one, fields in turn each other, the first the last of them again. A
// transducer that is off before or after has no phase, so no step of it.
void Recomputer::rateChange(Recomputed& result) const
{
    double steps = 0.0, change = 0.0, power = 0.0;
    for (std::size_t k = 0; k < _q.size(); ++k)
    {
        const Eigen::VectorXcd& to = _q[k];
        const Eigen::VectorXcd& from = _q.size() > 1 ? _q[(k + _q.size() - 1) % _q.size()] : _lastQ;
        for (Eigen::Index i = 0; from.size() > 0 && i < to.size(); ++i)
        {
            const std::complex<double> turn = to[i] * std::conj(from[i]);
            if (turn != 0.0) steps += std::fabs(std::arg(turn));
            change += std::norm(to[i] - from[i]);
            power += std::norm(to[i]);
        }
    }
    const double share = power > 0.0 ? change / power : 0.0;
    const auto count = static_cast<double>(_q.size()) * static_cast<double>(_q.front().size());
    set(result, "meanPhaseStep_rad", steps / count);
    set(result, "driveChange", share);
    set(result, "audibleChange", _audibleShare * share);
    const bool isJump = _lastLevel_Pa > 0.0 && _level_Pa > 0.0;
    set(result,
        "levelJump",
        isJump ? std::max(_level_Pa / _lastLevel_Pa, _lastLevel_Pa / _level_Pa) : 0.0);
}

// Without a cap the phase-only field of relative targets is at full drive, so what is played of it
// is the cap's factor.
void Recomputer::rateCap(Recomputed& result) const
{
    setCount(result, "transducers", _q.front().size());
    setCount(
        result, "reflectorCount", static_cast<Eigen::Index>(_recorded.array.reflectors.size()));
    set(result, "reflectorRms", 0.0); // of fields at rest, and these move
    set(result, "capFactor", _recorded.cap_Pa > 0.0 ? _q.front().cwiseAbs().mean() : 1.0);
}

// Of fields in turn: again and again, until every transducer repeats: the envelope's power by
// Simpson's rule. No scene is modulated.
void Recomputer::rateRinging(Recomputed& result) const
{
    constexpr int kPanels = 40;
    const double T = 1.0 / _recorded.fieldRate_Hz, tau = _recorded.array.ringing_s;
    double steady = 0.0, ringing = 0.0;
    Eigen::VectorXcd a = _q.back();
    const int rounds = 2 + static_cast<int>(30.0 * tau / T / static_cast<double>(_q.size()));
    for (int round = 0; round < rounds && _q.size() > 1; ++round)
        for (const Eigen::VectorXcd& q : _q)
        {
            for (int s = 0; s <= kPanels && round + 1 == rounds; ++s)
            {
                const double weight = s == 0 || s == kPanels ? 1.0 : s % 2 == 1 ? 4.0 : 2.0;
                const double left = tau > 0.0 ? std::exp(-T * s / kPanels / tau) : 0.0;
                ringing += weight / (3.0 * kPanels) * (q + (a - q) * left).squaredNorm();
            }
            if (round + 1 == rounds) steady += q.squaredNorm();
            a = q + (a - q) * (tau > 0.0 ? std::exp(-T / tau) : 0.0);
        }
    // A field that is held: the first moments after the one before.
    const bool hasLast = _lastQ.size() == _q.front().size() && _lastQ.squaredNorm() > 0.0;
    for (int s = 0; s <= kPanels && _q.size() == 1 && hasLast; ++s)
    {
        const Eigen::VectorXcd& q = _q.front();
        const double weight = s == 0 || s == kPanels ? 1.0 : s % 2 == 1 ? 4.0 : 2.0;
        const double left = tau > 0.0 ? std::exp(-T * s / kPanels / tau) : 0.0;
        ringing += weight / (3.0 * kPanels) * (q + (_lastQ - q) * left).squaredNorm();
        if (s == 0) steady = q.squaredNorm();
    }
    set(result, "ringingShare", steady > 0.0 ? std::min(ringing / steady, 1.0) : 1.0);
    set(result, "ringingModulation", 1.0);
}

// Surface figures are those of the newest field that was measured: of this update, or of one after
// that of the figures before.
void Recomputer::rateSurface(const Update& update, Recomputed& result)
{
    const haptics::SurfaceStatistics& told = update.report.surface;
    if (told.samples == 0 || !_recorded.mesh)
    {
        set(result, "kelvinRms", 0.0);
        set(result, "kelvinLevel", 0.0);
        return;
    }
    const bool isNew = _surface.empty() || told.mean_Pa != _toldSurface.mean_Pa ||
                       told.offMean_Pa != _toldSurface.offMean_Pa;
    _toldSurface = told;
    for (std::size_t k = _next + 1; isNew && k-- > _measured;)
    {
        const Update& candidate = _recorded.updates[k];
        if (candidate.isRepeat && k > 0) continue;
        std::vector<Eigen::VectorXcd> fields;
        for (const Part& part : candidate.parts)
            fields.push_back(playedIn(part));
        std::map<std::string, Truth> truth = surfaceFigures(_recorded, candidate, fields);
        rateKelvin(_recorded, candidate.parts.front().points, fields.front(), truth);
        const double on = told.mean_Pa / truth["surface.mean_Pa"].least;
        const double off = told.offMean_Pa / truth["surface.offMean_Pa"].least;
        const bool isIt = std::max(std::fabs(on - 1.0), std::fabs(off - 1.0)) < kSameSurface;
        if (_surface.empty() || isIt || k == _next) _surface = std::move(truth);
        if (!isIt) continue;
        _measured = k;
        break;
    }
    result.figures.insert(_surface.begin(), _surface.end());
}

Recomputed Recomputer::next()
{
    const Update& update = _recorded.updates[_next];
    Recomputed result;
    Sums sums;
    _q.clear();
    for (const Part& part : update.parts)
    {
        _q.push_back(playedIn(part));
        ratePart(part, choosePlaces(part, update), sums, result);
    }
    setAll(sums, result);
    rateChange(result);
    rateCap(result);
    rateRinging(result);
    rateSurface(update, result);
    ++_next;
    if (update.isRepeat) return result;
    _lastQ = _q.front();
    _lastLevel_Pa = _level_Pa;
    return result;
}

} // namespace midair::referee
