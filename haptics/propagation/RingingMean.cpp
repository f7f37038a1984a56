#include "haptics/propagation/RingingMean.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/propagation/PointChunks.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/PropagationMatrix.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numeric>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

using Complex = std::complex<double>;

// Longest bin of delays: half of it is the largest error of a delay, 1 % of the T4010A1's ringing,
// and the errors of thousands of transducers cancel.
constexpr double kBin_s = 4e-6;
// After this many time constants a step has vanished, in single precision.
constexpr double kForgotten = 16.0;

void checkStep(double step_s, double ringing_s)
{
    if (!(step_s > 0.0) || !std::isfinite(step_s))
        throw base::InputError(
            fmt::format("fields in turn: a field lasts {:g} s; it must be above 0", step_s));
    if (!(ringing_s >= 0.0 && ringing_s <= kMostRinging_s))
        throw base::InputError(fmt::format(
            "fields in turn: the ringing is {:g} s; it must be within 0 .. 0.01", ringing_s));
}

// Integral of e^{-rate t} from 0 to T, for a complex rate with a real part >= 0.
Complex decayed(Complex rate, double T)
{
    return std::abs(rate) * T < 1e-9 ? Complex(T) : (1.0 - std::exp(-rate * T)) / rate;
}

// Sums the parts of W(t) = A + B e^{-t/tau} + C e^{-2t/tau} over the steps.
class PowerSum
{
public:
    PowerSum(double step_s, double ringing_s, double frequency_Hz) :
        _step_s(step_s),
        _omega(base::kTwoPi * frequency_Hz)
    {
        const Complex j(0.0, _omega);
        _swings = frequency_Hz > 0.0;
        const double rate = ringing_s > 0.0 ? 1.0 / ringing_s : 0.0;
        for (std::size_t part = 0; part < _means.size(); ++part)
        {
            const double decay = static_cast<double>(part) * rate;
            // Without ringing the second and third part vanish immediately.
            const bool isThere = part == 0 || ringing_s > 0.0;
            _means[part] = isThere ? decayed(decay, step_s).real() : 0.0;
            _waves[part] = isThere ? decayed(decay + j, step_s) : 0.0;
        }
    }

    void add(double A, double B, double C)
    {
        const Complex turn = std::polar(1.0, -_omega * _step_s * static_cast<double>(_steps++));
        _steadyMean += A * _means[0];
        _ringingMean += A * _means[0] + B * _means[1] + C * _means[2];
        _steadySwing += turn * A * _waves[0];
        _ringingSwing += turn * (A * _waves[0] + B * _waves[1] + C * _waves[2]);
    }

    RadiatedPower result() const
    {
        const double T = _step_s * static_cast<double>(_steps);
        RadiatedPower power{_steadyMean / T, _ringingMean / T, 0.0, 0.0};
        if (!_swings) return power;
        power.steady_swing = 2.0 * std::abs(_steadySwing) / T;
        power.ringing_swing = 2.0 * std::abs(_ringingSwing) / T;
        return power;
    }

private:
    double _step_s, _omega;
    bool _swings = false;
    std::array<double, 3> _means{};
    std::array<Complex, 3> _waves{};
    std::int64_t _steps = 0;
    double _steadyMean = 0.0, _ringingMean = 0.0;
    Complex _steadySwing = 0.0, _ringingSwing = 0.0;
};

// Sums at one point by bins of delay, and the mean over the steps from them.
class BinnedPoint
{
public:
    BinnedPoint(std::size_t fields, double step_s, double ringing_s) :
        _fields(fields),
        _step_s(step_s),
        _tau_s(ringing_s),
        _perStep(static_cast<std::int64_t>(std::ceil(step_s / kBin_s))),
        _bin_s(step_s / static_cast<double>(_perStep))
    {
    }

    double bin_s() const { return _bin_s; }

    // Makes room for delays up to \a spread_s after the first.
    void clear(double spread_s)
    {
        _bins = static_cast<std::int64_t>(std::lround(spread_s / _bin_s)) + 1;
        _re.assign(static_cast<std::size_t>(_bins) * _fields, 0.0f);
        _im.assign(_re.size(), 0.0f);
    }

    // Adds a transducer with entry \a g, \a delay_s after the first, with its activations in turn.
    void add(std::complex<float> g, double delay_s, const float* qRe, const float* qIm)
    {
        const auto at = static_cast<std::size_t>(delay_s / _bin_s + 0.5) * _fields;
        float* re = _re.data() + at;
        float* im = _im.data() + at;
        for (std::size_t k = 0; k < _fields; ++k)
        {
            re[k] += g.real() * qRe[k] - g.imag() * qIm[k];
            im[k] += g.real() * qIm[k] + g.imag() * qRe[k];
        }
    }

