#include "haptics/solvers/production/ShapedRounding.h"

#include "haptics/base/Units.h"
#include "haptics/propagation/kernels/ShapingKernels.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

// SOLVER.md, "Rounding".
constexpr int kCoarse = 64;            // fewer levels are not linearised
constexpr float kMostEntries = 4.0e6f; // of the columns, 16 MB
constexpr float kQuieterThan = 20.0f;  // times the rounding error; targets below it count twice

bool isCoarse(const FieldProblem& field)
{
    return field.drive().phaseLevels <= kCoarse;
}

} // namespace

// Coarse levels are rare, and their arrays small: all their transducers are shaped.
int ShapedRounding::first(const FieldProblem& field, int block, const Effort& effort)
{
    const float most =
        kMostEntries / (static_cast<float>(field.n()) * static_cast<float>(field.m()));
    const float wanted = isCoarse(field) && effort.share > 0.0f ? 1.0f : effort.share;
    const float share = std::min(wanted, most);
    const int kept =
        static_cast<int>(std::ceil((1.0f - share) * static_cast<float>(field.G.width(block))));
    return (kept + kernels::kLanes - 1) / kernels::kLanes * kernels::kLanes;
}

// The coarse kernel takes whole levels, beside the nearest one.
float ShapedRounding::reach(const FieldProblem& field, const Effort& effort)
{
    if (!isCoarse(field)) return std::ceil(effort.reach);
    return std::min(2.0f, std::floor(0.5f * static_cast<float>(field.drive().phaseLevels)));
}

// Weights points by their yards, but none by more than a kShapingGroup-th of all: transducers that
// choose simultaneously would all correct its error. Points count twice if rounding orthogonal to
// their pressure is not far below it; coarse levels are chosen by the complex p.
void ShapedRounding::weigh(const FieldProblem& field, const QuietPoints& quiet)
{
    _yard = quiet.yard();
    _twice.clear();
    const float sum = field.a.array().max(QuietPoints::kQuiet).square().inverse().sum();
    const float least = std::sqrt(static_cast<float>(kernels::kShapingGroup) / sum);
    for (const int l : quiet.points())
        _yard[l] = std::max(_yard[l], std::min(least, QuietPoints::kQuiet));
    if (isCoarse(field) || !quiet.any()) return;
    const float most = kQuieterThan * quiet.disturbance(field, 1.0f);
    for (const int l : quiet.twice())
        if (field.a[l] < most) _twice.push_back(l);
}

void ShapedRounding::reserve(const FieldProblem& field, const Effort& effort)
{
    constexpr int kLanes = kernels::kShapingLanes;
    _equations.choose(field, _twice);
    _rows.stride = (_equations.rows() + kLanes - 1) / kLanes * kLanes;
    _parts.clear();
    _lanes.count = 0;
    for (int block = 0; block < field.G.blocks(); ++block)
    {
        const int begin = first(field, block, effort);
        _parts.push_back(
            {field.G.offset(block) + begin, field.G.width(block) - begin, _lanes.count});
        _lanes.count += _parts.back().count;
    }
    const auto count = static_cast<std::size_t>(_lanes.count),
               stride = static_cast<std::size_t>(_rows.stride);
    _columns.first.reserveUnset(count * stride);
    if (isCoarse(field)) _columns.second.reserveUnset(count * stride);
    for (base::AlignedBuffer<float>* v :
         {&_columns.square, &_lanes.wanted, &_lanes.level, &_lanes.amplitude})
        v->reserve(count);
    _lanes.drive.reserve(count);
    _rows.error.reserve(stride);
    _rows.aim.reserve(stride);
    _rows.p.reserve(stride);
    _factor.reserve(stride * static_cast<std::size_t>(field.threads()));
    _change.reserve(static_cast<std::size_t>(field.G.paddedTransducers()));
}

// Computes the factors that convert the rows of one block into units of the yards: with \a turned,
// times conj(u_l), so that the real part is along p_l.
void ShapedRounding::findFactors(
    const FieldProblem& field, int thread, int block, float s, bool turned)
{
    const float* scale = field.G.fixedScale(block);
    const std::size_t part =
        static_cast<std::size_t>(thread) * static_cast<std::size_t>(_rows.stride);
    float *re = _factor.re.data() + part, *im = _factor.im.data() + part;
    for (int k = 0; k < _equations.rows(); ++k)
    {
        const auto row = static_cast<std::size_t>(k);
        const int l = _equations.point(k);
        const float yard = k < field.n() ? _yard[l] : QuietPoints::kQuiet;
        const float factor = scale[l] / (s * yard);
        re[k] = turned ? factor * _equations.u.re[row] : factor;
        im[k] = turned ? -factor * _equations.u.im[row] : 0.0f;
    }
}

void ShapedRounding::formColumns(const FieldProblem& field,
                                 int thread,
                                 int block,
                                 const float* qRe,
                                 const float* qIm,
                                 base::AlignedBuffer<float>& columns)
{
    const Part& part = _parts[static_cast<std::size_t>(block)];
    const auto stride = static_cast<std::size_t>(_rows.stride);
    int width = 0;
    const std::int32_t* G = _equations.gather(
        field, thread, block, part.lane - field.G.offset(block), part.count, width);
    kernels::jacobianColumns(G,
                             _equations.rows(),
                             width,
                             part.count,
                             _factor.re.data() + static_cast<std::size_t>(thread) * stride,
                             _factor.im.data() + static_cast<std::size_t>(thread) * stride,
                             qRe,
                             qIm,
                             _rows.stride,
                             columns.data() + static_cast<std::size_t>(part.place) * stride,
                             _columns.square.data() + part.place);
}

