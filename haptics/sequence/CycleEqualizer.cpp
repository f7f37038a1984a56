#include "haptics/sequence/CycleEqualizer.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/text/Range.h"
#include "haptics/propagation/RingingMean.h"
#include "haptics/sequence/FieldOrder.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

namespace midair::haptics
{

namespace
{

// Explained in haptics/SOLVER.md, "Fields in turn".
constexpr float kFirstTurn = 0.1f;       // rad, rms; the first step of steepest descent
constexpr double kLeastStepShare = 1e-3; // of a step, at which the line search ends
constexpr double kArmijo = 1e-4;         // required gain, as a share of the slope
constexpr double kEven = 1e-4;           // value of f at which the fields are even enough
constexpr int kLookEvery = 5;            // passes between two checks of the mean
constexpr double kMostRaise = 1.1;       // largest factor on the goal per check
constexpr int kLookHeldEvery = 25;       // the same for a single field
constexpr double kMostTurn = 1.02;
constexpr double kNearGain = 0.004; // relative; the goal of a single field stays
// The first passes of a single field fill its holes, with log^2(r + 1 + kFloor) in place of r^2.
constexpr int kFillPasses = 40;
constexpr int kFillShare = 8; // at most an eighth of all passes
constexpr double kFloor = 0.03;
constexpr int kRowsAtOnce = 128;         // with the block's width a quarter of a level-2 cache
constexpr std::size_t kFieldsAtOnce = 8; // of a slice

CycleEqualizerOptions withPasses(int passes)
{
    CycleEqualizerOptions options;
    options.passes = passes;
    return options;
}

} // namespace

std::vector<double> placeSpacings(int fields)
{
    std::vector<double> spacings(kPlaceSpacings.begin(), kPlaceSpacings.end());
    if (fields <= kFewFields) spacings.insert(spacings.begin(), kClosePlaceSpacing);
    return spacings;
}

bool CycleEqualizerOptions::isValid(std::string* error) const
{
    return base::RangeCheck()
        .atLeast("passes", passes, 0)
        .above("raise", raise, 0.0)
        .above("ringingRaise", ringingRaise, 0.0)
        .above("fewRaise", fewRaise, 0.0)
        .above("heldRaise", heldRaise, 0.0)
        .atLeast("calming", calming, 0.0)
        .passed(error);
}

CycleEqualizer::CycleEqualizer(const CycleEqualizerOptions& options, const SolverOptions& solver) :
    _options(options),
    _pool(solver.pool ? solver.pool
                      : std::make_shared<base::ThreadPool>(std::max(solver.threads, 1))),
    _stop(solver.stop)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError("evening a cycle out: " + error);
}

bool CycleEqualizer::begin(const ControlPoints& places,
                           const TransducerArray& array,
                           const Medium& medium,
                           std::vector<Eigen::VectorXcf> fields,
                           double step_s)
{
    end();
    _fields = std::move(fields);
    std::vector<std::size_t> sounding;
    for (std::size_t k = 0; k < _fields.size(); ++k)
        if (!_fields[k].isZero(0.0f)) sounding.push_back(k);
    _places.rows.clear();
    for (int l = 0; l < places.size(); ++l)
        if (places.targets[l] > 0.0) _places.rows.push_back(l);
    const auto n = static_cast<Eigen::Index>(_places.rows.size());
    const bool isTooMuch =
        _places.rows.size() * static_cast<std::size_t>(array.size()) > base::kMostEntries;
    if (n == 0 || isTooMuch || sounding.empty()) return false;

    _matrix.bind(array, medium);
    _matrix.resize(static_cast<int>(n));
    _drive = array.drive;
    _places.targets2.resize(n);
    for (Eigen::Index l = 0; l < n; ++l)
    {
        int& row = _places.rows[static_cast<std::size_t>(l)];
        _places.targets2[l] = static_cast<float>(places.targets[row] * places.targets[row]);
        _matrix.setPoint(static_cast<int>(l), places.positions.col(row));
        row = static_cast<int>(l);
    }
    // Only their ratios count, and squares of Pa would exceed the range of floats.
    _places.targets2 /= _places.targets2.maxCoeff();
    _sounding.resize(sounding.size());
    for (std::size_t k = 0; k < sounding.size(); ++k)
        _sounding[k].index = sounding[k];
    _ringing = {};
    if (_fields.size() > 1 && step_s > 0.0 && array.ringing_s > 0.0)
        bindRinging(places, step_s, array.ringing_s);
    reserve();
    _descent.newton.forget();
    _descent.passes = 0;
    _descent.isStarted = false;
    _descent.fillPasses =
        _fields.size() == 1 ? std::min(kFillPasses, _options.passes / kFillShare) : 0;
    _evenness = {};
    _at.block = 0;
    _at.slice = Slice::BUILD;
    return true;
}