    // Returns the mean of |S + E|^2, where S is the steady sum of what has arrived, and E the
    // ringing; sets \a waves (of its size). \a nearest_s: delay of the first transducer.
    double course(double nearest_s, Eigen::VectorXcd& waves) const
    {
        // Nothing changes between a step's last arrival and the next step.
        const std::int64_t looked = std::min(_perStep, _bins);
        const double rest_s = static_cast<double>(_perStep - looked + 1) * _bin_s;
        const double period_s = _step_s * static_cast<double>(_fields);
        const Interval one(_bin_s, _tau_s), last(rest_s, _tau_s);
        std::vector<WaveSum> sums;
        for (Eigen::Index h = 1; h <= waves.size(); ++h)
            sums.emplace_back(base::kTwoPi * static_cast<double>(h) / period_s, one, last);
        Complex E = 0.0;
        double sum = 0.0;
        for (const bool isLast : {false, true})
        {
            Complex S = settledBefore();
            for (std::int64_t k = 0; k < static_cast<std::int64_t>(_fields); ++k)
                for (std::int64_t j = 0; j < looked; ++j)
                {
                    const Complex change = arriving(k, j);
                    const bool isRest = j + 1 == looked;
                    const Interval& interval = isRest ? last : one;
                    S += change;
                    E -= change;
                    if (isLast)
                    {
                        sum += interval.of(S, E);
                        for (WaveSum& wave : sums)
                            wave.add(S, E, isRest);
                    }
                    E *= interval.left;
                }
            if (!isLast) E /= 1.0 - std::exp(-period_s / _tau_s);
        }
        for (Eigen::Index h = 0; h < waves.size(); ++h)
            waves[h] = sums[static_cast<std::size_t>(h)].wave(nearest_s, period_s);
        return sum / period_s;
    }

private:
    struct Interval
    {
        Interval(double T, double tau) :
            length(T),
            rate(tau > 0.0 ? 1.0 / tau : 0.0),
            left(std::exp(-T / tau)),
            once(2.0 * tau * (1.0 - left)),
            twice(0.5 * tau * (1.0 - left * left))
        {
        }
        double of(Complex S, Complex E) const
        {
            return std::norm(S) * length + (std::conj(S) * E).real() * once + std::norm(E) * twice;
        }
        double length, rate, left, once, twice;
    };

    // Sums |S + E|^2 e^{-j omega t} over the intervals.
    class WaveSum
    {
    public:
        WaveSum(double omega, const Interval& one, const Interval& last) :
            _omega(omega),
            _parts{Parts(omega, one), Parts(omega, last)}
        {
        }
        void add(Complex S, Complex E, bool isRest)
        {
            const Parts& parts = _parts[isRest];
            _sum += _turn * (std::norm(S) * parts.steady + (std::conj(S) * E).real() * parts.once +
                             std::norm(E) * parts.twice);
            _turn *= parts.turn;
        }
        Complex wave(double begin_s, double period_s) const
        {
            return 2.0 / period_s * std::polar(1.0, -_omega * begin_s) * _sum;
        }

    private:
        struct Parts
        {
            Parts(double omega, const Interval& interval) :
                steady(decayed({0.0, omega}, interval.length)),
                turn(std::polar(1.0, -omega * interval.length))
            {
                if (!(interval.rate > 0.0)) return; // nothing rings
                once = 2.0 * decayed({interval.rate, omega}, interval.length);
                twice = decayed({2.0 * interval.rate, omega}, interval.length);
            }
            Complex steady, turn, once, twice;
        };
        double _omega;
        std::array<Parts, 2> _parts;
        Complex _turn = 1.0, _sum = 0.0;
    };

    Complex at(std::int64_t bin, std::int64_t step) const
    {
        const auto K = static_cast<std::int64_t>(_fields);
        const auto place = static_cast<std::size_t>(bin * K + ((step % K) + K) % K);
        return {static_cast<double>(_re[place]), static_cast<double>(_im[place])};
    }

    // Change j bins after the beginning of step k: by this step, and by earlier ones still in
    // transit.
    Complex arriving(std::int64_t k, std::int64_t j) const
    {
        Complex change = 0.0;
        for (std::int64_t bin = j; bin < _bins; bin += _perStep, --k)
            change += at(bin, k) - at(bin, k - 1);
        return change;
    }

