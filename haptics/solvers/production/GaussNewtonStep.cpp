#include "haptics/solvers/production/GaussNewtonStep.h"

#include "haptics/points/FittedLevel.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

// SOLVER.md, "Crowded points".
constexpr float kDampedFreedom = 1.5f;
constexpr float kDampedTurn_rad = 0.5f;

constexpr float kLeastRoot = 1e-30f; // least divisor: the roots of a block of padding are 0

} // namespace

void GaussNewtonStep::reserve(const FieldProblem& field, const std::vector<int>& twice)
{
    _equations.choose(field, twice);
    const int n = _equations.rows();
    const auto m = static_cast<std::size_t>(field.G.paddedTransducers());
    _even = (n + 1) / 2 * 2;
    _stride = (n + 16) / 16 * 16; // whole cache lines
    _jacobian.reserveUnset(m * static_cast<std::size_t>(_even / 2));
    _unit.reserve(static_cast<std::size_t>(field.G.blocks()) * static_cast<std::size_t>(_stride));
    _scaledDirection.reserve(static_cast<std::size_t>(field.threads()) *
                             static_cast<std::size_t>(_stride));
    for (base::AlignedBuffer<float>* v : {&_root, &_t, &_sum})
        v->reserve(m);
    for (Eigen::VectorXf* v : {&_x, &_r, &_d, &_curved, &_scale})
        if (v->size() != n) v->resize(n);
}

// Computes the square roots of D = diag(1/|z_i|). D is capped, because a transducer whose z_i
// nearly vanishes would turn without bound.
void GaussNewtonStep::findRoots(const FieldProblem& field, float mostFreedom)
{
    const int m = field.m();
    const float mean = Eigen::Map<const Eigen::VectorXf>(field.inverse.data(), m).mean();
    Eigen::Map<Eigen::ArrayXf> root(_root.data(), m);
    root = Eigen::Map<const Eigen::ArrayXf>(field.inverse.data(), m).min(mostFreedom * mean).sqrt();
    std::fill(_root.data() + m, _root.data() + field.G.paddedTransducers(), 0.0f);
}

void GaussNewtonStep::form(const FieldProblem& field, const SplitVector& q, int thread, int block)
{
    const int n = _equations.rows(), offset = field.G.offset(block), width = field.G.width(block);
    const float* root = _root.data() + offset;
    const float largest = std::max(*std::max_element(root, root + width), kLeastRoot);
    alignas(64) float re[PropagationMatrix::kBlockWidth], im[PropagationMatrix::kBlockWidth];
    for (int i = 0; i < width; ++i)
    {
        const float r = root[i] / largest;
        re[i] = q.re[offset + i] * r;
        im[i] = q.im[offset + i] * r;
    }
    int gathered = 0;
    kernels::formJacobian(_equations.gather(field, thread, block, 0, width, gathered),
                          n,
                          width,
                          _equations.u.re.data(),
                          _equations.u.im.data(),
                          re,
                          im,
                          _jacobian.data() + static_cast<std::size_t>(offset) * (_even / 2));
    const float* scale = field.G.fixedScale(block);
    float* unit = _unit.data() + static_cast<std::size_t>(block) * _stride;
    for (int l = 0; l < n; ++l)
        unit[l] = scale[_equations.point(l)] * largest * _scale[l];
    if (_even > n) unit[n] = 0.0f;
    std::fill_n(_sum.data() + offset, width, 0.0f);
}

// Adds the step along the previous direction, _sum += _alpha t; then sets t = J^T direction and
// partial = J t. Reads J once, or forms it from G if \a formed is false.
void GaussNewtonStep::pass(FieldProblem& field,
                           const SplitVector& q,
                           bool formed,
                           const float* direction)
{
    const int n = _equations.rows();
    field.eachBlock(
        [&](int thread, int b)
        {
            const int i = field.G.offset(b), width = field.G.width(b);
            float *t = _t.data() + i, *sum = _sum.data() + i;
            if (formed)
                for (int k = 0; k < width; ++k)
                    sum[k] += _alpha * t[k];
            else
                form(field, q, thread, b);
            const std::int32_t* J = _jacobian.data() + static_cast<std::size_t>(i) * (_even / 2);
            const float* unit = _unit.data() + static_cast<std::size_t>(b) * _stride;
            float* scaled = _scaledDirection.data() + static_cast<std::size_t>(thread) * _stride;
            for (int l = 0; l < n; ++l)
                scaled[l] = direction[l] * unit[l];
            if (_even > n) scaled[n] = 0.0f;
            kernels::transposedJacobian(J, _even, width, scaled, t);
            std::fill_n(field.partial(b), _even, 0.0f);
            kernels::applyJacobian(J, unit, _even, width, t, field.partial(b));
        });
    for (int l = 0; l < n; ++l)
    {
        float sum = 0.0f;
        for (int b = 0; b < field.G.blocks(); ++b)
            sum += field.partial(b)[l];
        _curved[l] = sum;
    }
}