bool CycleEqualizer::resume(const ControlPoints& places,
                            const TransducerArray& array,
                            const Medium& medium,
                            std::vector<Eigen::VectorXcf> fields,
                            double step_s)
{
    const Evenness before = _evenness;
    if (!begin(places, array, medium, std::move(fields), step_s)) return false;
    _descent.fillPasses = 0;
    _evenness.goal = before.goal;
    _evenness.given = before.given;
    return true;
}

void CycleEqualizer::bindRinging(const ControlPoints& places, double step_s, double ringing_s)
{
    const auto K = static_cast<int>(_fields.size());
    _ringing.overlaps = ringingOverlaps(K, step_s, ringing_s).cast<float>();
    _ringing.p.assign(_fields.size(), {});
    _ringing.w = _ringing.p;
    if (K > kFewFields) return;
    Eigen::Matrix3Xd wanted(3, places.size());
    Eigen::Index n = 0;
    for (int l = 0; l < places.size(); ++l)
        if (places.targets[l] > 0.0) wanted.col(n++) = places.positions.col(l);
    _ringing.vibration = CycleVibration(wanted.leftCols(n), K, step_s, ringing_s);
}

void CycleEqualizer::reserve()
{
    const auto m = static_cast<std::size_t>(_matrix.paddedTransducers());
    const auto n = static_cast<std::size_t>(_matrix.points());
    for (Field& field : _sounding)
    {
        for (SplitVector* v : {&field.q, &field.kept, &field.z})
            v->reserve(m);
        for (SplitVector* v : {&field.p, &field.w})
            v->reserve(n);
        for (std::size_t lane = 0; lane < m; ++lane)
        {
            const bool isPadding =
                lane >= _matrix.order().size() || _matrix.isFiller(static_cast<int>(lane));
            field.q.set(lane,
                        isPadding ? std::complex<float>()
                                  : _fields[field.index][_matrix.order()[lane]]);
        }
    }
    _sum.resize(static_cast<std::size_t>(_pool->threads()));
    for (SplitVector& sum : _sum)
        sum.reserve(PropagationMatrix::kBlockWidth);
    _places.rowSums.assign(n, 0.0);
    const auto unknowns = static_cast<Eigen::Index>(m * _sounding.size());
    _descent.gradient.resize(unknowns);
    _places.intensity.resize(_matrix.points());
}

bool CycleEqualizer::step()
{
    if (!hasWork()) return false;
    _stop.throwIfRequested();
    if (_at.slice == Slice::BUILD)
    {
        buildBlock(_at.block);
        if (++_at.block == _matrix.blocks()) beginForward();
        return true;
    }
    const std::size_t last = std::min(_at.field + kFieldsAtOnce, _sounding.size());
    const auto first = _at.field;
    _pool->run(
        [&](int thread)
        {
            // Each field belongs to one thread, so that its sums don't depend on the number of
            // threads.
            const auto share = [&](int t)
            { return first + (last - first) * std::size_t(t) / std::size_t(_pool->threads()); };
            if (_at.slice == Slice::FORWARD)
                forwardBlock(share(thread), share(thread + 1));
            else
                backwardBlock(thread, share(thread), share(thread + 1));
        });
    _at.field = last;
    if (_at.field < _sounding.size()) return true;
    _at.field = 0;
    if (++_at.block < _matrix.blocks()) return true;
    if (_at.slice == Slice::FORWARD)
        judge();
    else
        direct();
    return hasWork();
}

double CycleEqualizer::vibration() const
{
    if (!(_evenness.mean > 0.0)) return 0.0;
    return std::sqrt(_evenness.vibration2) * _evenness.goal / _evenness.mean;
}

double CycleEqualizer::raise() const
{
    if (_fields.size() == 1) return _options.heldRaise;
    if (_ringing.overlaps.size() == 0) return _options.raise;
    return _fields.size() <= kFewFields ? _options.fewRaise : _options.ringingRaise;
}

