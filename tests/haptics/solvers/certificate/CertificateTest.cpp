#include "haptics/solvers/certificate/Certificate.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "tests/haptics/solvers/PhaseScenes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <cmath>
#include <complex>
#include <random>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

const double kPi = std::acos(-1.0);

// The least u* M u of three phases by a grid over the two that count, then ever finer ones about
// its minimum: nothing that the certificate uses.
double leastOfThree(const Eigen::MatrixXcd& M)
{
    double best = std::numeric_limits<double>::infinity(), x0 = kPi, y0 = kPi, half = kPi;
    for (int level = 0; level < 12; ++level)
    {
        double x1 = x0, y1 = y0;
        const int steps = level == 0 ? 720 : 20;
        for (int i = 0; i <= steps; ++i)
            for (int k = 0; k <= steps; ++k)
            {
                const double x = x0 + half * (2.0 * i / steps - 1.0);
                const double y = y0 + half * (2.0 * k / steps - 1.0);
                Eigen::Vector3cd u(1.0, std::polar(1.0, x), std::polar(1.0, y));
                const double value = u.dot(M * u).real();
                if (value < best)
                {
                    best = value;
                    x1 = x;
                    y1 = y;
                }
            }
        x0 = x1;
        y0 = y1;
        half *= level == 0 ? 4.0 / 720.0 : 0.2;
    }
    return best;
}

} // namespace

TEST(CertifiedBound, HoldsForAnyMultipliers)
{
    // Whatever y is, it must be a lower bound: here against all phases of three points, to the
    // grid's 1e-9.
    std::mt19937_64 random(11);
    for (int trial = 0; trial < 8; ++trial)
    {
        const Eigen::MatrixXcd A = randomMatrix(3, 3, random);
        const Eigen::MatrixXcd M = gramMatrix(A);
        const double least = leastOfThree(M);
        for (int k = 0; k < 5; ++k)
        {
            const Eigen::VectorXd y = randomMatrix(3, 1, random).real() * 3.0;
            EXPECT_LE(certifiedBound(M, y), least + 1e-9 * std::abs(least));
        }
    }
}

TEST(CertifiedBound, IsTheEigenvalueBoundLessWhatRoundingCanDo)
{
    // y = smallest eigenvalue of M everywhere: the bound is n times it, and must not come out
    // above.
    std::mt19937_64 random(13);
    for (int n : {1, 2, 10, 60})
    {
        const Eigen::MatrixXcd A = randomMatrix(n, 2 * n, random);
        const Eigen::MatrixXcd M = gramMatrix(A);
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd> eigen(M);
        const double smallest = eigen.eigenvalues()[0];
        const double bound = certifiedBound(M, Eigen::VectorXd::Zero(n));
        EXPECT_EQ(std::min(bound, 0.0), bound); // M >= 0 alone says no more than 0
        const double tight = certifiedBound(M, Eigen::VectorXd::Constant(n, smallest));
        EXPECT_LT(tight, n * smallest);
        EXPECT_NEAR(tight, n * smallest, 1e-9 * n * n * M.norm());
        // An indefinite M, too: the least is then negative.
        const Eigen::MatrixXcd shifted = M - 2.0 * M.norm() * Eigen::MatrixXcd::Identity(n, n);
        EXPECT_LT(certifiedBound(shifted, Eigen::VectorXd::Zero(n)),
                  n * (smallest - 2.0 * M.norm()));
    }
}

TEST(Certificate, MeetsTheTrueLeastOfThreePoints)
{
    // Three points: the relaxation is exact (a rank of sqrt(3) is 1), so bound, best and the grid's
    // least agree, as far as the tolerance asks.
    std::mt19937_64 random(17);
    CertificateOptions options;
    options.tolerance = 1e-5;
    Certifier certifier(options);
    for (int trial = 0; trial < 6; ++trial)
    {
        const Eigen::MatrixXcd G = randomMatrix(3, 4, random);
        const PhaseObjective objective(gramMatrix(G), Eigen::Vector3d(1.0, 0.7, 0.4));
        const Certificate certificate = certifier.certify(objective);
        const double least = leastOfThree(objective.M());
        EXPECT_LE(certificate.bound, least * (1.0 + 1e-9));
        EXPECT_NEAR(certificate.best, least, 1e-7 * least); // the descent's own tolerance
        EXPECT_NEAR(certificate.bound, least, 1e-4 * least);
        EXPECT_TRUE(certificate.tight);
        EXPECT_EQ(certificate.rank, 1);
    }
}

