#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Limited-memory BFGS directions (Liu, Nocedal 1989; Nocedal, Wright 2006, algorithm 7.4): the
/// gradient changes of the last steps approximate the curvature.
class QuasiNewton
{
public:
    /// \a memory: >= 1, number of stored steps.
    explicit QuasiNewton(int memory = 8);

    /// Forgets all steps; the next direction is that of steepest descent.
    void forget() { _count = 0; }
    bool isEmpty() const { return _count == 0; }

    /// Stores \a step times \a share, which changed the gradient from \a before to \a after. Skips
    /// steps along which the gradient doesn't grow, because the curvature must stay positive.
    void remember(const Eigen::VectorXf& step,
                  float share,
                  const Eigen::VectorXf& before,
                  const Eigen::VectorXf& after);

    /// Sets \a direction to a descent direction for \a gradient: -gradient if nothing is stored.
    /// Doesn't allocate if \a direction has the size.
    void direct(const Eigen::VectorXf& gradient, Eigen::VectorXf& direction);

private:
    struct Pair
    {
        Eigen::VectorXf step, change; // s_k, y_k
        float inverse = 0.0f;         // 1/(s_k . y_k)
        float share = 0.0f;           // alpha_k
    };

    Pair& pair(int age); // 0: the newest

    std::vector<Pair> _pairs; // a ring
    int _count = 0, _newest = 0;
};

} // namespace midair::haptics
