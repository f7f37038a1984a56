// Pressures that something outside the array's model adds (ControlPoints::outside_Pa).

#include "haptics/base/InputError.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/solvers/certificate/Certificate.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>
#include <complex>
#include <limits>
#include <random>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

const Eigen::Vector3d kCentre(0.0, 0.0, 0.15);

// A model of the application: a small thing scatters a share of the pressure at its place.
class SmallThing
{
public:
    SmallThing(const ControlPoints& points, const TransducerArray& array) : _atPoints(points.size())
    {
        const Eigen::Vector3d place = kCentre + Eigen::Vector3d(0.0, 0.012, 0.03);
        const double k = 2.0 * M_PI / Medium().wavelength(array.frequency_Hz);
        for (int l = 0; l < points.size(); ++l)
        {
            const double r = (points.positions.col(l) - place).norm();
            _atPoints[l] = std::polar(8e-3 / r, -k * r);
        }
        _toPlace = referencePropagationMatrix(place, array, Medium());
    }
    Eigen::VectorXcd of(const Eigen::VectorXcf& q) const
    {
        return _atPoints * (_toPlace * q.cast<std::complex<double>>())[0];
    }

private:
    Eigen::VectorXcd _atPoints;
    Eigen::MatrixXcd _toPlace;
};

double rmsOf(const Eigen::VectorXcd& p, const Eigen::VectorXd& targets, double* level = nullptr)
{
    const Eigen::VectorXd y = p.cwiseAbs();
    const double s = y.dot(targets) / targets.squaredNorm();
    if (level) *level = s * targets.maxCoeff();
    return std::sqrt((y.array() / (s * targets.array()) - 1.0).square().mean());
}

ControlPoints unequalPoints()
{
    ControlPoints points = spherePoints(24, 0.02, kCentre);
    points.targets[3] = 0.5;
    points.targets[7] = 0.01; // too quiet for 16 bits of G
    return points;
}

Eigen::VectorXcd someOutside(Eigen::Index n, double amplitude_Pa)
{
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0.0, amplitude_Pa);
    Eigen::VectorXcd o(n);
    for (Eigen::Index l = 0; l < n; ++l)
        o[l] = {normal(random), normal(random)};
    return o;
}

// Solves free of outside pressures, then with some, and compares the report with sums in double.
void expectTrueReport(const std::string& solver,
                      ControlPoints points,
                      const TransducerArray& array,
                      double tolerance)
{
    const auto made = makeSolver(solver);
    Eigen::VectorXcf q;
    const SolveReport free = made->solve(points, array, Medium(), q);
    points.outside_Pa = someOutside(points.size(), 0.05 * free.level_Pa);
    const Eigen::VectorXcd drive = q.cast<std::complex<double>>();
    const SolveReport report = made->solve(points, array, Medium(), q);
    const Eigen::VectorXcd played = q.cast<std::complex<double>>();
    const Eigen::VectorXcd Gq =
        referencePropagationMatrix(points.positions, array, Medium()) * played;
    const Eigen::VectorXcd outside = points.outside_Pa * (drive.dot(played) / drive.squaredNorm());
    double level_Pa = 0.0;
    const double rms = rmsOf(Gq + outside, points.targets, &level_Pa);
    EXPECT_NEAR(report.rms, rms, tolerance) << solver;
    EXPECT_NEAR(report.level_Pa, level_Pa, 1e-3 * level_Pa) << solver;
    EXPECT_GT(((Gq + outside).cwiseAbs() - Gq.cwiseAbs()).norm(), 0.02 * Gq.norm())
        << solver << " is told what changes nothing";
}

} // namespace

TEST(OutsideField, EverySolverReportsTheSumInDouble)
{
    ControlPoints equal = spherePoints(24, 0.02, kCentre);
    for (const std::string& name : solverNames())
        expectTrueReport(name, equal, TransducerArray::singleBoard(), 2e-4);
}