    // The steady sum just before the first arrival of step 0.
    Complex settledBefore() const
    {
        Complex sum = 0.0;
        for (std::int64_t bin = 0; bin < _bins; ++bin)
            sum += at(bin, -(bin / _perStep) - 1);
        return sum;
    }

    std::size_t _fields;
    double _step_s, _tau_s;
    std::int64_t _perStep;
    double _bin_s;
    std::int64_t _bins = 0;
    std::vector<float> _re, _im; // bin by bin the fields in turn
};

// Computes the mean of |p|^2 of some points, on one thread.
class RingingWorker
{
public:
    RingingWorker(const TransducerArray& array,
                  const Medium& medium,
                  const std::vector<Eigen::VectorXcf>& fields,
                  double step_s) :
        _perMetre_s(1.0 / medium.soundSpeed()),
        _point(fields.size(), step_s, array.ringing_s)
    {
        _matrix.bind(array, medium);
        _matrix.resize(PointChunks::kAtOnce);
        std::iota(_rows.begin(), _rows.end(), 0);
        const std::vector<int>& order = _matrix.order();
        _places = array.positions(Eigen::all, order);
        _distances.resize(static_cast<Eigen::Index>(order.size()));
        for (const int i : order)
            for (const Eigen::VectorXcf& q : fields)
            {
                _qRe.push_back(q[i].real());
                _qIm.push_back(q[i].imag());
            }
        _fields = fields.size();
    }

    // Points first .. first + count - 1, count <= PointChunks::kAtOnce.
    void work(const Eigen::Matrix3Xd& points,
              Eigen::Index first,
              Eigen::Index count,
              RingingCourse& course)
    {
        std::array<double, PointChunks::kAtOnce> sums{};
        for (Eigen::Index l = 0; l < count; ++l)
            _matrix.setPoint(static_cast<int>(l), points.col(first + l));
        for (int b = 0; b < _matrix.blocks(); ++b)
            _matrix.buildRows(b, _rows.data(), static_cast<int>(count), sums.data());
        const double unit = _matrix.unit_Pa() * _matrix.unit_Pa();
        Eigen::VectorXcd waves(course.waves.cols());
        for (Eigen::Index l = 0; l < count; ++l)
        {
            course.mean[first + l] =
                unit * courseOf(static_cast<int>(l), points.col(first + l), waves);
            course.waves.row(first + l) = unit * waves.transpose();
        }
    }

private:
    double courseOf(int l, const Eigen::Vector3d& r, Eigen::VectorXcd& waves)
    {
        _distances = (_places.colwise() - r).colwise().norm() * _perMetre_s;
        const double nearest_s = _distances.minCoeff();
        _point.clear(_distances.maxCoeff() - nearest_s);
        for (Eigen::Index lane = 0; lane < _distances.size(); ++lane)
        {
            const std::size_t q = static_cast<std::size_t>(lane) * _fields;
            _point.add(_matrix.at(l, static_cast<int>(lane)),
                       _distances[lane] - nearest_s,
                       _qRe.data() + q,
                       _qIm.data() + q);
        }
        return _point.course(nearest_s, waves);
    }

    PropagationMatrix _matrix;
    double _perMetre_s;
    BinnedPoint _point;
    std::array<int, PointChunks::kAtOnce> _rows{};
    Eigen::Matrix3Xd _places;
    Eigen::RowVectorXd _distances; // seconds
    std::vector<float> _qRe, _qIm; // lane by lane the fields in turn
    std::size_t _fields = 0;
};

} // namespace

RadiatedPower radiatedPower(const std::vector<Eigen::VectorXcf>& fields,
                            const std::vector<PatternStep>& steps,
                            double step_s,
                            double ringing_s,
                            double frequency_Hz)
{
    checkStep(step_s, ringing_s);
    if (fields.empty() || steps.empty())
        throw base::InputError("the pattern has no fields; there must be at least one");
    const double x = ringing_s > 0.0 ? std::exp(-step_s / ringing_s) : 0.0;
    const auto drive = [&](std::size_t k)
    {
        const PatternStep& step = steps[k];
        return fields[static_cast<std::size_t>(step.field)] * static_cast<float>(step.amplitude);
    };
    // Sets the envelopes to those of a pattern that has played for long: from the last steps before
    // it, or, if these are all, from silence by the sum of the series.
    const std::size_t N = steps.size();
    const double all = std::ceil(kForgotten * ringing_s / step_s);
    const bool isSeries = all >= static_cast<double>(N);
    const std::size_t first = isSeries ? 0 : N - static_cast<std::size_t>(all);
    Eigen::VectorXcf a = drive(N - 1);
    if (isSeries) a.setZero();
    for (std::size_t k = first; k < N; ++k)
    {
        const Eigen::VectorXcf q = drive(k);
        a = q + (a - q) * static_cast<float>(x);
    }
    if (isSeries) a /= static_cast<float>(1.0 - std::pow(x, static_cast<double>(N)));

    PowerSum sum(step_s, ringing_s, frequency_Hz);
    for (std::size_t k = 0; k < N; ++k)
    {
        const Eigen::VectorXcf q = drive(k);
        const Eigen::VectorXcf d = a - q;
        sum.add(q.squaredNorm(), 2.0 * std::real(q.dot(d)), d.squaredNorm());
        a = q + d * static_cast<float>(x);
    }
    return sum.result();
}

