#include "haptics/solvers/dense/QuasiNewton.h"

#include <algorithm>

namespace midair::haptics
{

QuasiNewton::QuasiNewton(int memory) : _pairs(static_cast<std::size_t>(std::max(memory, 1))) {}

QuasiNewton::Pair& QuasiNewton::pair(int age)
{
    const int size = static_cast<int>(_pairs.size());
    return _pairs[static_cast<std::size_t>((_newest - age + size) % size)];
}

void QuasiNewton::remember(const Eigen::VectorXf& step,
                           float share,
                           const Eigen::VectorXf& before,
                           const Eigen::VectorXf& after)
{
    constexpr float kLeastCosine = 1e-6f;
    const int size = static_cast<int>(_pairs.size());
    Pair& next = pair(-1); // the oldest, if all are in use
    next.step = share * step;
    next.change = after - before;
    const float curvature = next.step.dot(next.change);
    if (!(curvature > kLeastCosine * next.step.norm() * next.change.norm()))
    {
        // The oldest pair, if it was one, is lost.
        _count = std::min(_count, size - 1);
        return;
    }
    next.inverse = 1.0f / curvature;
    _newest = (_newest + 1) % size;
    _count = std::min(_count + 1, size);
}

void QuasiNewton::direct(const Eigen::VectorXf& gradient, Eigen::VectorXf& direction)
{
    direction = -gradient;
    for (int age = 0; age < _count; ++age)
    {
        Pair& one = pair(age);
        one.share = one.inverse * one.step.dot(direction);
        direction -= one.share * one.change;
    }
    if (_count > 0)
    {
        const Pair& newest = pair(0);
        direction /= newest.inverse * newest.change.squaredNorm();
    }
    for (int age = _count - 1; age >= 0; --age)
    {
        const Pair& one = pair(age);
        direction += (one.share - one.inverse * one.change.dot(direction)) * one.step;
    }
}

} // namespace midair::haptics
