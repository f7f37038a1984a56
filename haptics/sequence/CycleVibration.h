#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <complex>
#include <vector>

namespace midair::haptics
{

/// The vibration of fields in turn under fingertips on a surface (fingertipVibration()), squared,
/// as a function of the fields' pressures at places on it, with ringing and equal travel times
/// (waveOverlaps()); and its derivative.
class CycleVibration
{
public:
    /// Pressures of \a K fields at a place: \a p[k].
    using Pressures = std::vector<std::complex<float>>;

    CycleVibration() = default; ///< without waves: 0
    /// For \a fields (>= 2) that each play for \a step_s (> 0) with transducers that ring with \a
    /// ringing_s (> 0), at \a places (3 x n, m), spread evenly.
    CycleVibration(const Eigen::Matrix3Xd& places, int fields, double step_s, double ringing_s);

    bool isEmpty() const { return _waves.empty(); }
    /// Sets the waves of place \a l for addTo() and squared().
    void set(Eigen::Index l, const Pressures& p);
    /// Returns the square of the vibration, over \a mean (> 0) as the mean of |p|^2; call set() for
    /// all places before.
    double squared(double mean);
    /// Adds \a factor u_k to \a w[k], where squared() changes by Re sum_k conj(dp_k) u_k at place
    /// \a l; call squared() before.
    void addTo(Eigen::Index l, float factor, const Pressures& p, Pressures& w) const;

private:
    struct Wave
    {
        std::vector<std::complex<float>> overlaps; // M_d of each of _apart
        std::vector<std::complex<float>> turns;    // K, z^{h k}
        float sensitivity2 = 0.0f;
    };

    Eigen::SparseMatrix<float, Eigen::RowMajor> _pads;
    std::vector<Wave> _waves;
    std::vector<std::size_t> _apart; // 0 .. K - 1, of fields that overlap
    // n x number of waves: A_h; after squared() the derivative by its parts, times 2/K
    Eigen::MatrixXf _re, _im;
};

} // namespace midair::haptics
