#pragma once

#include "haptics/solvers/PhaseObjective.h"

#include <Eigen/Core>

#include <cstdint>
#include <random>

namespace midair::haptics
{

/// Returns \a p (n) with every entry scaled to modulus 1; entries that are 0 become 1.
Eigen::VectorXcd unitPhases(const Eigen::VectorXcd& p);

/// The relaxation of a PhaseObjective in factored form: each phase u_l is replaced by a unit vector
/// x_l of a few complex components, which removes the poor local minima. Coordinate descent
/// minimises it.
class PhaseRelaxation
{
public:
    /// Starts from random vectors of ceil(sqrt(n)) + 1 components. \a objective must outlive this.
    /// The constructor, descend() and reduceRank() throw Stopped on a request of \a stop.
    PhaseRelaxation(const PhaseObjective& objective, std::uint64_t seed, base::StopToken stop = {});

    /// Makes rounds until one lowers the value by no more than \a fall * trace(M), or until there
    /// were \a maxRounds in all calls together.
    void descend(int maxRounds, double fall);
    int rounds() const { return _rounds; }

    /// Returns sum_kl M_kl x_k* x_l = tr(M U).
    double value() const { return y().sum(); }
    /// Returns y_l = Re(x_l* (M x)_l), the diagonal of M U (n): the certificate's multipliers.
    Eigen::VectorXd y() const;

    /// Rotates to principal components, the largest first, and drops those with at most a
    /// thousandth of the vectors' squared length.
    void reduceRank();
    int rank() const { return static_cast<int>(_xRe.cols()); }
    Eigen::MatrixXcd vectors() const; ///< n x rank, row l is x_l

    /// Returns the phases of the vectors' components along a random direction, which is normally
    /// distributed: a rounded solution.
    Eigen::VectorXcd round(std::mt19937_64& random) const;
    /// Returns the phases of the vectors' first component.
    Eigen::VectorXcd leadingPhases() const;

private:
    void assign(const Eigen::MatrixXcd& X);
    void refreshProducts();

    const PhaseObjective& _objective;
    base::StopToken _stop;
    Eigen::MatrixXf _xRe, _xIm; // stride x components
    Eigen::MatrixXf _sRe, _sIm; // M x
    int _rounds = 0;
};

/// Searches for phases with the least u* M u, by descents from rounded solutions of the relaxation.
class BoundSearch
{
public:
    /// Searches throw Stopped on a request of \a stop. \a objective must outlive this.
    explicit BoundSearch(const PhaseObjective& objective,
                         std::uint64_t seed,
                         base::StopToken stop = {});

    /// Descends from \a u to a minimum and keeps the result if it is the best so far.
    void tryFrom(const Eigen::VectorXcd& u);
    /// Descends from \a count roundings for four rounds, whose values predict the minima well, and
    /// from the best \a carriedOn of them to their minima.
    void tryRoundings(const PhaseRelaxation& relaxation, int count, int carriedOn);

    const Eigen::VectorXcd& best() const { return _best; } ///< best phases so far, n
    int starts() const { return _starts; }

private:
    const PhaseObjective& _objective;
    base::StopToken _stop;
    std::mt19937_64 _random;
    Eigen::VectorXcd _best;
    double _bestValue = 0.0;
    int _starts = 0;
};

} // namespace midair::haptics