void CycleEqualizer::buildBlock(int block)
{
    _matrix.buildRows(
        block, _places.rows.data(), static_cast<int>(_places.rows.size()), _places.rowSums.data());
}

void CycleEqualizer::beginForward()
{
    _at.slice = Slice::FORWARD;
    _at.block = 0;
    _at.field = 0;
    for (Field& field : _sounding)
    {
        std::fill_n(field.p.re.data(), _matrix.points(), 0.0f);
        std::fill_n(field.p.im.data(), _matrix.points(), 0.0f);
    }
}

// A few rows for all fields, then the next, so that they are read from the cache.
void CycleEqualizer::forwardBlock(std::size_t first, std::size_t last)
{
    const int width = _matrix.width(_at.block), i = _matrix.offset(_at.block);
    for (int l = 0; l < _matrix.points(); l += kRowsAtOnce)
        for (std::size_t k = first; k < last; ++k)
        {
            Field& field = _sounding[k];
            kernels::forward(_matrix.fixedData(_at.block) + std::ptrdiff_t(l) * width,
                             _matrix.fixedScale(_at.block) + l,
                             std::min(kRowsAtOnce, _matrix.points() - l),
                             width,
                             width,
                             field.q.re.data() + i,
                             field.q.im.data() + i,
                             field.p.re.data() + l,
                             field.p.im.data() + l);
        }
}

void CycleEqualizer::beginBackward()
{
    _at.slice = Slice::BACKWARD;
    _at.block = 0;
    _at.field = 0;
    const auto goal = static_cast<float>(_evenness.goal);
    const auto floor = static_cast<float>(kFloor);
    const Eigen::ArrayXf x = _places.intensity.array() / (goal * _places.targets2.array());
    Eigen::ArrayXf slope = x - 1.0f; // half the derivative of f's addend
    if (_descent.fillPasses > 0)
    {
        const Eigen::ArrayXf filled = (x + floor) / (1.0f + floor);
        slope = (1.0f + floor) * filled.log() / filled;
    }
    for (Field& field : _sounding)
        for (Eigen::Index l = 0; l < slope.size(); ++l)
        {
            const auto row = static_cast<std::size_t>(l);
            field.w.set(row, slope[l] * field.w.at(row));
        }
    if (_ringing.vibration.isEmpty()) return;
    // The gradient is that of the unevenness, 4/(K g sum a^2) Re sum conj(dp) w.
    const auto factor =
        static_cast<float>(0.25 * _options.calming * static_cast<double>(_fields.size()) *
                           static_cast<double>(_places.targets2.size()) * meanGoal());
    for (Eigen::Index l = 0; l < _places.intensity.size(); ++l)
    {
        const auto row = static_cast<std::size_t>(l);
        gatherPressures(row);
        for (const Field& field : _sounding)
            _ringing.w[field.index] = field.w.at(row);
        _ringing.vibration.addTo(l, factor, _ringing.p, _ringing.w);
        for (Field& field : _sounding)
            field.w.set(row, _ringing.w[field.index]);
    }
}

void CycleEqualizer::gatherPressures(std::size_t place)
{
    for (const Field& field : _sounding)
        _ringing.p[field.index] = field.p.at(place);
}

// The mean of |p|^2 at the goal.
double CycleEqualizer::meanGoal() const
{
    return _evenness.goal * static_cast<double>(_places.targets2.mean());
}

void CycleEqualizer::backwardBlock(int thread, std::size_t first, std::size_t last)
{
    const int width = _matrix.width(_at.block), i = _matrix.offset(_at.block);
    SplitVector& sum = _sum[static_cast<std::size_t>(thread)];
    for (std::size_t k = first; k < last; ++k)
    {
        std::fill_n(_sounding[k].z.re.data() + i, width, 0.0f);
        std::fill_n(_sounding[k].z.im.data() + i, width, 0.0f);
    }
    for (int l = 0; l < _matrix.points(); l += kRowsAtOnce)
        for (std::size_t k = first; k < last; ++k)
        {
            Field& field = _sounding[k];
            kernels::backward(_matrix.fixedData(_at.block) + std::ptrdiff_t(l) * width,
                              _matrix.fixedScale(_at.block) + l,
                              std::min(kRowsAtOnce, _matrix.points() - l),
                              width,
                              field.w.re.data() + l,
                              field.w.im.data() + l,
                              sum.re.data(),
                              sum.im.data());
            float *re = field.z.re.data() + i, *im = field.z.im.data() + i;
            for (int t = 0; t < width; ++t)
            {
                re[t] += sum.re.data()[t];
                im[t] += sum.im.data()[t];
            }
        }
}