// Linearises |p|: e_l = (|p_l| - s a_l)/(s d_l) changes by the column of J times the turn.
void ShapedRounding::chooseFine(FieldProblem& field,
                                const QuietPoints& quiet,
                                float s,
                                const Effort& effort)
{
    field.eachBlock(
        [&](int thread, int block)
        {
            const int lane = _parts[static_cast<std::size_t>(block)].lane;
            findFactors(field, thread, block, s, true);
            formColumns(field,
                        thread,
                        block,
                        field.q.re.data() + lane,
                        field.q.im.data() + lane,
                        _columns.first);
        });
    float* e = _rows.error.data();
    for (int l = 0; l < field.n(); ++l)
        e[l] = field.y[l] / (s * field.a[l]) - 1.0f;
    for (const int l : quiet.points())
        e[l] = (field.y[l] - s * field.a[l]) / (s * _yard[l]);
    std::fill(e + field.n(), e + _rows.stride, 0.0f);
    const auto step =
        static_cast<float>(base::kTwoPi / static_cast<double>(field.drive().phaseLevels));
    for (int pass = 0; pass < effort.passes; ++pass)
        kernels::shapeLevels(_lanes.count,
                             _rows.stride,
                             _columns.first.data(),
                             _columns.square.data(),
                             step,
                             effort.reach,
                             _lanes.wanted.data(),
                             _lanes.level.data(),
                             e);
}

void ShapedRounding::chooseCoarse(FieldProblem& field,
                                  const float* amplitudes,
                                  float s,
                                  const Effort& effort)
{
    // -Im(c G q) of q = j is -Re(c G), and of q = -1 it is Im(c G).
    alignas(64) float zeros[PropagationMatrix::kBlockWidth] = {};
    alignas(64) float minus[PropagationMatrix::kBlockWidth];
    std::fill(std::begin(minus), std::end(minus), -1.0f);
    for (const Part& part : _parts)
        for (int i = 0; i < part.count; ++i)
        {
            const auto place = static_cast<std::size_t>(part.place + i);
            const auto lane = static_cast<std::size_t>(part.lane + i);
            _lanes.drive.set(place, field.q.at(lane));
            _lanes.amplitude[place] = amplitudes ? amplitudes[lane] : 1.0f;
        }
    // Phases with errors of up to half a step have this share of the level.
    const auto levels = static_cast<float>(field.drive().phaseLevels);
    const float half = 0.5f * static_cast<float>(base::kTwoPi) / levels;
    const float level = std::sin(half) / half * s;
    field.eachBlock(
        [&](int thread, int block)
        {
            findFactors(field, thread, block, level, false);
            formColumns(field, thread, block, zeros, minus, _columns.first);
            formColumns(field, thread, block, minus, zeros, _columns.second);
        });
    for (int l = 0; l < _rows.stride; ++l)
    {
        const auto row = static_cast<std::size_t>(l);
        _rows.p.set(row, l < field.n() ? field.p.at(row) / (level * _yard[l]) : 1.0f);
        _rows.aim[row] = l < field.n() ? field.a[l] / _yard[l] : 1.0f;
    }
    for (int pass = 0; pass < effort.passes; ++pass)
        kernels::shapeCoarseLevels(_lanes.count,
                                   _rows.stride,
                                   _columns.first.data(),
                                   _columns.second.data(),
                                   levels,
                                   static_cast<int>(reach(field, effort)),
                                   _lanes.amplitude.data(),
                                   _lanes.wanted.data(),
                                   _lanes.level.data(),
                                   _lanes.drive.re.data(),
                                   _lanes.drive.im.data(),
                                   _rows.aim.data(),
                                   _rows.p.re.data(),
                                   _rows.p.im.data());
}

// Sets q to the chosen levels, and adds the change to the partial sums.
void ShapedRounding::take(FieldProblem& field, int block, const float* amplitudes)
{
    const Part& part = _parts[static_cast<std::size_t>(block)];
    const auto levels = static_cast<float>(field.drive().phaseLevels);
    float *re = field.q.re.data() + part.lane, *im = field.q.im.data() + part.lane;
    float *dRe = _change.re.data() + part.lane, *dIm = _change.im.data() + part.lane;
    std::copy_n(re, part.count, dRe);
    std::copy_n(im, part.count, dIm);
    kernels::unitAtLevel(part.count, levels, _lanes.level.data() + part.place, re, im);
    if (amplitudes) kernels::scaleBy(part.count, amplitudes + part.lane, re, im);
    for (int i = 0; i < part.count; ++i)
    {
        dRe[i] = re[i] - dRe[i];
        dIm[i] = im[i] - dIm[i];
    }
    field.forwardBlock(block, _change, part.lane - field.G.offset(block));
}

void ShapedRounding::shape(FieldProblem& field,
                           const QuietPoints& quiet,
                           const float* amplitudes,
                           float s,
                           const Effort& effort)
{
    weigh(field, quiet);
    reserve(field, effort);
    if (_lanes.count == 0 || !(s > 0.0f)) return;
    const auto levels = static_cast<float>(field.drive().phaseLevels);
    for (const Part& part : _parts)
    {
        kernels::phaseInLevels(part.count,
                               levels,
                               field.q.re.data() + part.lane,
                               field.q.im.data() + part.lane,
                               _lanes.wanted.data() + part.place);
        std::copy_n(
            _lanes.wanted.data() + part.place, part.count, _lanes.level.data() + part.place);
    }
    if (isCoarse(field))
        chooseCoarse(field, amplitudes, s, effort);
    else
        chooseFine(field, quiet, s, effort);
    field.eachBlock([&](int, int block) { take(field, block, amplitudes); });
    field.addPartials(field.p);
    field.phasesOf(field.p);
}

} // namespace midair::haptics