TEST(Certificate, BoundIsBelowAndBestIsAtWhatManyStartsFind)
{
    std::mt19937_64 random(19);
    for (int n : {2, 5, 8, 12})
    {
        const PhaseObjective objective = prismObjective(spherePoints(n, 0.02));
        const Certificate certificate = Certifier().certify(objective);
        double least = std::numeric_limits<double>::infinity();
        for (int start = 0; start < 300; ++start)
        {
            Eigen::VectorXcd u = randomPhases(n, random);
            least = std::min(least, objective.descend(u));
        }
        EXPECT_LE(certificate.bound, least);
        EXPECT_LE(certificate.bound, certificate.relaxed);
        EXPECT_NEAR(certificate.best, least, 1e-6 * least) << "n = " << n;
        EXPECT_NEAR(certificate.best, objective.value(certificate.phases), 1e-12 * least);
        EXPECT_LT((certificate.phases.cwiseAbs().array() - 1.0).abs().maxCoeff(), 1e-12);
    }
}

TEST(Certificate, PhasesOnTheSphereComeAsNearAsThreeThousandStarts)
{
    // The best of 3,000 starts of coordinate descent were measured 0.87 % (n = 50) and 2.42 % (n =
    // 100) over the bound, with points and air that were a little different; asked for with a
    // little room.
    for (const auto& [n, most] : {std::pair(50, 0.010), std::pair(100, 0.026)})
        for (std::uint64_t seed : {1, 2, 3})
        {
            CertificateOptions options;
            options.seed = seed;
            Certifier certifier(options);
            const Certificate certificate = certifier.certify(
                spherePoints(n, 0.03), TransducerArray::octagonalPrism(), Medium());
            EXPECT_TRUE(certificate.tight);
            EXPECT_GT(certificate.bound, 0.0);
            EXPECT_LE(certificate.gap(), most) << "n = " << n << ", seed " << seed;
            EXPECT_LE((certificate.relaxed - certificate.bound) / certificate.relaxed,
                      options.tolerance);
            RecordProperty("gap_percent_n" + std::to_string(n) + "_seed" + std::to_string(seed),
                           std::to_string(100.0 * certificate.gap()));
        }
}

TEST(Certificate, KnowsHowFarAGivenFieldIs)
{
    const ControlPoints points = spherePoints(24, 0.03);
    const TransducerArray array = TransducerArray::octagonalPrism();
    const PhaseObjective objective = prismObjective(points);
    Certifier certifier;
    std::mt19937_64 random(23);

    // A field made from the best phases is at the best; one of random activations is far off.
    const Certificate alone = certifier.certify(points, array, Medium());
    EXPECT_FALSE(alone.hasGiven);
    const Eigen::MatrixXcd G = referencePropagationMatrix(points.positions, array, Medium());
    const Eigen::VectorXcf good =
        (G.adjoint() * objective.weights(alone.phases)).cast<std::complex<float>>();
    const Certificate ofGood = certifier.certify(points, array, Medium(), good);
    ASSERT_TRUE(ofGood.hasGiven);
    // Its pressures' phases are u but for the little that lambda turns them; its own cost is below
    // that of its phases.
    EXPECT_LE(ofGood.givenField, alone.best * (1.0 + 1e-5));
    EXPECT_NEAR(ofGood.givenField, alone.best, 2e-2 * alone.best);
    EXPECT_LT(ofGood.gapOfPhases(), 0.02);

    const Eigen::VectorXcf noise = randomPhases(array.size(), random).cast<std::complex<float>>();
    const Certificate ofNoise = certifier.certify(points, array, Medium(), noise);
    EXPECT_GT(ofNoise.gapOfField(), 0.2);
    EXPECT_GT(ofNoise.gapOfPhases(), 0.05);
    for (const Certificate& certificate : {ofGood, ofNoise})
    {
        EXPECT_GE(certificate.givenPhases, certificate.bound);
        EXPECT_GE(certificate.givenField, certificate.bound);
        EXPECT_GE(certificate.givenPhases, certificate.best * (1.0 - 1e-9));
        EXPECT_GT(certificate.matrix_ms, 0.0);
        EXPECT_GE(certificate.total_ms, certificate.matrix_ms + certificate.bound_ms);
    }
}