// After p = G q: accepts the step, or retries a shorter one.
void CycleEqualizer::judge()
{
    const Evenness before = _evenness;
    const double f = evaluate();
    if (!_descent.isStarted)
    {
        if (!(_evenness.given > 0.0)) _evenness.given = _evenness.mean;
        _descent.f = f;
        if (!(_evenness.given > 0.0) || _options.passes == 0) return end();
        _descent.isStarted = true;
        return beginBackward();
    }
    if (!(f < _descent.f + kArmijo * _descent.share * _descent.slope))
    {
        _evenness = before;
        if (_descent.share < kLeastStepShare)
        {
            turn(0.0); // stays at the last step
            if (_descent.fillPasses == 0) return end();
            _descent.fillPasses = 0;
            _descent.newton.forget();
            _descent.isStarted = false;
            return beginForward();
        }
        turn(0.5 * _descent.share);
        return beginForward();
    }
    _descent.f = f;
    ++_descent.passes;
    if (_descent.passes >= _options.passes || f < kEven) return end();
    keepUp();
    beginBackward();
}

// Changes the goal, if the mean is not where it should be. If the array can't have both, pressure
// has precedence over evenness; a single field gives all pressure above the given for it, but for
// the first passes, in which its mean falls and returns.
bool CycleEqualizer::keepsUp()
{
    if (_descent.fillPasses > 0 && --_descent.fillPasses == 0) return false; // f changes
    if (_fields.size() == 1)
    {
        const double missing = kHeldGain * _evenness.given / _evenness.mean;
        if (_descent.passes < 2 * kLookHeldEvery || _descent.passes % kLookHeldEvery != 0 ||
            std::fabs(missing - 1.0) < kNearGain)
            return true;
        _evenness.goal *= std::clamp(missing, 1.0 / kMostTurn, kMostTurn);
        return false;
    }
    if (_descent.passes % kLookEvery != 0 || _evenness.mean >= _evenness.given) return true;
    _evenness.goal *= std::min(kMostRaise, _evenness.given / _evenness.mean);
    return false;
}

void CycleEqualizer::keepUp()
{
    if (keepsUp()) return;
    _descent.f = evaluate();
    _descent.newton.forget();
    _descent.share = 0.0; // the last step isn't stored: its gradients are of different goals
}

// After z = G* (r p): computes, with df/dphi_i^k = -(4 / (K g sum a^2)) Im(conj(z_i) q_i), the next
// direction and its first step.
void CycleEqualizer::direct()
{
    const auto m = static_cast<std::size_t>(_matrix.paddedTransducers());
    const double scale = 4.0 / (static_cast<double>(_fields.size()) * _evenness.goal *
                                static_cast<double>(_places.targets2.sum()));
    if (_descent.passes > 0) _descent.lastGradient.swap(_descent.gradient);
    _descent.gradient.resize(static_cast<Eigen::Index>(m * _sounding.size()));
    float* g = _descent.gradient.data();
    for (const Field& field : _sounding)
    {
        const float *qRe = field.q.re.data(), *qIm = field.q.im.data();
        const float *zRe = field.z.re.data(), *zIm = field.z.im.data();
        for (std::size_t i = 0; i < m; ++i)
            *g++ = static_cast<float>(scale) * (zIm[i] * qRe[i] - zRe[i] * qIm[i]);
    }
    if (_descent.passes > 0 && _descent.lastGradient.size() == _descent.gradient.size())
        _descent.newton.remember(_descent.direction,
                                 static_cast<float>(_descent.share),
                                 _descent.lastGradient,
                                 _descent.gradient);
    _descent.newton.direct(_descent.gradient, _descent.direction);
    if (_descent.newton.isEmpty())
    {
        const float rms =
            _descent.gradient.norm() / std::sqrt(static_cast<float>(_descent.gradient.size()));
        if (!(rms > 0.0f)) return end();
        _descent.direction *= kFirstTurn / rms;
    }
    _descent.slope = static_cast<double>(_descent.gradient.dot(_descent.direction));
    if (!(_descent.slope < 0.0)) return end();
    for (Field& field : _sounding)
        copy(field.q, field.kept, m);
    turn(1.0);
    beginForward();
}

