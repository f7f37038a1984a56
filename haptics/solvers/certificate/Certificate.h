#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/solvers/PhaseObjective.h"

#include <Eigen/Core>

#include <cstdint>
#include <random>
#include <string>

namespace midair::haptics
{

/// Returns \a p (n) with every entry scaled to modulus 1; entries that are 0 become 1.
Eigen::VectorXcd unitPhases(const Eigen::VectorXcd& p);

/// The relaxation of a PhaseObjective in factored form: each phase u_l is replaced by a unit vector
/// x_l of a few complex components, which removes poor local minima. Coordinate descent minimises
/// it.
class PhaseRelaxation
{
public:
    /// Starts from random vectors of ceil(sqrt(n)) + 1 components. \a objective must outlive this.
    /// The constructor, descend() and reduceRank() throw Stopped on a request of \a stop.
    PhaseRelaxation(const PhaseObjective& objective, std::uint64_t seed, base::StopToken stop = {});

    /// Makes rounds until one lowers the value by at most \a fall * trace(M), or until all calls
    /// together made \a maxRounds.
    void descend(int maxRounds, double fall);
    int rounds() const { return _rounds; }

    /// Returns sum_kl M_kl x_k* x_l = tr(M U).
    double value() const { return y().sum(); }
    /// Returns y_l = Re(x_l* (M x)_l), the diagonal of M U (n): the certificate's multipliers.
    Eigen::VectorXd y() const;

    /// Rotates to principal components, largest first, and drops those with at most a thousandth of
    /// the vectors' squared length.
    void reduceRank();
    int rank() const { return static_cast<int>(_xRe.cols()); }
    Eigen::MatrixXcd vectors() const; ///< n x rank, row l is x_l

    /// Returns a rounded solution: the phases of the vectors' components along a random direction,
    /// which is normally distributed.
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

/// Searches for phases with the least u* M u by descents from rounded solutions of the relaxation.
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

/// Settings of a Certifier; isValid() names the first one that is out of range.
struct CertificateOptions
{
    double lambdaRel = 0.1; ///< 1e-5 .. 1e9; lambda = lambdaRel trace(K)/n
    /// 1e-12 .. 1; the relaxation is refined until (relaxed - bound) / relaxed is at most this.
    double tolerance = 3e-4;
    int maxRounds = 3000; ///< >= 1; rounds of coordinate descent on the relaxation, at most
    /// >= 0; batches of kRoundings rounded solutions, of which the best start a search for phases.
    /// 0: one start only, from the given phases or the relaxation's leading ones.
    int batches = 2;
    std::uint64_t seed = 1; ///< seed of the relaxation's first vectors and of the roundings
    base::StopToken stop;   ///< on its request Stopped is thrown

    /// Returns false if a setting is out of range; \a error, if given, then names it.
    bool isValid(std::string* error = nullptr) const;
};

/// Distance of a field from the best one for its control points. Values are of u* M u
/// (PhaseObjective); for all phases u,  bound <= u* M u.  This holds for the exact M of the points
/// and the array, or of a given K.
///
/// Rounding. certifiedBound() gives a bound B for M as it was computed, in double. Let C be the
/// exact least value for the exact inverse X of A = K + lambda I, and r >= |I - X' A| for the
/// computed X' (PhaseObjective::inverseError()). Since X' - X = -(I - X' A) X and |X| <= 1/lambda,
///     B <= C + r |a| sqrt(C),  so  sqrt(C) >= 2 B / (r |a| + sqrt((r |a|)^2 + 4 B)).
/// The sums of K = G G* are wrong by at most e = 8 (m + 4) eps tr K in norm. As the exact K is
/// positive semidefinite, A + e I <= A lambda / (lambda - e), which leaves C (1 - e/lambda). The
/// entries of G are wrong by D, |D| <= d: the best q has lambda |q|^2 <= C, so that D q changes the
/// misfit's root by at most d sqrt(C/lambda), which leaves C / (1 + d/sqrt(lambda))^2. In all less
/// than 1e-7 of the bound for 100 points, 4000 transducers and lambdaRel 0.1; about 1e-4 for 1e-4.
struct Certificate
{
    double bound = 0.0; ///< certified: no phases have a smaller value
    /// Value of the relaxation at its end; its optimum lies between bound and this.
    double relaxed = 0.0;
    double best = 0.0;       ///< value of the best phases found
    Eigen::VectorXcd phases; ///< n, of modulus 1: the best phases found