TEST(Certificate, DoesNotDependOnPhaseScaleOrOrder)
{
    std::mt19937_64 random(29);
    const Eigen::MatrixXcd G = randomMatrix(10, 14, random);
    Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(10, 0.3, 1.0);
    Certifier certifier;
    const Certificate plain = certifier.certify(PhaseObjective(gramMatrix(G), a));
    // The tolerance of the bound allows 3e-4; the best phases are the same to the descent's 1e-8.
    const auto expectSame = [&](const Certificate& other, double scale, const char* what)
    {
        EXPECT_NEAR(other.best / scale, plain.best, 1e-6 * plain.best) << what;
        EXPECT_NEAR(other.bound / scale, plain.bound, 6e-4 * plain.bound) << what;
    };
    expectSame(certifier.certify(PhaseObjective(gramMatrix(G), 5000.0 * a)), 25e6, "louder");
    expectSame(certifier.certify(PhaseObjective(gramMatrix(Eigen::MatrixXcd(1e6 * G)), a)),
               1.0,
               "stronger array");
    // Phases of the points' reference and of the transducers do not count.
    const Eigen::VectorXcd rows = randomPhases(10, random), columns = randomPhases(14, random);
    const Eigen::MatrixXcd turned = rows.asDiagonal() * G * columns.asDiagonal();
    expectSame(certifier.certify(PhaseObjective(gramMatrix(turned), a)), 1.0, "turned");
    const Eigen::MatrixXcd backwards = G.colwise().reverse();
    expectSame(
        certifier.certify(PhaseObjective(gramMatrix(backwards), Eigen::VectorXd(a.reverse()))),
        1.0,
        "permuted");
    // Identical input, identical output.
    const Certificate again = certifier.certify(PhaseObjective(gramMatrix(G), a));
    EXPECT_EQ(again.bound, plain.bound);
    EXPECT_EQ(again.phases, plain.phases);
}

TEST(Certificate, HoldsUnderStress)
{
    // One point, coincident points, points without a target, a target of a million, a nearly
    // singular K.
    Certifier certifier;
    const TransducerArray array = TransducerArray::singleBoard();
    ControlPoints points;
    points.positions.resize(3, 6);
    points.positions << 0.0, 0.0, 0.0, 1e-4, 0.02, 5.0, //
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0,                   //
        0.1, 0.1, 0.1, 0.1, 0.1, 10.0;
    points.normals = Eigen::Vector3d::UnitZ().replicate(1, 6);
    for (const double large : {1.0, 1e6})
        for (const double lambdaRel : {1e-5, 0.1, 1e6})
        {
            CertificateOptions options;
            options.lambdaRel = lambdaRel;
            points.targets.resize(6);
            points.targets << 1.0, 1.0, 0.0, 1.0, large, 0.5;
            const Certificate certificate = Certifier(options).certify(points, array, Medium());
            EXPECT_TRUE(std::isfinite(certificate.bound) && std::isfinite(certificate.best));
            EXPECT_GE(certificate.bound, 0.0);
            EXPECT_LE(certificate.bound, certificate.best);
            EXPECT_TRUE(certificate.phases.allFinite());
        }
    ControlPoints one;
    one.positions = Eigen::Vector3d(0.0, 0.0, 0.1);
    one.normals = Eigen::Vector3d::UnitZ();
    one.targets = Eigen::VectorXd::Ones(1);
    const Certificate single = certifier.certify(one, array, Medium());
    // One point: K/(K + lambda) leaves 0.1/1.1.
    EXPECT_NEAR(single.bound, 0.1 / 1.1, 1e-10);
    EXPECT_NEAR(single.best, 0.1 / 1.1, 1e-10);
}

TEST(Certificate, RefusesWithAReason)
{
    Certifier certifier;
    const TransducerArray array = TransducerArray::singleBoard();
    const auto text = [&](const ControlPoints& points, const Eigen::VectorXcf& q)
    {
        try
        {
            certifier.certify(points, array, Medium(), q);
        }
        catch (const midair::base::InputError& error)
        {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    const char* const points = "certificate: there must be at least one control point and one "
                               "transducer, at finite places";
    ControlPoints nan = spherePoints(3, 0.03);
    nan.positions(1, 1) = std::nan("");
    EXPECT_EQ(text(nan, {}), points);
    EXPECT_EQ(text(ControlPoints(), {}), points);
    const char* const activations =
        "certificate: the activations must be finite, one for each of the 249 transducers";
    EXPECT_EQ(text(spherePoints(3, 0.03), Eigen::VectorXcf::Ones(4)), activations);
    EXPECT_EQ(text(spherePoints(3, 0.03), Eigen::VectorXcf::Constant(249, std::nanf(""))),
              activations);

    CertificateOptions options;
    options.lambdaRel = 0.0;
    std::string error;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "certificate options: lambdaRel is 0; it must be within 1e-5 .. 1e9");
    EXPECT_THROW(Certifier{options}, midair::base::InputError);
}