// Turns the kept phases by \a share of the direction: multiplies by (1 + j d/2)/(1 - j d/2), which
// has modulus 1 without a sine; its angle is d for small d and never reaches half a turn.
void CycleEqualizer::turn(double share)
{
    _descent.share = share;
    const auto m = static_cast<std::size_t>(_matrix.paddedTransducers());
    const float* d = _descent.direction.data();
    for (Field& field : _sounding)
    {
        float *qRe = field.q.re.data(), *qIm = field.q.im.data();
        const float *fromRe = field.kept.re.data(), *fromIm = field.kept.im.data();
        for (std::size_t i = 0; i < m; ++i)
        {
            const float h = 0.5f * static_cast<float>(share) * *d++;
            const float scale = 1.0f / (1.0f + h * h);
            const float c = (1.0f - h * h) * scale, s = 2.0f * h * scale;
            qRe[i] = fromRe[i] * c - fromIm[i] * s;
            qIm[i] = fromRe[i] * s + fromIm[i] * c;
        }
    }
}

// During a trial the accepted phases are in the kept ones.
std::vector<Eigen::VectorXcf> CycleEqualizer::fields(int phaseLevels) const
{
    std::vector<Eigen::VectorXcf> fields = _fields;
    const int m = _matrix.paddedTransducers();
    SplitVector played;
    played.reserve(static_cast<std::size_t>(m));
    for (const Field& field : _sounding)
    {
        const SplitVector& q =
            _at.slice == Slice::FORWARD && _descent.isStarted ? field.kept : field.q;
        kernels::quantisePhase(
            m, phaseLevels, q.re.data(), q.im.data(), played.re.data(), played.im.data());
        Eigen::VectorXcf& to = fields[field.index];
        for (std::size_t lane = 0; lane < _matrix.order().size(); ++lane)
        {
            if (_matrix.isFiller(static_cast<int>(lane))) continue;
            std::complex<float>& one = to[_matrix.order()[lane]];
            one = std::abs(one) * played.at(lane);
        }
    }
    return fields;
}

// Sets the sums of |p|^2, and w = p.
void CycleEqualizer::sumSteady()
{
    _places.intensity.setZero();
    for (Field& field : _sounding)
    {
        for (Eigen::Index l = 0; l < _places.intensity.size(); ++l)
            _places.intensity[l] += std::norm(field.p.at(static_cast<std::size_t>(l)));
        copy(field.p, field.w, static_cast<std::size_t>(_matrix.points()));
    }
}

// Sets the sums of p* M p, and w = M p. Most fields are too far apart to overlap.
void CycleEqualizer::sumRinging()
{
    constexpr float kNothing = 1e-6f; // of the mean
    const Eigen::VectorXf& overlaps = _ringing.overlaps;
    const auto K = static_cast<std::size_t>(overlaps.size());
    std::vector<std::size_t> apart;
    for (std::size_t d = 0; d < K; ++d)
        if (std::abs(overlaps[static_cast<Eigen::Index>(d)]) > kNothing) apart.push_back(d);
    const CycleVibration::Pressures& p = _ringing.p;
    for (Eigen::Index row = 0; row < _places.intensity.size(); ++row)
    {
        const auto l = static_cast<std::size_t>(row);
        gatherPressures(l);
        if (!_ringing.vibration.isEmpty()) _ringing.vibration.set(row, p);
        float sum = 0.0f;
        for (Field& field : _sounding)
        {
            std::complex<float> w = 0.0f;
            for (const std::size_t d : apart)
                w += overlaps[static_cast<Eigen::Index>(d)] * p[(field.index + d) % K];
            field.w.set(l, w);
            sum += std::real(std::conj(field.p.at(l)) * w);
        }
        _places.intensity[row] = sum;
    }
}

