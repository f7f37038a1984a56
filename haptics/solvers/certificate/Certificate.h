#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/solvers/PhaseObjective.h"

#include <Eigen/Core>

#include <cstdint>
#include <string>

namespace midair::haptics
{

/// How tight a certificate is made and how long good phases are searched for; isValid() names the
/// first setting that is out of its range.
struct CertificateOptions
{
    double lambdaRel = 0.1; ///< 1e-5 .. 1e9; lambda = lambdaRel trace(K)/n
    /// 1e-12 .. 1; the relaxation is refined until (relaxed - bound) / relaxed is at most this.
    double tolerance = 3e-4;
    int maxRounds = 3000; ///< >= 1; of coordinate descent on the relaxation
    /// >= 0; batches of kRoundings rounded solutions, of which the best are descended from. 0: no
    /// search.
    int batches = 2;
    std::uint64_t seed = 1;
    base::StopToken stop; ///< where it asks for that, Stopped is thrown

    bool isValid(std::string* error = nullptr) const;
};

/// How far a field is from the best that exists for its control points. All values are of u* M u
/// (PhaseObjective), over all phases u; for every u:  bound <= u* M u.  What is stated holds for M
/// as it was computed (see certifiedBound).
struct Certificate
{
    double bound = 0.0; ///< certified: no phases whatever have less
    /// u* M u of the relaxation where it was stopped; its optimum lies between bound and this.
    double relaxed = 0.0;
    double best = 0.0;       ///< of the best phases that were found
    Eigen::VectorXcd phases; ///< n, of modulus 1: those

    bool hasGiven = false;    ///< a field was given, and the next two tell how good it is
    double givenPhases = 0.0; ///< u* M u for the phases of the given field's pressures
    /// Misfit and power of the given field itself (PhaseObjective::misfitAndPower).
    double givenField = 0.0;

    int points = 0;
    /// Numerical rank of the relaxation's solution; 1 would mean that its phases are optimal.
    int rank = 0;
    int rounds = 0;         ///< of coordinate descent on the relaxation
    int starts = 0;         ///< rounded solutions and given phases from which the search set out
    bool tight = false;     ///< the tolerance was reached; if not, the bound is valid all the same
    double matrix_ms = 0.0; ///< G, K and M
    double bound_ms = 0.0;  ///< relaxation and bound
    double search_ms = 0.0;
    double total_ms = 0.0;

    double gap() const { return relative(best); } ///< (best - bound) / bound
    double gapOfPhases() const { return relative(givenPhases); }
    double gapOfField() const { return relative(givenField); }

private:
    double relative(double value) const { return bound > 0.0 ? value / bound - 1.0 : 0.0; }
};

/// A number that u* M u is at least, for every u of modulus 1, in spite of rounding: for any y,
///     u* M u = sum(y) + u* (M - diag y) u >= sum(y) + n min(0, smallest eigenvalue of M - diag y).
/// The eigenvalue is only a guess from which a shift sigma is taken; what is proved is that M -
/// diag y - sigma I is positive semidefinite, by a Cholesky factorisation that runs to its end and
/// whose backward error is taken off (Rump, "Verification of positive definiteness", BIT 46, 2006).
/// The rounding of sums, and of a u* M u that is evaluated in double to compare with, is taken off
/// as well. \a M n x n, exactly Hermitian; \a y n. Throws Stopped where \a stop asks for it.
double certifiedBound(const Eigen::MatrixXcd& M,
                      const Eigen::VectorXd& y,
                      const base::StopToken& stop = {});

/// Bounds the least misfit from below and looks for phases that come near it. The semidefinite
/// relaxation of phase retrieval, min tr(M U) over U >= 0 with unit diagonal, is solved in factored
/// form, U = V* V with unit columns, by coordinate descent over columns (Wang, Chang, Kolter, "The
/// mixing method", 2017; with rank sqrt(n) + 1 it has no other minima, Boumal, Voroninski, Bandeira
/// 2016); then y = diag(M V* V) certifies. No barrier, no penalty.
class Certifier
{
public:
    /// Rounded solutions a batch, and how many are carried to their minimum.
    static constexpr int kRoundings = 64;
    static constexpr int kCarriedOn = 8;

    /// Throws InputError for options that are not valid.
    explicit Certifier(const CertificateOptions& options = {});

    /// \a givenPhases (n or empty): what is compared, and one more start of the search.
    Certificate certify(const PhaseObjective& objective, const Eigen::VectorXcd& givenPhases = {});

    /// G, K and M from the scene, in float up to K; \a q (m or empty): the activations of a field
    /// that is compared with the best. One call at a time, since G is kept. Throws InputError for
    /// points, targets or an array that make no finite G, and for more than kMostCertifiedPoints.
    Certificate certify(const ControlPoints& points,
                        const TransducerArray& array,
                        const Medium& medium,
                        const Eigen::VectorXcf& q = {});

    const CertificateOptions& options() const { return _options; }

private:
    CertificateOptions _options;
    PropagationMatrix _propagation;
};

} // namespace midair::haptics