TEST(OutsideField, RowsAreAddedToThoseOfTheArray)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.dead = {3};
    array.gain = Eigen::VectorXd::Ones(array.size());
    array.gain[3] = 0.0;
    ControlPoints points = unequalPoints();
    points.targets[5] = 0.0; // left out: rows are taken by the points that stay
    const Eigen::MatrixXcd G = referencePropagationMatrix(points.positions, array, Medium());
    Eigen::MatrixXcd R(points.size(), array.size());
    for (Eigen::Index i = 0; i < R.cols(); ++i)
        R.col(i) = someOutside(points.size(), 0.1 * G.cwiseAbs().mean()) *
                   std::polar(1.0, 0.7 * static_cast<double>(i * i));
    points.outsideRows_Pa = std::make_shared<const Eigen::MatrixXcf>(R.cast<std::complex<float>>());
    const auto expectTrue = [&](const Eigen::VectorXcd& outside, const SolveReport& report, auto& q)
    {
        const Eigen::VectorXcd p = (G + R) * q.template cast<std::complex<double>>() + outside;
        std::vector<int> kept;
        for (int l = 0; l < points.size(); ++l)
            if (points.targets[l] > 0.0) kept.push_back(l);
        double level_Pa = 0.0;
        const double rms = rmsOf(p(kept).eval(), points.targets(kept).eval(), &level_Pa);
        EXPECT_NEAR(report.rms, rms, 2e-3) << report.solver;
        EXPECT_NEAR(report.level_Pa, level_Pa, 1e-3 * level_Pa) << report.solver;
    };
    for (const std::string& name : solverNames())
    {
        const auto solver = makeSolver(name);
        points.outside_Pa.resize(0);
        Eigen::VectorXcf q;
        SolveReport report = solver->solve(points, array, Medium(), q);
        expectTrue(Eigen::VectorXcd::Zero(points.size()), report, q);
        // With what the rows have not, of the last drive.
        points.outside_Pa = someOutside(points.size(), 0.05 * report.level_Pa);
        const Eigen::VectorXcd drive = q.cast<std::complex<double>>();
        report = solver->solve(points, array, Medium(), q);
        expectTrue(points.outside_Pa *
                       (drive.dot(q.cast<std::complex<double>>()) / drive.squaredNorm()),
                   report,
                   q);
    }
    // And leave no trace.
    const auto solver = makeSolver("gauss-newton");
    Eigen::VectorXcf q;
    points.outside_Pa.resize(0);
    solver->solve(points, array, Medium(), q);
    points.outsideRows_Pa = nullptr;
    R.setZero();
    const SolveReport free = solver->solve(points, array, Medium(), q);
    expectTrue(Eigen::VectorXcd::Zero(points.size()), free, q);
}

TEST(OutsideField, CountsAtQuietPointsAndBesideReflectors)
{
    expectTrueReport("gauss-newton", unequalPoints(), TransducerArray::singleBoard(), 2e-3);
    TransducerArray array = TransducerArray::singleBoard();
    array.reflectors.resize(1);
    array.reflectors[0].position = {0.0, 0.0, 0.25};
    array.reflectors[0].accuracy_mm = 0.1;
    const ControlPoints equal = spherePoints(24, 0.02, kCentre);
    expectTrueReport("gauss-newton", equal, array, 2e-4); // a plane without end
    array.reflectors[0].size_m = {0.1, 0.1};
    expectTrueReport("gauss-newton", equal, array, 3e-4);
}

TEST(OutsideField, CallsInTurnEndAtTheTrueField)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points = spherePoints(25, 0.03, kCentre);
    const SmallThing thing(points, array);
    const Eigen::MatrixXcd G = referencePropagationMatrix(points.positions, array, Medium());
    const auto truth = [&](const Eigen::VectorXcf& q)
    { return rmsOf(G * q.cast<std::complex<double>>() + thing.of(q), points.targets); };
    const auto solver = makeSolver("gauss-newton");
    Eigen::VectorXcf q;
    solver->solve(points, array, Medium(), q);
    EXPECT_GT(truth(q), 0.02) << "the thing is felt";
    for (int k = 0; k < 4; ++k)
    {
        points.outside_Pa = thing.of(q);
        const SolveReport report = solver->solve(points, array, Medium(), q);
        EXPECT_LE(report.rms, 1e-3) << k;
    }
    EXPECT_LE(truth(q), 1e-3);
}

TEST(OutsideField, LeavesNoTraceInTheNextFreeField)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.drive.phaseLevels =
        0; // levels would differ with the common phase, which follows the last
    const ControlPoints free = spherePoints(24, 0.02, kCentre);
    ControlPoints points = free;
    SolverOptions options;
    options.warmStart = false;
    const auto solver = makeSolver("gauss-newton", options);
    Eigen::VectorXcf expected, q;
    solver->solve(free, array, Medium(), expected);
    q = expected;
    points.outside_Pa = someOutside(24, 50.0);
    solver->solve(points, array, Medium(), q);
    EXPECT_LT(std::abs(q.dot(expected)), 0.9999f * expected.squaredNorm());
    solver->solve(free, array, Medium(), q);
    EXPECT_NEAR(std::abs(q.dot(expected)), expected.squaredNorm(), 1e-5f * expected.squaredNorm());
}

TEST(OutsideField, IsRefusedByName)
{
    const TransducerArray array = TransducerArray::singleBoard();
    const ControlPoints free = spherePoints(24, 0.02, kCentre);
    const auto refusal = [&](const Eigen::VectorXcd& outside_Pa, Eigen::VectorXcf q)
    {
        ControlPoints points = free;
        points.outside_Pa = outside_Pa;
        const SolveReport report = makeSolver("gauss-newton")->solve(points, array, Medium(), q);
        EXPECT_EQ(report.stop, StopReason::REFUSED);
        EXPECT_TRUE(q.isZero());
        return report.message;
    };
    const Eigen::VectorXcf ones = Eigen::VectorXcf::Ones(array.size());
    EXPECT_EQ(refusal(Eigen::VectorXcd::Ones(23), ones),
              "there are 24 control points and 23 outside pressures");
    Eigen::VectorXcd broken = Eigen::VectorXcd::Ones(24);
    broken[5] = {0.0, std::numeric_limits<double>::quiet_NaN()};
    EXPECT_NE(refusal(broken, ones).find("control point 5 has the outside pressure (0, nan) Pa"),
              std::string::npos);
    const std::string drive = "outside pressures belong to the drive that is passed, which must be "
                              "249 finite activations, not all 0";
    EXPECT_EQ(refusal(Eigen::VectorXcd::Ones(24), {}), drive);
    EXPECT_EQ(refusal(Eigen::VectorXcd::Ones(24), 0.0f * ones), drive);
    EXPECT_EQ(refusal(Eigen::VectorXcd::Ones(24), ones / 0.0f), drive);
}

