#include "haptics/PhaseCorrection.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

void PhaseCorrection::reserve(const FieldProblem& field)
{
    const auto m = static_cast<std::size_t>(field.G.paddedTransducers());
    _J.reserve(m * static_cast<std::size_t>(field.n()));
    _root.reserve(m);
    _t.reserve(m);
    _sum.reserve(m);
    for (Eigen::VectorXf* v : {&_x, &_r, &_d, &_Ad, &_scale})
        if (v->size() != field.n()) v->resize(field.n());
}

// _sum += alpha t of the direction before; t = J^T direction; partial += J t. One read of J, or of G where J is formed.
void PhaseCorrection::pass(FieldProblem& field, bool form, float alpha, const float* direction)
{
    const int n = field.n();
    field.pool().run(
        [&](int thread)
        {
            float* part = field.partial(thread);
            std::fill(part, part + n, 0.0f);
            for (int b = field.firstBlock(thread); b < field.lastBlock(thread); ++b)
            {
                const int i = field.G.offset(b), width = field.G.width(b);
                float* J = _J.data() + static_cast<std::size_t>(i) * static_cast<std::size_t>(n);
                float *t = _t.data() + i, *sum = _sum.data() + i;
                if (form)
                {
                    kernels::formJacobian(field.G.blockData(b),
                                          n,
                                          width,
                                          field.u.re.data(),
                                          field.u.im.data(),
                                          _scale.data(),
                                          field.q.re.data() + i,
                                          field.q.im.data() + i,
                                          _root.data() + i,
                                          J);
                    std::fill(sum, sum + width, 0.0f);
                }
                else
                    for (int k = 0; k < width; ++k)
                        sum[k] += alpha * t[k];
                kernels::transposedJacobian(J, n, width, direction, t);
                kernels::applyJacobian(J, n, width, t, part);
            }
        });
    for (int l = 0; l < n; ++l)
    {
        float sum = 0.0f;
        for (int thread = 0; thread < field.pool().threads(); ++thread)
            sum += field.partial(thread)[l];
        _Ad[l] = sum;
    }
}

int PhaseCorrection::solve(
    FieldProblem& field, float s, double tolerance, int maxSteps, bool weighted)
{
    reserve(field);
    const int n = field.n(), m = field.m();
    float mean = 0.0f;
    for (int i = 0; i < m; ++i)
        mean += field.inverse[i];
    mean /= static_cast<float>(m);
    for (int i = 0; i < field.G.paddedTransducers(); ++i)
        _root[i] = i < m ? (weighted ? std::sqrt(std::min(field.inverse[i], 4.0f * mean))
                                     : std::sqrt(mean))
                         : 0.0f;

    _scale = (s * field.a).cwiseInverse();
    _x.setZero();
    _r = Eigen::VectorXf::Ones(n) - field.y.cwiseProduct(_scale);
    _d = _r;
    float rr = _r.squaredNorm(), alpha = 0.0f;
    const auto goal = static_cast<float>(tolerance * tolerance * n);
    int step = 0;
    while (step < maxSteps && rr > goal)
    {
        pass(field, step == 0, alpha, _d.data());
        ++step;
        const float curvature = _d.dot(_Ad);
        if (!(curvature > 0.0f))
        {
            alpha = 0.0f;
            break;
        }
        alpha = rr / curvature;
        _x += alpha * _d;
        _r -= alpha * _Ad;
        const float next = _r.squaredNorm();
        _d = _r + (next / rr) * _d;
        rr = next;
    }
    if (step == 0) return 0;
    for (int i = 0; i < field.G.paddedTransducers(); ++i)
        _sum[i] += alpha * _t[i];
    kernels::turn(field.G.paddedTransducers(),
                  _root.data(),
                  _sum.data(),
                  0.5f,
                  field.q.re.data(),
                  field.q.im.data());
    return step;
}

} // namespace midair::haptics
