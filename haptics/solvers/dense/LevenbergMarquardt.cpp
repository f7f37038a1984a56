#include "haptics/solvers/dense/LevenbergMarquardt.h"

#include "haptics/solvers/FieldProblem.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

// Damping relative to the mean of diag(J J^T); haptics/SOLVER.md, "Dense points".
constexpr double kFirstDamping = 0.1;
constexpr double kLeastDamping = 1e-4;
constexpr double kMostDamping = 1e3;
constexpr float kInnerTolerance = 0.05f; // residual over the first one at which CG ends

} // namespace

Eigen::VectorXcf currentPhases(const FieldProblem& field)
{
    Eigen::VectorXcf q;
    field.fromLanes(field.q, q);
    return q;
}

void setPhases(FieldProblem& field, const Eigen::VectorXcf& q)
{
    field.toLanes(q, field.q);
}

Eigen::VectorXcf playedPhases(FieldProblem& field)
{
    kernels::quantisePhase(field.G.paddedTransducers(),
                           field.drive().phaseLevels,
                           field.q.re.data(),
                           field.q.im.data(),
                           field.z.re.data(),
                           field.z.im.data());
    Eigen::VectorXcf q;
    field.fromLanes(field.z, q);
    return q;
}

void LevenbergMarquardt::project(FieldProblem& field, int rounds)
{
    reserve(field);
    _weight = field.a;
    for (int k = 0; k < rounds; ++k)
    {
        _weight /= _weight.mean();
        projectionRound(field, _weight);
        reweigh(field, _weight);
    }
}

void LevenbergMarquardt::reserve(const FieldProblem& field)
{
    const auto m = static_cast<std::size_t>(field.G.paddedTransducers());
    const auto n = static_cast<std::size_t>(field.n());
    for (base::AlignedBuffer<float>* v : {&_d, &_sum})
        v->reserve(m);
    for (SplitVector* v : {&_t, &_kept})
        v->reserve(m);
    _w.reserve(n);
    for (Eigen::VectorXf* v : {&_r, &_x, &_rest, &_direction, &_product, &_weight})
        if (v->size() != field.n()) v->resize(field.n());
}

// Computes p, the weights 2/(s a_l)^2 and r_l = 1 - |p_l|^2/(s a_l)^2 for field.q. Returns f.
double LevenbergMarquardt::measure(FieldProblem& field, double s)
{
    field.forward(field.q, field.p);
    double f = 0.0;
    for (int l = 0; l < field.n(); ++l)
    {
        const auto goal = static_cast<float>(1.0 / (s * field.a[l] * s * field.a[l]));
        _r[l] = 1.0f - goal * std::norm(field.p.at(static_cast<std::size_t>(l)));
        _weight[l] = 2.0f * goal;
        f += static_cast<double>(_r[l]) * _r[l];
    }
    return f;
}

// With J_li = d(|p_l|^2)/d phi_i / (s a_l)^2 = -weight_l Im(conj(p_l) G_li q_i) sets
//     sum += alpha d of the previous direction,  d = J^T direction,  product = J d;  reads G once.
void LevenbergMarquardt::pass(FieldProblem& field, float alpha)
{
    const int n = field.n();
    for (int l = 0; l < n; ++l)
    {
        const auto k = static_cast<std::size_t>(l);
        _w.set(k, field.p.at(k) * (_weight[l] * _direction[l]));
    }
    field.eachBlock(
        [&](int, int b)
        {
            const int first = field.G.offset(b);
            field.G.backward(b, _w.re.data(), _w.im.data(), field.z.re.data(), field.z.im.data());
            const float *qRe = field.q.re.data() + first, *qIm = field.q.im.data() + first;
            const float *zRe = field.z.re.data() + first, *zIm = field.z.im.data() + first;
            float *d = _d.data() + first, *sum = _sum.data() + first;
            float *tRe = _t.re.data() + first, *tIm = _t.im.data() + first;
            for (int i = 0; i < field.G.width(b); ++i)
            {
                sum[i] += alpha * d[i];
                d[i] = qRe[i] * zIm[i] - qIm[i] * zRe[i]; // -Im(q conj(z))
                tRe[i] = qRe[i] * d[i];
                tIm[i] = qIm[i] * d[i];
            }
            field.forwardBlock(b, _t);
        });
    for (int l = 0; l < n; ++l)
    {
        const auto k = static_cast<std::size_t>(l);
        float re = 0.0f, im = 0.0f;
        for (int b = 0; b < field.G.blocks(); ++b)
        {
            re += field.partial(b)[l];
            im += field.partial(b)[n + l];
        }
        _product[l] = _weight[l] * (field.p.im[k] * re - field.p.re[k] * im);
    }
}