Eigen::VectorXd ringingOverlaps(int fields, double step_s, double ringing_s)
{
    return waveOverlaps(fields, step_s, ringing_s, 0).real();
}

// Field 0's share of the envelopes is, in the step s after its beginning,
//     e(t) = [s = 0] + g_s e^{-t/tau},   g_0 = e_0 - 1,   g_s = e_1 x^(s-1),   x = e^{-T/tau},
// with e_0 and e_1 at its beginning and end, and M_d = 1/T times the integral of e(t) e(t - d T)
// e^{-j omega t} over a turn.
Eigen::VectorXcd waveOverlaps(int fields, double step_s, double ringing_s, int wave)
{
    checkStep(step_s, ringing_s);
    if (fields < 1)
        throw base::InputError(
            fmt::format("fields in turn: there are {}; there must be at least 1", fields));
    const double x = ringing_s > 0.0 ? std::exp(-step_s / ringing_s) : 0.0;
    const double first =
        fields > 1 ? (1.0 - x) * std::pow(x, fields - 1) / (1.0 - std::pow(x, fields)) : 1.0;
    Eigen::VectorXd g(fields);
    g[0] = first - 1.0;
    for (int s = 1; s < fields; ++s)
        g[s] = (1.0 + g[0] * x) * std::pow(x, s - 1);
    const Complex j(0.0, base::kTwoPi * wave / (fields * step_s));
    const bool isRinging = ringing_s > 0.0;
    const Complex steady = decayed(j, step_s) / step_s;
    const Complex once = isRinging ? decayed(1.0 / ringing_s + j, step_s) / step_s : 0.0;
    const Complex twice = isRinging ? decayed(2.0 / ringing_s + j, step_s) / step_s : 0.0;
    Eigen::VectorXcd overlaps = Eigen::VectorXcd::Zero(fields);
    for (int d = 0; d < fields; ++d)
        for (int s = 0; s < fields; ++s)
        {
            const double other = g[(s - d + fields) % fields];
            Complex sum = g[s] * other * twice;
            if (s == 0) sum += other * once;
            if (s == d) sum += g[s] * once;
            if (s == 0 && d == 0) sum += steady;
            overlaps[d] += std::exp(-j * (s * step_s)) * sum;
        }
    return overlaps;
}

Eigen::VectorXd ringingMeanSquare(const Eigen::Matrix3Xd& points,
                                  const TransducerArray& array,
                                  const Medium& medium,
                                  const std::vector<Eigen::VectorXcf>& fields,
                                  double step_s,
                                  int threads,
                                  const base::StopToken& stop)
{
    return ringingCourse(points, array, medium, fields, step_s, 0, threads, stop).mean;
}

RingingCourse ringingCourse(const Eigen::Matrix3Xd& points,
                            const TransducerArray& array,
                            const Medium& medium,
                            const std::vector<Eigen::VectorXcf>& fields,
                            double step_s,
                            int waves,
                            int threads,
                            const base::StopToken& stop)
{
    checkStep(step_s, array.ringing_s);
    RingingCourse course;
    course.waves.setZero(points.cols(), waves);
    // A single field is steady, and without ringing sound is only delayed.
    if (fields.size() < 2 || (array.ringing_s == 0.0 && waves == 0) || points.cols() == 0)
    {
        course.mean = meanSquarePressure(points, array, medium, fields, threads, stop);
        return course;
    }
    for (const Eigen::VectorXcf& q : fields)
        checkActivations(array, q);
    course.mean.resize(points.cols());
    PointChunks chunks(points.cols(), stop);
    const auto work = [&]
    {
        RingingWorker worker(array, medium, fields, step_s);
        for (Eigen::Index begin = 0, count = 0; chunks.take(begin, count);)
            worker.work(points, begin, count, course);
    };
    chunks.run(threads, work);
    return course;
}

} // namespace midair::haptics