// Sets the intensities, their mean and variation from p; returns f.
double CycleEqualizer::evaluate()
{
    if (_ringing.overlaps.size() > 0)
        sumRinging();
    else
        sumSteady();
    _places.intensity /= static_cast<float>(_fields.size());
    const Eigen::ArrayXd weight = _places.targets2.cast<double>();
    const Eigen::ArrayXd ratio = _places.intensity.cast<double>().array() / weight;
    const double all = weight.sum();
    _evenness.mean = (weight * ratio).sum() / all;
    _evenness.variation =
        _evenness.mean > 0.0
            ? std::sqrt((weight * (ratio - _evenness.mean).square()).sum() / all) / _evenness.mean
            : 0.0;
    if (!(_evenness.goal > 0.0)) _evenness.goal = raise() * _evenness.mean;
    // About the mean, because the two parts are known separately: ratio/goal - 1 = (ratio -
    // mean)/goal + ..
    const double spread = _evenness.variation * _evenness.mean / _evenness.goal,
                 off = _evenness.mean / _evenness.goal - 1.0;
    _evenness.vibration2 = _ringing.vibration.squared(meanGoal());
    if (_descent.fillPasses > 0)
        return (weight * ((ratio / _evenness.goal + kFloor) / (1.0 + kFloor)).log().square())
                   .sum() /
               all * (1.0 + kFloor) * (1.0 + kFloor);
    return spread * spread + off * off + _options.calming * _evenness.vibration2;
}

EvenedCycle::EvenedCycle(int passes, int steps, const SolverOptions& solver) :
    _equalizer(withPasses(passes), solver),
    _passes(passes),
    _steps(steps)
{
}

bool EvenedCycle::begin(const FieldSequence& cycle,
                        const ControlPoints& places,
                        const TransducerArray& array,
                        const Medium& medium)
{
    _isResumed = false;
    return start(cycle, places, array, medium);
}

bool EvenedCycle::resume(const FieldSequence& held,
                         const ControlPoints& places,
                         const TransducerArray& array,
                         const Medium& medium)
{
    _isResumed = held.isHeld() && _cycle.isHeld() &&
                 _cycle.fields.front().size() == held.fields.front().size();
    return _isResumed && start(held, places, array, medium);
}

bool EvenedCycle::start(const FieldSequence& cycle,
                        const ControlPoints& places,
                        const TransducerArray& array,
                        const Medium& medium)
{
    end();
    const auto stride = static_cast<std::size_t>(cycle.isHeld() ? 1 : _steps + 1);
    const bool isCycle = cycle.fields.size() > stride && cycle.fields.size() % stride == 0;
    if (_passes == 0 || !(cycle.isHeld() || isCycle)) return false;
    for (const ControlPoints& part : cycle.parts)
        if (part.size() > 0 && part.absolute) return false;
    std::vector<Eigen::VectorXcf> fields;
    for (std::size_t k = 0; k < cycle.fields.size(); k += stride)
        fields.push_back(cycle.fields[k]);
    // With steps between the fields almost nothing rings.
    const double step_s = _steps == 0 ? 1.0 / cycle.modulation.fieldRate_Hz : 0.0;
    const auto K = static_cast<int>(fields.size());
    _equalizer.setPasses(K <= kFewFields && !_isResumed ? kFewPasses * _passes / K : _passes);
    const bool isBegun =
        _isResumed ? _equalizer.resume(places, array, medium, _equalizer.unroundedFields(), step_s)
                   : _equalizer.begin(places, array, medium, std::move(fields), step_s);
    if (!isBegun) return false;
    _cycle = cycle;
    _drive = array.drive;
    _ringing_s = array.ringing_s;
    _handedOut = 0.0;
    _seen = 0;
    return true;
}

std::optional<FieldSequence> EvenedCycle::step()
{
    if (!hasWork()) return std::nullopt;
    _equalizer.step();
    const double now = _equalizer.variation();
    if (_equalizer.passes() == 0) _handedOut = now; // that of the given cycle, when known
    if (_equalizer.passes() == _seen && hasWork()) return std::nullopt;
    _seen = _equalizer.passes();
    if (_isResumed) return hasWork() ? std::nullopt : std::optional(made());
    if (_seen == 0 || _equalizer.gain() < kLeastGain) return std::nullopt;
    const double worthIt = _cycle.isHeld() ? kHeldWorthIt : kWorthIt;
    if (now >= (hasWork() ? worthIt : 1.0) * _handedOut) return std::nullopt;
    _handedOut = now;
    return made();
}

FieldSequence EvenedCycle::made() const
{
    FieldSequence cycle = _cycle;
    // Not aligned again: that would gain at most 5 % of driveChange, and turn fields that play.
    cycle.fields = smoothedFields(_equalizer.fields(), _steps, _drive);
    cycle.evened = true;
    rateSteps(cycle);
    rateRinging(cycle, _ringing_s);
    return cycle;
}

} // namespace midair::haptics
