#include "haptics/sequence/CycleEqualizer.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/text/Range.h"
#include "haptics/propagation/RingingMean.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

// Explained in haptics/SOLVER.md, "Fields in turn".
constexpr float kFirstTurn = 0.1f;       // rad, rms; the first step of steepest descent
constexpr double kLeastShare = 1e-3;     // of a step, at which the search along it ends
constexpr double kArmijo = 1e-4;         // share of the slope that a step must gain
constexpr double kEven = 1e-4;           // f at which the fields are even enough
constexpr int kLookEvery = 5;            // passes between two looks at the mean
constexpr double kMostRaise = 1.1;       // largest factor on the goal at such a look
constexpr int kRowsAtOnce = 128;         // with the block's width a quarter of a level-2 cache
constexpr std::size_t kFieldsAtOnce = 8; // of a slice

} // namespace

bool CycleEqualizerOptions::isValid(std::string* error) const
{
    return base::RangeCheck()
        .atLeast("passes", passes, 0)
        .above("raise", raise, 0.0)
        .above("ringingRaise", ringingRaise, 0.0)
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
    _rows.clear();
    for (int l = 0; l < places.size(); ++l)
        if (places.targets[l] > 0.0) _rows.push_back(l);
    const auto n = static_cast<Eigen::Index>(_rows.size());
    const bool isTooMuch =
        _rows.size() * static_cast<std::size_t>(array.size()) > base::kMostEntries;
    if (n == 0 || isTooMuch || _fields.size() < 2 || sounding.empty()) return false;

    _matrix.bind(array, medium);
    _matrix.resize(static_cast<int>(n));
    _drive = array.drive;
    _targets2.resize(n);
    for (Eigen::Index l = 0; l < n; ++l)
    {
        int& row = _rows[static_cast<std::size_t>(l)];
        _targets2[l] = static_cast<float>(places.targets[row] * places.targets[row]);
        _matrix.setPoint(static_cast<int>(l), places.positions.col(row));
        row = static_cast<int>(l);
    }
    // Only their ratios count, and squares of Pa would leave the range of floats behind.
    _targets2 /= _targets2.maxCoeff();
    _sounding.resize(sounding.size());
    for (std::size_t k = 0; k < sounding.size(); ++k)
        _sounding[k].index = sounding[k];
    _overlaps.resize(0);
    if (step_s > 0.0 && array.ringing_s > 0.0)
        _overlaps = ringingOverlaps(static_cast<int>(_fields.size()), step_s, array.ringing_s)
                        .cast<float>();
    reserve();
    _descent.forget();
    _passes = 0;
    _started = false;
    _given = _mean = _variation = 0.0;
    _block = 0;
    _next = Slice::BUILD;
    return true;
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
            const bool isPadding = lane >= _matrix.order().size();
            field.q.set(lane,
                        isPadding ? std::complex<float>()
                                  : _fields[field.index][_matrix.order()[lane]]);
        }
    }
    _sum.resize(static_cast<std::size_t>(_pool->threads()));
    for (SplitVector& sum : _sum)
        sum.reserve(PropagationMatrix::kBlockWidth);
    _rowSums.assign(n, 0.0);
    const auto unknowns = static_cast<Eigen::Index>(m * _sounding.size());
    _gradient.resize(unknowns);
    _intensity.resize(_matrix.points());
}

bool CycleEqualizer::step()
{
    if (!hasWork()) return false;
    _stop.throwIfRequested();
    if (_next == Slice::BUILD)
    {
        buildBlock(_block);
        if (++_block == _matrix.blocks()) beginForward();
        return true;
    }
    const std::size_t last = std::min(_first + kFieldsAtOnce, _sounding.size());
    const auto first = _first;
    _pool->run(
        [&](int thread)
        {
            // Each field belongs to one thread, so that its sums don't depend on their number.
            const auto share = [&](int t)
            { return first + (last - first) * std::size_t(t) / std::size_t(_pool->threads()); };
            if (_next == Slice::FORWARD)
                forwardBlock(share(thread), share(thread + 1));
            else
                backwardBlock(thread, share(thread), share(thread + 1));
        });
    _first = last;
    if (_first < _sounding.size()) return true;
    _first = 0;
    if (++_block < _matrix.blocks()) return true;
    if (_next == Slice::FORWARD)
        judge();
    else
        direct();
    return hasWork();
}

void CycleEqualizer::buildBlock(int block)
{
    _matrix.buildRows(block, _rows.data(), static_cast<int>(_rows.size()), _rowSums.data());
}

void CycleEqualizer::beginForward()
{
    _next = Slice::FORWARD;
    _block = 0;
    _first = 0;
    for (Field& field : _sounding)
    {
        std::fill_n(field.p.re.data(), _matrix.points(), 0.0f);
        std::fill_n(field.p.im.data(), _matrix.points(), 0.0f);
    }
}