TEST(OutsideField, WrongRowsAreRefusedByName)
{
    const TransducerArray array = TransducerArray::singleBoard();
    ControlPoints points = spherePoints(24, 0.02, kCentre);
    const auto refusal = [&](Eigen::MatrixXcf rows)
    {
        points.outsideRows_Pa = std::make_shared<const Eigen::MatrixXcf>(std::move(rows));
        Eigen::VectorXcf q;
        const SolveReport report = makeSolver("gauss-newton")->solve(points, array, Medium(), q);
        EXPECT_EQ(report.stop, StopReason::REFUSED);
        EXPECT_TRUE(q.isZero());
        return report.message;
    };
    EXPECT_EQ(refusal(Eigen::MatrixXcf::Ones(23, 249)),
              "the outside rows are 23 x 249; for 24 control points and 249 transducers they must "
              "be 24 x 249");
    Eigen::MatrixXcf broken = Eigen::MatrixXcf::Ones(24, 249);
    broken(7, 7) = {0.0f, std::numeric_limits<float>::quiet_NaN()};
    EXPECT_EQ(refusal(broken), "the outside rows must be finite and at most 1e+12 Pa");
    broken(7, 7) = 2e12f;
    EXPECT_EQ(refusal(broken), "the outside rows must be finite and at most 1e+12 Pa");
    EXPECT_THROW(Certifier().certify(points, array, Medium(), Eigen::VectorXcf::Ones(249)),
                 midair::base::InputError);
}

TEST(OutsideField, IsCertified)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.gain = Eigen::VectorXd::Constant(array.size(), 2.0);
    ControlPoints points = spherePoints(12, 0.02, kCentre);
    Eigen::VectorXcf q;
    const SolveReport free = makeSolver("gauss-newton")->solve(points, array, Medium(), q);
    points.outside_Pa = someOutside(12, 0.2 * free.level_Pa);
    const Certificate certificate = Certifier().certify(points, array, Medium(), q);
    const Eigen::VectorXcd drive = q.cast<std::complex<double>>();
    Eigen::MatrixXcd G = referencePropagationMatrix(points.positions, array, Medium());
    G += points.outside_Pa * drive.adjoint() / drive.squaredNorm();
    const Certificate expected =
        Certifier().certify(PhaseObjective(gramMatrix(G), points.targets), G * drive);
    EXPECT_NEAR(certificate.bound, expected.bound, 1e-4 * expected.bound);
    EXPECT_NEAR(certificate.givenPhases, expected.givenPhases, 1e-6 * expected.givenPhases);
    points.outside_Pa.conservativeResize(11);
    EXPECT_THROW(Certifier().certify(points, array, Medium(), q), midair::base::InputError);
}

TEST(OutsideField, IsPickedAndAppended)
{
    ControlPoints points = spherePoints(3, 0.02);
    points.outside_Pa = Eigen::Vector3cd(1.0, 2.0, 3.0);
    EXPECT_EQ(pick(points, {2, 0}).outside_Pa, Eigen::Vector2cd(3.0, 1.0));
    ControlPoints both = spherePoints(1, 0.02);
    append(both, points);
    EXPECT_EQ(both.outside_Pa, Eigen::Vector4cd(0.0, 1.0, 2.0, 3.0));
    EXPECT_EQ(pick(spherePoints(3, 0.02), {1}).outside_Pa.size(), 0);
    points.outsideRows_Pa = std::make_shared<const Eigen::MatrixXcf>(
        Eigen::Vector3cf(1.0f, 2.0f, 3.0f).replicate(1, 2));
    EXPECT_EQ(*pick(points, {2, 0}).outsideRows_Pa,
              Eigen::Vector2cf(3.0f, 1.0f).replicate(1, 2).eval());
    both = spherePoints(1, 0.02);
    append(both, points);
    EXPECT_EQ(*both.outsideRows_Pa,
              Eigen::Vector4cf(0.0f, 1.0f, 2.0f, 3.0f).replicate(1, 2).eval());
    ControlPoints other = spherePoints(1, 0.02);
    other.outsideRows_Pa = std::make_shared<const Eigen::MatrixXcf>(Eigen::MatrixXcf::Ones(1, 3));
    append(both, other);
    EXPECT_EQ(both.outsideRows_Pa->rows(), 4) << "of another array: solvers refuse them";
    EXPECT_EQ(pick(spherePoints(3, 0.02), {1}).outsideRows_Pa, nullptr);
}