    bool hasGiven = false;    ///< a field was given; the next two figures refer to it
    double givenPhases = 0.0; ///< value for the phases of the given field's pressures
    /// Misfit and power of the given field itself (PhaseObjective::misfitAndPower).
    double givenField = 0.0;

    int points = 0; ///< number of control points
    /// Numerical rank of the relaxation's solution; 1 would mean that its phases are optimal.
    int rank = 0;
    int rounds = 0;         ///< rounds of coordinate descent on the relaxation
    int starts = 0;         ///< rounded solutions and given phases that started a search
    bool tight = false;     ///< the tolerance was reached; the bound is valid in any case
    double matrix_ms = 0.0; ///< time for G, K and M
    double bound_ms = 0.0;  ///< time for the relaxation and the bound
    double search_ms = 0.0; ///< time for the search of phases
    double total_ms = 0.0;  ///< total time

    double gap() const { return relative(best); }                ///< (best - bound) / bound
    double gapOfPhases() const { return relative(givenPhases); } ///< the same of givenPhases
    double gapOfField() const { return relative(givenField); }   ///< the same of givenField

private:
    double relative(double value) const { return bound > 0.0 ? value / bound - 1.0 : 0.0; }
};

/// Returns a lower bound of u* M u over all u of modulus 1 that is valid despite rounding. For any
/// y,
///     u* M u = sum(y) + u* (M - diag y) u >= sum(y) + n min(0, smallest eigenvalue of M - diag y).
/// The eigenvalue is only estimated, which gives a shift sigma; a successful Cholesky factorisation
/// then proves that M - diag y - sigma I is positive semidefinite, up to its backward error, which
/// is subtracted (Rump, "Verification of positive definiteness", BIT 46, 2006). The rounding of the
/// sums, and of u* M u evaluated in double for comparison, is subtracted as well. \a M: n x n,
/// exactly Hermitian. \a y: n. Throws Stopped on a request of \a stop.
double certifiedBound(const Eigen::MatrixXcd& M,
                      const Eigen::VectorXd& y,
                      const base::StopToken& stop = {});

/// Bounds the least misfit from below and searches for phases near the bound. The semidefinite
/// relaxation of phase retrieval, min tr(M U) over U >= 0 with unit diagonal, is solved in factored
/// form, U = V* V with unit columns, by coordinate descent over columns (Wang, Chang, Kolter, "The
/// mixing method", 2017; with rank sqrt(n) + 1 it has no spurious minima, Boumal, Voroninski,
/// Bandeira 2016); y = diag(M V* V) then certifies. Needs no barrier and no penalty.
class Certifier
{
public:
    /// Rounded solutions per batch, and number of them that descend to their minimum.
    static constexpr int kRoundings = 64;
    static constexpr int kCarriedOn = 8;

    /// Throws InputError for options that are not valid.
    explicit Certifier(const CertificateOptions& options = {});

    /// Certifies \a objective. \a givenPhases (n or empty): phases to compare, which also start a
    /// search. Throws InputError for phases that are not finite or not n, and for more than
    /// kMostCertifiedPoints.
    Certificate certify(const PhaseObjective& objective, const Eigen::VectorXcd& givenPhases = {});

    /// Computes G, K and M, in double and for a source amplitude of 1 because only ratios count,
    /// and certifies. \a q (m or empty): activations of a field to compare, and the drive of
    /// points.outside_Pa. Throws InputError for
    /// points, targets or an array without a finite G, and for more than kMostCertifiedPoints.
    Certificate certify(const ControlPoints& points,
                        const TransducerArray& array,
                        const Medium& medium,
                        const Eigen::VectorXcf& q = {});

    const CertificateOptions& options() const { return _options; }

private:
    CertificateOptions _options;
};

} // namespace midair::haptics