// A few rows for all fields, then the next, so that they are read from the cache.
void CycleEqualizer::forwardBlock(std::size_t first, std::size_t last)
{
    const int width = _matrix.width(_block), i = _matrix.offset(_block);
    for (int l = 0; l < _matrix.points(); l += kRowsAtOnce)
        for (std::size_t k = first; k < last; ++k)
        {
            Field& field = _sounding[k];
            kernels::forward(_matrix.fixedData(_block) + std::ptrdiff_t(l) * width,
                             _matrix.fixedScale(_block) + l,
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
    _next = Slice::BACKWARD;
    _block = 0;
    _first = 0;
    const auto goal = static_cast<float>(_goal);
    for (Field& field : _sounding)
        for (Eigen::Index l = 0; l < _intensity.size(); ++l)
        {
            const auto row = static_cast<std::size_t>(l);
            const float r = _intensity[l] / (goal * _targets2[l]) - 1.0f;
            field.w.set(row, r * field.w.at(row));
        }
}

void CycleEqualizer::backwardBlock(int thread, std::size_t first, std::size_t last)
{
    const int width = _matrix.width(_block), i = _matrix.offset(_block);
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
            kernels::backward(_matrix.fixedData(_block) + std::ptrdiff_t(l) * width,
                              _matrix.fixedScale(_block) + l,
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

// After p = G q: the step is taken, or tried again shorter.
void CycleEqualizer::judge()
{
    const double mean = _mean, variation = _variation;
    const double f = evaluate();
    if (!_started)
    {
        _given = _mean;
        _f = f;
        if (!(_given > 0.0) || _options.passes == 0) return end();
        _started = true;
        return beginBackward();
    }
    if (!(f < _f + kArmijo * _share * _slope))
    {
        _mean = mean;
        _variation = variation;
        if (_share < kLeastShare)
        {
            turn(0.0); // stays where it was
            return end();
        }
        turn(0.5 * _share);
        return beginForward();
    }
    _f = f;
    ++_passes;
    if (_passes >= _options.passes || f < kEven) return end();
    if (_passes % kLookEvery == 0) keepUp();
    beginBackward();
}

// Where the array can't have both, pressure comes first.
void CycleEqualizer::keepUp()
{
    if (_mean >= _given) return;
    _goal *= std::min(kMostRaise, _given / _mean);
    _f = evaluate();
    _descent.forget();
    _share = 0.0; // nor is the last step remembered: its gradients are of different goals
}

// After z = G* (r p): with df/dphi_i^k = -(4 / (K g sum a^2)) Im(conj(z_i) q_i), the next direction
// and its first step.
void CycleEqualizer::direct()
{
    const auto m = static_cast<std::size_t>(_matrix.paddedTransducers());
    const double scale =
        4.0 / (static_cast<double>(_fields.size()) * _goal * static_cast<double>(_targets2.sum()));
    if (_passes > 0) _lastGradient.swap(_gradient);
    _gradient.resize(static_cast<Eigen::Index>(m * _sounding.size()));
    float* g = _gradient.data();
    for (const Field& field : _sounding)
    {
        const float *qRe = field.q.re.data(), *qIm = field.q.im.data();
        const float *zRe = field.z.re.data(), *zIm = field.z.im.data();
        for (std::size_t i = 0; i < m; ++i)
            *g++ = static_cast<float>(scale) * (zIm[i] * qRe[i] - zRe[i] * qIm[i]);
    }
    if (_passes > 0 && _lastGradient.size() == _gradient.size())
        _descent.remember(_direction, static_cast<float>(_share), _lastGradient, _gradient);
    _descent.direct(_gradient, _direction);
    if (_descent.isEmpty())
    {
        const float rms = _gradient.norm() / std::sqrt(static_cast<float>(_gradient.size()));
        if (!(rms > 0.0f)) return end();
        _direction *= kFirstTurn / rms;
    }
    _slope = static_cast<double>(_gradient.dot(_direction));
    if (!(_slope < 0.0)) return end();
    for (Field& field : _sounding)
        copy(field.q, field.kept, m);
    turn(1.0);
    beginForward();
}

// Turns the kept phases by \a share of the direction: multiplied by (1 + j d/2)/(1 - j d/2), which
// has modulus 1 without a sine; its angle is d for small d and never reaches half a turn.
void CycleEqualizer::turn(double share)
{
    _share = share;
    const auto m = static_cast<std::size_t>(_matrix.paddedTransducers());
    const float* d = _direction.data();
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

// A trial may be under way; what was accepted is kept then.
std::vector<Eigen::VectorXcf> CycleEqualizer::fields() const
{
    std::vector<Eigen::VectorXcf> fields = _fields;
    const int m = _matrix.paddedTransducers();
    SplitVector played;
    played.reserve(static_cast<std::size_t>(m));
    for (const Field& field : _sounding)
    {
        const SplitVector& q = _next == Slice::FORWARD && _started ? field.kept : field.q;
        kernels::quantisePhase(
            m, _drive.phaseLevels, q.re.data(), q.im.data(), played.re.data(), played.im.data());
        Eigen::VectorXcf& to = fields[field.index];
        for (std::size_t lane = 0; lane < _matrix.order().size(); ++lane)
        {
            std::complex<float>& one = to[_matrix.order()[lane]];
            one = std::abs(one) * played.at(lane);
        }
    }
    return fields;
}

} // namespace midair::haptics
