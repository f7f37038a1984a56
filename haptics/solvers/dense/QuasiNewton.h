#pragma once

#include <Eigen/Core>

#include <vector>

namespace midair::haptics
{

/// Directions of descent by limited-memory BFGS (Liu, Nocedal 1989; Nocedal, Wright 2006,
/// algorithm 7.4): what the last steps changed in the gradient stands for the curvature.
class QuasiNewton
{
public:
    /// \a memory: >= 1, number of steps that are remembered.
    explicit QuasiNewton(int memory = 8);

    /// Forgets all steps; the next direction is that of steepest descent.
    void forget() { _count = 0; }
    bool isEmpty() const { return _count == 0; }

    /// Remembers \a step times \a share, which changed the gradient from \a before to \a after. A
    /// step along which the gradient doesn't grow is left out: the curvature must stay positive.
    void remember(const Eigen::VectorXf& step,
                  float share,
                  const Eigen::VectorXf& before,
                  const Eigen::VectorXf& after);

    /// Sets \a direction to where f falls, from its \a gradient: to -gradient if nothing is
    /// remembered. Allocates nothing once \a direction has the size.
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