// Sets _sum to the step J^T x with (J J^T + mu I) x = r, mu = damping times the mean of diag(J
// J^T), by conjugate gradients in the space of the points.
void LevenbergMarquardt::step(FieldProblem& field, double damping, int innerSteps)
{
    const auto mu = static_cast<float>(damping * _gain);
    std::fill(_sum.data(), _sum.data() + field.G.paddedTransducers(), 0.0f);
    std::fill(_d.data(), _d.data() + field.G.paddedTransducers(), 0.0f);
    _rest = _r;
    _direction = _r;
    float square = _rest.squaredNorm(), alpha = 0.0f;
    const float done = kInnerTolerance * kInnerTolerance * square;
    for (int k = 0; k < innerSteps && square > done; ++k)
    {
        pass(field, alpha);
        _product += mu * _direction;
        const float curvature = _direction.dot(_product);
        if (!(curvature > 0.0f)) return;
        alpha = square / curvature;
        _rest -= alpha * _product;
        const float next = _rest.squaredNorm();
        _direction = _rest + (next / square) * _direction;
        square = next;
    }
    for (int i = 0; i < field.G.paddedTransducers(); ++i)
        _sum[static_cast<std::size_t>(i)] += alpha * _d[static_cast<std::size_t>(i)];
}

// Multiplies q_i by (1 + j d/2)/(1 - j d/2), which has modulus 1 without a sine; its angle is d for
// small d and never reaches half a turn.
void LevenbergMarquardt::turn(FieldProblem& field)
{
    float *qRe = field.q.re.data(), *qIm = field.q.im.data();
    const float *fromRe = _kept.re.data(), *fromIm = _kept.im.data(), *d = _sum.data();
    for (int i = 0; i < field.G.paddedTransducers(); ++i)
    {
        const float h = 0.5f * d[i], scale = 1.0f / (1.0f + h * h);
        const float c = (1.0f - h * h) * scale, s = 2.0f * h * scale;
        qRe[i] = fromRe[i] * c - fromIm[i] * s;
        qIm[i] = fromRe[i] * s + fromIm[i] * c;
    }
}

int LevenbergMarquardt::fit(FieldProblem& field, double s, const Limits& limits)
{
    reserve(field);
    const auto m = static_cast<std::size_t>(field.G.paddedTransducers());
    const auto keep = [&](SplitVector& from, SplitVector& to)
    {
        std::copy(from.re.data(), from.re.data() + m, to.re.data());
        std::copy(from.im.data(), from.im.data() + m, to.im.data());
    };
    double f = measure(field, s), before = f, damping = kFirstDamping;
    const double done = limits.tolerance * limits.tolerance * field.n();
    int corrections = 0;
    while (corrections < limits.corrections && f > done && damping < kMostDamping)
    {
        // Assumes equal |G_li| in a row, because this only sets the scale of the damping
        // (SOLVER.md, "Dense points").
        _gain = 0.0;
        for (int l = 0; l < field.n(); ++l)
            _gain += std::pow(field.rowSum(l) * _weight[l] *
                                  std::abs(field.p.at(static_cast<std::size_t>(l))),
                              2) /
                     (2.0 * field.m() * field.n());
        keep(field.q, _kept);
        double next = f;
        for (; damping < kMostDamping; damping *= 4.0)
        {
            step(field, damping, limits.innerSteps);
            turn(field);
            next = measure(field, s);
            if (next < f) break;
            keep(_kept, field.q);
            measure(field, s);
        }
        if (!(next < f)) break;
        f = next;
        damping = std::max(0.3 * damping, kLeastDamping);
        if (++corrections % 3 == 0)
        {
            if (f > (1.0 - limits.progress) * before) break;
            before = f;
        }
    }
    field.phasesOf(field.p);
    _residual = std::sqrt(f / field.n());
    return corrections;
}

} // namespace midair::haptics
