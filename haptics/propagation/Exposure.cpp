#include "haptics/propagation/Exposure.h"

#include "haptics/base/Units.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/propagation/Reflections.h"
#include "haptics/propagation/kernels/PropagationKernels.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace midair::haptics
{

namespace
{

constexpr double kFlat_m = 1e-3; // largest distance of a transducer from its board's plane
constexpr Eigen::Index kFewest = 4;
constexpr double kTouching_m = 1e-6;

constexpr double kLowest_Hz = 20.0;
constexpr double kHighest_Hz = 20e3;

double sinc2(double x)
{
    if (std::fabs(x) < 1e-6) return 1.0;
    const double s = std::sin(base::kPi * x) / (base::kPi * x);
    return s * s;
}

// Returns 2 times the integral of sinc^2 from 0 to x: Simpson's rule up to kFar; beyond it the rest
// is 1/(pi^2 x) on average.
double within(double x)
{
    constexpr double kFar = 50.0;
    constexpr int kPanels = 32; // per lobe
    if (x > kFar) return 1.0 - 1.0 / (base::kPi * base::kPi * x);
    const int n = 2 * static_cast<int>(std::ceil(kPanels * std::fmax(x, 1.0)));
    const double h = x / n;
    double sum = sinc2(0.0) + sinc2(x);
    for (int k = 1; k < n; ++k)
        sum += (k % 2 == 1 ? 4.0 : 2.0) * sinc2(k * h);
    return 2.0 * sum * h / 3.0;
}

constexpr double kRadius_m = 0.5;
constexpr double kBeyond_m = 0.1; // of a sphere around a larger array
constexpr int kCandidates = 256;
constexpr Eigen::Index kSample = 48; // transducers for judging candidates

// Corners of a regular tetrahedron of radius 1.
const double kCorner = 1.0 / std::sqrt(3.0);
const Eigen::Vector3d kAround[] = {Eigen::Vector3d(kCorner, kCorner, kCorner),
                                   Eigen::Vector3d(kCorner, -kCorner, -kCorner),
                                   Eigen::Vector3d(-kCorner, kCorner, -kCorner),
                                   Eigen::Vector3d(-kCorner, -kCorner, kCorner)};

// Points of a spiral with equal areas (Fibonacci).
Eigen::Vector3d onSphere(int k, int count)
{
    const double y = 1.0 - (2.0 * k + 1.0) / count;
    const double r = std::sqrt(1.0 - y * y);
    const double turn = base::kPi * (3.0 - std::sqrt(5.0)) * k;
    return {r * std::cos(turn), y, r * std::sin(turn)};
}

const double kHeadFactor = std::pow(10.0, 0.05 * kHeadMargin_dB);

// |G| at an ear, without the absorption of air.
double strength(const TransducerArray& array, Eigen::Index i, const Eigen::Vector3d& place)
{
    const Eigen::Vector3d d = place - array.positions.col(i);
    const double R = std::max(d.norm(), kNearestDistance_m);
    const double cosTheta = std::clamp(d.dot(array.normals.col(i)) / R, -1.0, 1.0);
    const double gain = array.gain.size() > 0 ? array.gain[i] : 1.0;
    return kHeadFactor * array.heardAmplitude_Pa_m() * gain *
           directivity(array.directivity, cosTheta) / R;
}

} // namespace

FreeLines::FreeLines(const TransducerArray& array) : _positions(array.positions)
{
    const Eigen::Index m = array.positions.cols();
    _own.assign(static_cast<std::size_t>(m), -1);
    const bool isNumbered = static_cast<Eigen::Index>(array.board.size()) == m;
    for (Eigen::Index first = 0; first < m;)
    {
        Eigen::Index last = first + 1;
        while (last < m && (!isNumbered || array.board[static_cast<std::size_t>(last)] ==
                                               array.board[static_cast<std::size_t>(first)]))
            ++last;
        addBoard(array, first, last);
        first = last;
    }
}

void FreeLines::addBoard(const TransducerArray& array, Eigen::Index first, Eigen::Index last)
{
    if (last - first < kFewest) return;
    Rectangle board;
    board.corner = array.positions.col(first);
    board.normal = array.normals.col(first);
    const Eigen::Matrix3Xd d =
        array.positions.middleCols(first, last - first).colwise() - board.corner;
    if ((board.normal.transpose() * d).cwiseAbs().maxCoeff() > kFlat_m) return;
    Eigen::Index nearest = 0;
    const double pitch_m =
        std::sqrt(d.rightCols(d.cols() - 1).colwise().squaredNorm().minCoeff(&nearest));
    if (!(pitch_m > 0.0)) return;
    // Along the rows, so that the rectangle is as small as the board.
    Eigen::Vector3d along = d.col(nearest + 1);
    along -= board.normal * board.normal.dot(along);
    board.u = along.normalized();
    board.v = board.normal.cross(board.u);
    const Eigen::RowVectorXd a = board.u.transpose() * d;
    const Eigen::RowVectorXd b = board.v.transpose() * d;
    board.low = Eigen::Vector2d(a.minCoeff(), b.minCoeff()).array() - 0.5 * pitch_m;
    board.high = Eigen::Vector2d(a.maxCoeff(), b.maxCoeff()).array() + 0.5 * pitch_m;
    for (Eigen::Index i = first; i < last; ++i)
        _own[static_cast<std::size_t>(i)] = static_cast<int>(_boards.size());
    _boards.push_back(board);
}

bool FreeLines::isFree(Eigen::Index i, const Eigen::Vector3d& place) const
{
    return isFree(_positions.col(i), place, _own[static_cast<std::size_t>(i)]);
}

bool FreeLines::isFreeBy(const Reflector& reflector,
                         Eigen::Index i,
                         const Eigen::Vector3d& image) const
{
    const Eigen::Vector3d from = _positions.col(i);
    const double start_m = reflector.heightOf(from), end_m = reflector.heightOf(image);
    const double share = start_m == end_m ? 0.0 : start_m / (start_m - end_m);
    const Eigen::Vector3d hit = from + share * (image - from);
    return isFree(i, hit) && isFree(hit, reflector.mirrored(image), -1);
}

bool FreeLines::isFree(const Eigen::Vector3d& from, const Eigen::Vector3d& place, int own) const
{
    for (int b = 0; b < static_cast<int>(_boards.size()); ++b)
    {
        const Rectangle& board = _boards[static_cast<std::size_t>(b)];
        const double end_m = board.normal.dot(place - board.corner);
        if (b == own)
        {
            if (end_m <= 0.0) return false;
            continue;
        }
        const double start_m = board.normal.dot(from - board.corner);
        if (std::abs(start_m) < kTouching_m || start_m * end_m >= 0.0) continue;
        const double share = start_m / (start_m - end_m);
        const Eigen::Vector3d hit = from + share * (place - from) - board.corner;
        const Eigen::Vector2d at(board.u.dot(hit), board.v.dot(hit));
        if ((at.array() >= board.low.array()).all() && (at.array() <= board.high.array()).all())
            return false;
    }
    return true;
}

double audibleShare(double rate_Hz)
{
    return within(kHighest_Hz / rate_Hz) - within(kLowest_Hz / rate_Hz);
}

double soundLevel_dB(double square_Pa2)
{
    if (std::isnan(square_Pa2)) return square_Pa2;
    const double ratio = square_Pa2 / (kHearing_Pa * kHearing_Pa);
    return ratio > 1.0 ? 10.0 * std::log10(ratio) : 0.0;
}

double meanSquareOf_Pa2(double level_dB)
{
    return kHearing_Pa * kHearing_Pa * std::pow(10.0, 0.1 * level_dB);
}

namespace
{

// |G|^2 at an ear with what reflectors add, without the absorption of air.
double heardSquare(const TransducerArray& array,
                   const FreeLines& lines,
                   Eigen::Index i,
                   const Eigen::Vector3d& place)
{
    double square = lines.isFree(i, place) ? std::pow(strength(array, i, place), 2) : 0.0;
    for (const Reflector& one : array.reflectors)
    {
        const Eigen::Vector3d from = array.positions.col(i), image = one.mirrored(place);
        if (!isReflected(one, from, place) || !lines.isFreeBy(one, i, image)) continue;
        const double share =
            std::abs(shareTurned(one, from, place, Medium().wavelength(array.frequency_Hz)));
        square += std::pow(one.reflection * share * strength(array, i, image), 2);
    }
    return square;
}

} // namespace

Eigen::Matrix3Xd placesAround(const TransducerArray& array, int count)
{
    const Eigen::Index m = array.positions.cols();
    if (m == 0 || count <= 0) return Eigen::Matrix3Xd(3, 0);
    const FreeLines lines(array);
    const double radius_m =
        std::max(kRadius_m, kBeyond_m + array.positions.colwise().norm().maxCoeff());
    const Eigen::Index step = std::max<Eigen::Index>(1, m / kSample);
    std::vector<Eigen::Vector3d> heard;
    std::size_t next = 0;
    double loudest = 0.0;
    for (int k = 0; k < kCandidates; ++k)
    {
        const Eigen::Vector3d place = radius_m * onSphere(k, kCandidates);
        double sum = 0.0;
        for (Eigen::Index i = 0; i < m; i += step)
            sum += heardSquare(array, lines, i, place);
        if (!(sum > 0.0)) continue;
        if (sum > loudest) next = heard.size();
        loudest = std::max(loudest, sum);
        heard.push_back(place);
    }
    // Each next place is the farthest from all before it.
    Eigen::Matrix3Xd places(3,
                            std::min<Eigen::Index>(count, static_cast<Eigen::Index>(heard.size())));
    std::vector<double> apart2(heard.size(), 1e300);
    for (Eigen::Index l = 0; l < places.cols(); ++l)
    {
        places.col(l) = heard[next];
        for (std::size_t k = 0; k < heard.size(); ++k)
            apart2[k] = std::min(apart2[k], (heard[k] - heard[next]).squaredNorm());
        next = static_cast<std::size_t>(std::max_element(apart2.begin(), apart2.end()) -
                                        apart2.begin());
    }
    return places;
}

Exposure::Exposure(const TransducerArray& array,
                   const Medium& medium,
                   const Eigen::Matrix3Xd& places) :
    _array(array),
    _medium(medium),
    _lines(array),
    _places(places)
{
    const Eigen::Index m = array.positions.cols();
    _from = array.positions.transpose().cast<float>();
    for (Eigen::MatrixXf* matrix : {&_square, &_real, &_imaginary})
        matrix->resize(m, places.cols());
    for (Eigen::Index l = 0; l < places.cols(); ++l)
        listenTo(l);
}

// The wave of transducer  i at a place, or at its image.
std::complex<double> Exposure::wave(Eigen::Index i, const Eigen::Vector3d& at) const
{
    const double amplitude = strength(_array, i, at);
    if (amplitude == 0.0) return 0.0;
    const double k = base::kTwoPi / _medium.wavelength(_array.frequency_Hz);
    const double beta = _medium.attenuation(_array.frequency_Hz);
    const double R = std::max((at - _array.positions.col(i)).norm(), kNearestDistance_m);
    const double offset = _array.phaseOffset_rad.size() > 0 ? _array.phaseOffset_rad[i] : 0.0;
    return std::polar(amplitude * std::exp(-beta * R), offset - k * R);
}

// What reflectors add to it; adds the squares of its parts to  square.
std::complex<double>
Exposure::reflected(Eigen::Index i, const Eigen::Vector3d& place, double& square) const
{
    std::complex<double> sum = 0.0;
    for (const Reflector& one : _array.reflectors)
    {
        const Eigen::Vector3d from = _array.positions.col(i), image = one.mirrored(place);
        if (!isReflected(one, from, place) || !_lines.isFreeBy(one, i, image)) continue;
        const std::complex<double> part =
            factorOf(one) * shareTurned(one, from, place, _medium.wavelength(_array.frequency_Hz)) *
            wave(i, image);
        sum += part;
        square += std::norm(part);
    }
    return sum;
}

void Exposure::listen(const Eigen::Vector3d& place,
                      Eigen::Index column,
                      Eigen::MatrixXf& real,
                      Eigen::MatrixXf& imaginary) const
{
    double ignored = 0.0;
    for (Eigen::Index i = 0; i < real.rows(); ++i)
    {
        std::complex<double> heard = _lines.isFree(i, place) ? wave(i, place) : 0.0;
        if (!_array.reflectors.empty()) heard += reflected(i, place, ignored);
        real(i, column) = static_cast<float>(heard.real());
        imaginary(i, column) = static_cast<float>(heard.imag());
    }
}

void Exposure::listenTo(Eigen::Index l)
{
    listen(_places.col(l), l, _real, _imaginary);
    square(l);
}

void Exposure::square(Eigen::Index l)
{
    _square.col(l) = 0.5f * (_real.col(l).cwiseAbs2() + _imaginary.col(l).cwiseAbs2());
    if (_array.reflectors.empty()) return;
    for (Eigen::Index i = 0; i < _square.rows(); ++i)
    {
        const Eigen::Vector3d place = _places.col(l);
        double sum = _lines.isFree(i, place) ? std::norm(wave(i, place)) : 0.0;
        reflected(i, place, sum);
        _square(i, l) = static_cast<float>(0.5 * sum);
    }
}

Eigen::Vector3d Exposure::spot(Eigen::Index l, Eigen::Index k) const
{
    return k == 0 ? _places.col(l) : (_places.col(l) + kAround_m * kAround[k - 1]).eval();
}

void Exposure::listenAround(Eigen::Index l)
{
    _spotsReal.col(kSpots * l) = _real.col(l);
    _spotsImaginary.col(kSpots * l) = _imaginary.col(l);
    for (Eigen::Index k = 1; k < kSpots; ++k)
        listen(spot(l, k), kSpots * l + k, _spotsReal, _spotsImaginary);
}

void Exposure::setMedium(const Medium& medium)
{
    const double f_Hz = _array.frequency_Hz;
    const double turn_m =
        base::kTwoPi * (1.0 / medium.wavelength(f_Hz) - 1.0 / _medium.wavelength(f_Hz));
    const double decay_m = medium.attenuation(f_Hz) - _medium.attenuation(f_Hz);
    _medium = medium;
    const auto reach_m = [](const Eigen::Matrix3Xd& of)
    { return of.cols() > 0 ? of.colwise().norm().maxCoeff() : 0.0; };
    const double farthest_m = reach_m(_array.positions) + reach_m(_places) + kAround_m;
    // a^6 / 720 and b^3 / 6 are at most 1e-6 then. Entries with reflectors are sums over paths of
    // several lengths.
    const bool isLittle = _array.reflectors.empty() && std::abs(turn_m) * farthest_m < 0.3 &&
                          std::abs(decay_m) * farthest_m < 0.015;
    const auto turned = [&](const Eigen::Vector3d& place, float* real, float* imaginary)
    {
        const auto nearest_m = static_cast<float>(kNearestDistance_m);
        const Eigen::Vector3f at = place.cast<float>();
        kernels::turnByDistance(static_cast<int>(_from.rows()),
                                {_from.col(0).data(),
                                 _from.col(1).data(),
                                 _from.col(2).data(),
                                 {at[0], at[1], at[2]},
                                 nearest_m},
                                static_cast<float>(turn_m),
                                static_cast<float>(decay_m),
                                real,
                                imaginary);
    };
    for (Eigen::Index l = 0; l < size(); ++l)
    {
        if (isLittle)
        {
            turned(_places.col(l), _real.col(l).data(), _imaginary.col(l).data());
            square(l);
        }
        else
            listenTo(l);
        if (_spotsReal.size() == 0) continue;
        if (!isLittle) listenAround(l);
        for (Eigen::Index k = 0; isLittle && k < kSpots; ++k)
            turned(spot(l, k),
                   _spotsReal.col(kSpots * l + k).data(),
                   _spotsImaginary.col(kSpots * l + k).data());
    }
}

void Exposure::move(Eigen::Index l, const Eigen::Vector3d& place)
{
    _places.col(l) = place;
    listenTo(l);
    if (_spotsReal.size() > 0) listenAround(l);
}

Eigen::VectorXf Exposure::incoherent_Pa2(const Eigen::VectorXcf& q) const
{
    return incoherentOf_Pa2(q.cwiseAbs2());
}

Eigen::VectorXf Exposure::incoherentOf_Pa2(const Eigen::VectorXf& squares) const
{
    return _square.transpose() * squares;
}

Eigen::VectorXf Exposure::coherent_Pa2(const Eigen::VectorXcf& q) const
{
    const Eigen::VectorXf a = q.real();
    const Eigen::VectorXf b = q.imag();
    const Eigen::VectorXf re = _real.transpose() * a - _imaginary.transpose() * b;
    const Eigen::VectorXf im = _real.transpose() * b + _imaginary.transpose() * a;
    return 0.5f * (re.cwiseAbs2() + im.cwiseAbs2());
}

Eigen::MatrixXcf Exposure::spots_Pa(const Eigen::VectorXcf& q)
{
    if (_spotsReal.size() == 0)
    {
        _spotsReal.resize(_real.rows(), kSpots * size());
        _spotsImaginary.resize(_real.rows(), kSpots * size());
        for (Eigen::Index l = 0; l < size(); ++l)
            listenAround(l);
    }
    const Eigen::VectorXf a = q.real();
    const Eigen::VectorXf b = q.imag();
    Eigen::VectorXcf p(kSpots * size());
    p.real() = _spotsReal.transpose() * a - _spotsImaginary.transpose() * b;
    p.imag() = _spotsReal.transpose() * b + _spotsImaginary.transpose() * a;
    return Eigen::Map<const Eigen::MatrixXcf>(p.data(), kSpots, size());
}

Eigen::VectorXd Exposure::heard_Pa2(const std::vector<Eigen::VectorXcf>& fields) const
{
    Eigen::VectorXd coherent = Eigen::VectorXd::Zero(size());
    Eigen::VectorXd incoherent = Eigen::VectorXd::Zero(size());
    for (const Eigen::VectorXcf& q : fields)
    {
        if (q.isZero(0.0f)) continue;
        coherent += coherent_Pa2(q).cast<double>();
        incoherent += incoherent_Pa2(q).cast<double>();
    }
    const auto count = static_cast<double>(std::max<std::size_t>(1, fields.size()));
    return coherent.cwiseMax(incoherent) / count;
}

void ExposureMeter::closeBin(State& state)
{
    state.bins[static_cast<std::size_t>(state.next)] = state.bin;
    state.next = (state.next + 1) % kBins;
    state.bin.setZero();
    state.inBin_s = 0.0;
    Eigen::VectorXd second = Eigen::VectorXd::Zero(state.bin.size());
    for (const Eigen::VectorXd& one : state.bins)
        second += one;
    Eigen::Index at = 0;
    if (second.size() == 0) return;
    state.mostEach_Pa2 = state.mostEach_Pa2.cwiseMax(second / (kBins * kBin_s));
    const double most_Pa2 = second.maxCoeff(&at) / (kBins * kBin_s);
    if (!(most_Pa2 > state.most_Pa2)) return;
    state.most_Pa2 = most_Pa2;
    state.mostAt = state.places.col(at);
}

void ExposureMeter::advance(State& state, double now_s)
{
    double left_s = std::max(0.0, now_s - state.now_s);
    state.now_s = std::max(state.now_s, now_s);
    state.sum += left_s * state.square_Pa2;
    // After a second of constant sound, further seconds are equal.
    constexpr double kSteady_s = 2.0 * kBins * kBin_s;
    if (left_s > 2.0 * kSteady_s) left_s = kSteady_s;
    while (left_s > 0.0)
    {
        const double step_s = std::min(left_s, kBin_s - state.inBin_s);
        state.bin += step_s * state.square_Pa2;
        state.inBin_s += step_s;
        left_s -= step_s;
        if (state.inBin_s > kBin_s * (1.0 - 1e-9)) closeBin(state);
    }
}

void ExposureMeter::play(double now_s,
                         const Eigen::Matrix3Xd& places,
                         const Eigen::VectorXd& square_Pa2,
                         Eigen::Index unnamed)
{
    const base::Lock lock(_mutex);
    if (_state.places.cols() != places.cols())
    {
        _state = State();
        _state.start_s = _state.now_s = now_s;
        for (Eigen::VectorXd* one :
             {&_state.square_Pa2, &_state.sum, &_state.bin, &_state.mostEach_Pa2})
            one->setZero(places.cols());
        for (Eigen::VectorXd& one : _state.bins)
            one.setZero(places.cols());
    }
    advance(_state, now_s);
    _state.places = places;
    _state.unnamed = unnamed;
    _state.square_Pa2 = square_Pa2.unaryExpr(
        [](double one) { return one >= 0.0 ? one : std::numeric_limits<double>::infinity(); });
}

ExposureFigures ExposureMeter::read(double now_s) const
{
    State state;
    {
        const base::Lock lock(_mutex);
        state = _state;
    }
    ExposureFigures figures;
    figures.places = static_cast<int>(state.places.cols());
    if (figures.places == 0) return figures;
    advance(state, now_s);
    figures.time_s = state.now_s - state.start_s;
    figures.level_dB = soundLevel_dB(state.square_Pa2.maxCoeff());
    Eigen::Index at = 0;
    const double mean_Pa2 = figures.time_s > 0.0 ? state.sum.maxCoeff(&at) / figures.time_s : 0.0;
    if (mean_Pa2 > 0.0) figures.eq_dB = soundLevel_dB(mean_Pa2);
    constexpr double kDay_s = 8.0 * 3600.0;
    figures.day_dB = soundLevel_dB(mean_Pa2 * figures.time_s / kDay_s);
    // Before the first second is over, its mean so far is the maximum.
    if (figures.time_s < kBins * kBin_s && mean_Pa2 > state.most_Pa2)
    {
        state.most_Pa2 = mean_Pa2;
        state.mostAt = state.places.col(at);
    }
    figures.max_dB = soundLevel_dB(state.most_Pa2);
    figures.x_m = state.mostAt.x();
    figures.y_m = state.mostAt.y();
    figures.z_m = state.mostAt.z();
    return figures;
}

std::vector<PlaceExposure> ExposureMeter::readEach(double now_s) const
{
    State state;
    {
        const base::Lock lock(_mutex);
        state = _state;
    }
    if (state.places.cols() == 0) return {};
    advance(state, now_s);
    const double time_s = state.now_s - state.start_s;
    std::vector<PlaceExposure> each;
    for (Eigen::Index l = state.unnamed; l < state.places.cols(); ++l)
    {
        const double mean_Pa2 = time_s > 0.0 ? state.sum[l] / time_s : 0.0;
        // As for all places: the first second's mean so far is the maximum.
        const double most_Pa2 = time_s < kBins * kBin_s ? std::max(mean_Pa2, state.mostEach_Pa2[l])
                                                        : state.mostEach_Pa2[l];
        each.push_back({state.places(0, l),
                        state.places(1, l),
                        state.places(2, l),
                        soundLevel_dB(state.square_Pa2[l]),
                        soundLevel_dB(mean_Pa2),
                        soundLevel_dB(most_Pa2)});
    }
    return each;
}

} // namespace midair::haptics
