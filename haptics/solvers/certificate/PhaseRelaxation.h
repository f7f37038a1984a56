#pragma once

#include "haptics/solvers/PhaseObjective.h"

#include <Eigen/Core>

#include <cstdint>
#include <random>

namespace midair::haptics
{

/// \a p (n) with every entry brought to modulus 1; 1 where it is 0.
Eigen::VectorXcd unitPhases(const Eigen::VectorXcd& p);

/// The relaxation of a PhaseObjective in factored form: each phase u_l replaced by a unit vector
/// x_l of a few complex components, so that the bad minima go; minimised by coordinate descent.
class PhaseRelaxation
{
public:
    /// From random vectors of ceil(sqrt(n)) + 1 components. \a objective must outlive this. Throws
    /// Stopped, from descend() too, where \a stop asks for it.
    PhaseRelaxation(const PhaseObjective& objective, std::uint64_t seed, base::StopToken stop = {});

    /// Rounds until one gains less than \a fall * trace(M), or \a maxRounds in all.
    void descend(int maxRounds, double fall);
    int rounds() const { return _rounds; }

    /// sum_kl M_kl x_k* x_l = tr(M U).
    double value() const { return y().sum(); }
    /// y_l = Re(x_l* (M x)_l), the diagonal of M U: the certificate's multipliers. n.
    Eigen::VectorXd y() const;

    /// Turns the components into principal ones, the largest first, and drops those that carry less
    /// than a thousandth.
    void reduceRank();
    int rank() const { return static_cast<int>(_xRe.cols()); }
    Eigen::MatrixXcd vectors() const; ///< n x rank, row l is x_l

    /// Phases of the vectors along a random direction (normally distributed).
    Eigen::VectorXcd round(std::mt19937_64& random) const;
    /// Phases of the first component.
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

/// Looks for phases of least u* M u: descends from rounded solutions of the relaxation, the
/// promising ones to the end.
class PhaseSearch
{
public:
    /// What takes long throws Stopped where \a stop asks for it.
    explicit PhaseSearch(const PhaseObjective& objective,
                         std::uint64_t seed,
                         base::StopToken stop = {});

    /// Descends from \a u and keeps the result if it is the best so far.
    void tryFrom(const Eigen::VectorXcd& u);
    /// Takes \a count roundings a few rounds down, and the best \a carriedOn of them to their
    /// minimum: where a start is after four rounds tells well where it will end.
    void tryRoundings(const PhaseRelaxation& relaxation, int count, int carriedOn);

    const Eigen::VectorXcd& best() const { return _best; }
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