int GaussNewtonStep::solve(FieldProblem& field,
                           const SplitVector& q,
                           const QuietPoints& quiet,
                           const Eigen::VectorXf& weights,
                           double tolerance,
                           int maxSteps)
{
    reserve(field, quiet.twice());
    findRoots(field, _mostFreedom);
    _largestTurn = _largestTurn_rad;
    const int n = field.n(), rows = _equations.rows();
    if (!quiet.any())
    {
        _judged.resize(0);
        _scale = (weightedLevel(weights, field.y, field.a) * field.a).cwiseInverse();
        _flat = weights.cwiseProduct(field.a);
        _r = Eigen::VectorXf::Ones(n) - field.y.cwiseProduct(_scale);
    }
    else
    {
        // Scales rows to similar size for all targets; otherwise CG would take more steps the more
        // they differ.
        const float natural = weightedLevel(weights.head(n), field.y, field.a);
        const bool isLevel = natural > 0.0f && std::isfinite(natural);
        const float s = isLevel ? natural : fittedLevel(field);
        _judged.setOnes(rows);
        _flat.resize(rows);
        for (int row = 0; row < rows; ++row)
        {
            const int l = _equations.point(row);
            const float size = std::max(field.a[l], QuietPoints::kQuiet);
            _scale[row] = 1.0f / (s * size);
            _flat[row] = weights[row] * size;
            _r[row] = row < n ? (s * field.a[l] - field.y[l]) * _scale[row] : 0.0f;
            if (row < n) _judged[row] = size / quiet.yard()[l];
        }
    }
    // J D J^T is nearly singular along w a (SOLVER.md, "The level of a correction"), so the search
    // stays orthogonal to it.
    _flat /= _flat.norm();
    _r -= _r.dot(_flat) * _flat;
    return conjugateSteps(field, q, tolerance, maxSteps, 0.0f);
}

int GaussNewtonStep::solveDamped(FieldProblem& field,
                                 const SplitVector& q,
                                 const QuietPoints& quiet,
                                 float level,
                                 double tolerance,
                                 int maxSteps,
                                 float damping)
{
    static const std::vector<int> kNone;
    reserve(field, kNone);
    findRoots(field, kDampedFreedom);
    _largestTurn = kDampedTurn_rad;
    _judged.resize(0);
    _flat.setZero(field.n());
    _scale = (level * field.a).cwiseInverse();
    _r = 1.0f - field.y.cwiseProduct(_scale).array().square();
    _scale = 2.0f * field.y.array() * _scale.array().square();
    for (const int l : quiet.points())
    {
        const float share = QuietPoints::shareOf(field.a[l]);
        _r[l] *= share;
        _scale[l] *= share;
    }
    return conjugateSteps(field, q, tolerance, maxSteps, damping);
}

// Returns |r|^2 in the judging weights; rr is that of _r.
float GaussNewtonStep::remainder(float rr) const
{
    return _judged.size() == 0 ? rr : _r.cwiseProduct(_judged).squaredNorm();
}

// Conjugate gradients for (J D J^T + mu I) x = _r, rows scaled by _scale, orthogonal to _flat.
int GaussNewtonStep::conjugateSteps(
    FieldProblem& field, const SplitVector& q, double tolerance, int maxSteps, float damping)
{
    _x.setZero();
    _d = _r;
    float rr = _r.squaredNorm(), mu = 0.0f;
    _alpha = 0.0f;
    _steps = 0;
    const auto goal = static_cast<float>(tolerance * tolerance * field.n());
    while (_steps < maxSteps && remainder(rr) > goal)
    {
        pass(field, q, _steps > 0, _d.data());
        ++_steps;
        _curved -= _curved.dot(_flat) * _flat;
        if (_steps == 1) mu = damping * _d.dot(_curved) / rr;
        _curved += mu * _d;
        const float curvature = _d.dot(_curved);
        if (!(curvature > 0.0f))
        {
            _alpha = 0.0f;
            break;
        }
        _alpha = rr / curvature;
        _x += _alpha * _d;
        _r -= _alpha * _curved;
        const float next = _r.squaredNorm();
        _d = _r + (next / rr) * _d;
        rr = next;
    }
    return _steps;
}

void GaussNewtonStep::turn(const FieldProblem& field, int block, SplitVector& q) const
{
    if (_steps == 0) return;
    const int offset = field.G.offset(block), width = field.G.width(block);
    const float *sum = _sum.data() + offset, *t = _t.data() + offset;
    alignas(64) float step[PropagationMatrix::kBlockWidth];
    for (int k = 0; k < width; ++k)
        step[k] = sum[k] + _alpha * t[k];
    kernels::turn(width,
                  _root.data() + offset,
                  step,
                  _largestTurn,
                  q.re.data() + offset,
                  q.im.data() + offset);
}

} // namespace midair::haptics
