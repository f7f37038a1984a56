// What arithmetic can add to a certificate's bound, against least values in long double.
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/certificate/Certificate.h"
#include "tests/haptics/solvers/PhaseScenes.h"

#include <Eigen/LU>

#include <algorithm>
#include <complex>
#include <limits>
#include <random>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

using LongMatrix = Eigen::Matrix<std::complex<long double>, Eigen::Dynamic, Eigen::Dynamic>;

// M of points before an array, in long double from G on: with none of the certificate's rounding.
LongMatrix exactMatrix(const ControlPoints& points, const TransducerArray& array, double lambdaRel)
{
    const LongMatrix G = referencePropagationMatrix(points.positions, array, Medium())
                             .cast<std::complex<long double>>();
    LongMatrix A = G * G.adjoint();
    const long double lambda = lambdaRel * A.trace().real() / static_cast<long double>(A.cols());
    A.diagonal().array() += lambda;
    const LongMatrix a = points.targets.cast<std::complex<long double>>().asDiagonal();
    return lambda * (a * A.inverse() * a);
}

// The least u* M u that coordinate descent finds from many starts, all in long double.
double leastOfMany(const LongMatrix& M, int starts, std::mt19937_64& random)
{
    using Vector = Eigen::Matrix<std::complex<long double>, Eigen::Dynamic, 1>;
    long double best = std::numeric_limits<long double>::infinity();
    for (int start = 0; start < starts; ++start)
    {
        Vector u =
            randomPhases(static_cast<int>(M.cols()), random).cast<std::complex<long double>>();
        long double value = std::numeric_limits<long double>::infinity();
        for (int round = 0; round < 5000; ++round)
        {
            for (Eigen::Index l = 0; l < u.size(); ++l)
            {
                const std::complex<long double> rest = (M.row(l) * u)(0) - M(l, l) * u[l];
                if (std::abs(rest) > 0.0L) u[l] = -rest / std::abs(rest);
            }
            const long double now = u.dot(M * u).real();
            const bool still = !(now < value * (1.0L - 1e-12L));
            value = now;
            if (still) break;
        }
        best = std::min(best, value);
    }
    return static_cast<double>(best);
}

// Points a fraction of a wavelength apart before a board, whose K is nearly singular, with targets
// that only its smallest eigenvalues could serve.
ControlPoints nearPoints(int n, double apart_m, std::mt19937_64& random)
{
    std::uniform_real_distribution<double> place(0.0, apart_m);
    ControlPoints points = spherePoints(n, 0.01);
    for (int l = 0; l < n; ++l)
    {
        const double x = apart_m * l + 0.2 * place(random), y = place(random);
        points.positions.col(l) = Eigen::Vector3d(x, y, 0.15 + place(random));
        points.targets[l] = l % 2 == 0 ? 1.0 : 0.3;
    }
    return points;
}

} // namespace

TEST(Certificate, IsABoundInSpiteOfRoundingForSmallLambdaToo)
{
    // For a small lambda M hangs on the last digits of K. With G and K in float the bound came out
    // over the least value by up to 9e-3 of it for 1e-5, 1e-3 for 1e-4 and 3e-6 for 0.1.
    std::mt19937_64 random(31);
    const TransducerArray array = TransducerArray::singleBoard();
    for (const double lambdaRel : {1e-5, 1e-4, 2e-4, 1e-3, 0.1})
        for (const double apart_m : {1e-4, 3e-4, 1e-3, 3e-3})
            for (const int n : {2, 3, 4, 3, 2, 8})
            {
                SCOPED_TRACE(testing::Message()
                             << n << " points, " << apart_m << " m, lambda " << lambdaRel);
                const ControlPoints points = nearPoints(n, apart_m, random);
                const double least = leastOfMany(exactMatrix(points, array, lambdaRel), 20, random);
                CertificateOptions options;
                options.lambdaRel = lambdaRel;
                options.tolerance = 1e-7; // as tight as the relaxation's float lets it be
                const Certificate certificate = Certifier(options).certify(points, array, Medium());
                EXPECT_LE(certificate.bound, least);
                EXPECT_GE(certificate.best, certificate.bound);
                // Not by saying little. The relaxation, in float, ends above its bound.
                EXPECT_GE(certificate.bound, 0.97 * certificate.relaxed);
                if (n > 3) continue;
                // Of up to three points it is exact, so that only rounding is between them.
                EXPECT_GE(certificate.bound, 0.97 * least);
            }
}

TEST(Certificate, LosesLittleToWhatRoundingMayAdd)
{
    const ControlPoints points = spherePoints(100, 0.03);
    const TransducerArray array = TransducerArray::octagonalPrism();
    for (const auto& [lambdaRel, most] : {std::pair(0.1, 1e-7), std::pair(1e-4, 1e-4)})
    {
        CertificateOptions options;
        options.lambdaRel = lambdaRel;
        options.batches = 0;
        const PhaseObjective objective = prismObjective(points, lambdaRel);
        PhaseRelaxation relaxation(objective, options.seed);
        relaxation.descend(options.maxRounds, options.tolerance / 300.0);
        const double plain = certifiedBound(objective.M(), relaxation.y());
        options.maxRounds = relaxation.rounds();
        const double bound = Certifier(options).certify(points, array, Medium()).bound;
        EXPECT_LT(bound, plain);
        EXPECT_GT(bound, plain * (1.0 - most)) << lambdaRel;
    }
}

TEST(Certificate, OfAFaintArrayIsThatOfALoudOne)
{
    const ControlPoints points = spherePoints(10, 0.02);
    TransducerArray array = TransducerArray::singleBoard();
    const Eigen::VectorXcf q = Eigen::VectorXcf::Ones(array.size());
    const Certificate loud = Certifier().certify(points, array, Medium(), q);
    for (const double source : {1e-300, 1e-30, 1e5})
    {
        array.sourceAmplitude_Pa_m = source;
        const Certificate other = Certifier().certify(points, array, Medium(), q);
        EXPECT_EQ(other.bound, loud.bound) << source;
        EXPECT_EQ(other.givenField, loud.givenField) << source;
    }
    array.gain = Eigen::VectorXd::Constant(array.size(), 1e-200);
    EXPECT_NEAR(
        Certifier().certify(points, array, Medium(), q).bound, loud.bound, 1e-9 * loud.bound);
}
