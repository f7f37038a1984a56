#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/scattering/RigidBody.h"
#include "haptics/scattering/RoundBody.h"
#include "haptics/scattering/SceneScattering.h"
#include "haptics/scattering/ThinScreen.h"
#include "haptics/surface/FlatFaces.h"
#include "tests/haptics/scattering/Plates.h"
#include "tests/haptics/scattering/Scattered.h"
#include "tests/haptics/solvers/ScenePoints.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <cmath>
#include <complex>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

using namespace midair;
using midair::test::ballOf;
using midair::test::boxOf;
using midair::test::fieldOf;
using midair::test::kWavelength_m;

namespace
{

using Complex = std::complex<double>;

const Eigen::Vector3d kMiddle = Eigen::Vector3d::Zero();
const double kWaveNumber = base::kTwoPi / kWavelength_m;

// The series of a rigid ball, apart from the product: p_s = jk sum (2n+1) j'(ka)/h'(ka) h(k r0) h(k
// r) P_n with h of the second kind (Bowman, Senior, Uslenghi 1969, 10.3).
Complex hankel(int n, double x)
{
    return {std::sph_bessel(static_cast<unsigned>(n), x),
            -std::sph_neumann(static_cast<unsigned>(n), x)};
}
template<typename Function>
auto slopeOf(Function&& f, int n, double x)
{
    return n == 0 ? -f(1, x) : f(n - 1, x) - (n + 1.0) / x * f(n, x);
}
Complex ballField(double a, double source, double r, double cosine)
{
    const double k = kWaveNumber;
    const auto bessel = [](int n, double x)
    { return std::sph_bessel(static_cast<unsigned>(n), x); };
    Complex sum = 0.0;
    for (int n = 0; n < static_cast<int>(k * a) + 25; ++n)
    {
        const Complex term = (2.0 * n + 1.0) * slopeOf(bessel, n, k * a) /
                             slopeOf(hankel, n, k * a) * hankel(n, k * source) * hankel(n, k * r) *
                             std::legendre(static_cast<unsigned>(n), cosine);
        if (std::isfinite(std::abs(term))) sum += term;
    }
    return Complex(0.0, k) * sum;
}

haptics::RigidBody rigid(const haptics::TriangleMesh& mesh)
{
    return {haptics::RigidBody::divided(mesh, kWavelength_m), kWavelength_m, 2};
}

/// The rms error of \a ball, of the radius a, at places \a off of it, over the incident field.
double ballError(const haptics::RigidBody& ball, double a, double off)
{
    const double distance = a + 0.05;
    Eigen::VectorXcd onBall;
    const haptics::GmresReport report =
        ball.solve(fieldOf({0.0, 0.0, distance}, kWaveNumber, ball), onBall);
    EXPECT_TRUE(report.isConverged);
    EXPECT_LT(report.iterations, 40);
    constexpr int kPoints = 60;
    Eigen::Matrix3Xd points(3, kPoints);
    for (int i = 0; i < kPoints; ++i)
    {
        const double angle = M_PI * i / (kPoints - 1);
        points.col(i) = (a + off) * Eigen::Vector3d(std::sin(angle), 0.0, std::cos(angle));
    }
    const Eigen::VectorXcd scattered = ball.scattered(points, onBall, 2);
    double off2 = 0.0, incident2 = 0.0;
    for (int i = 0; i < kPoints; ++i)
    {
        const double cosine = std::cos(M_PI * i / (kPoints - 1));
        off2 += std::norm(scattered[i] - ballField(a, distance, a + off, cosine));
        incident2 += 1.0 / (points.col(i) - Eigen::Vector3d(0.0, 0.0, distance)).squaredNorm();
    }
    return std::sqrt(off2 / incident2);
}
double ballError(double ka)
{
    const double a = ka / kWaveNumber;
    return ballError(rigid(ballOf(a, kWavelength_m / haptics::RigidBody::kElements)), a, 1e-3);
}

std::string refusalOf(const haptics::TriangleMesh& mesh)
{
    try
    {
        haptics::ClosedBody::from(mesh, 2e-3, 10000);
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return "none";
}

haptics::ThinScreen screenOf(double cells)
{
    haptics::ScreenPlate plate;
    plate.size_m = {0.06, 0.048};
    return {plate, kWavelength_m, cells};
}

Eigen::Matrix3Xd aroundScreen()
{
    Eigen::Matrix3Xd points(3, 100);
    for (Eigen::Index i = 0; i < points.cols(); ++i)
    {
        const double t = static_cast<double>(i);
        points.col(i) << 0.03 * std::sin(1.7 * t), 0.025 * std::cos(2.3 * t),
            (i % 2 == 0 ? 1.0 : -1.0) * (0.003 + 0.03 * std::fmod(0.377 * t, 1.0));
    }
    return points;
}

Eigen::VectorXcd screenField(const haptics::ThinScreen& screen, const Eigen::Vector3d& source)
{
    Eigen::VectorXcd jump;
    EXPECT_TRUE(screen.solve(fieldOf(source, kWaveNumber, screen), jump).isConverged);
    return screen.scattered(aroundScreen(), jump, 2);
}

} // namespace

TEST(RigidBody, IsRightAboutBallsWithinTwoPercentOfTheIncidentField)
{
    for (const double ka : {3.0, 5.0, 8.0})
        EXPECT_LT(ballError(ka), 0.012) << ka;
}

// As coarse as the largest hand: palm, and fingertip.
TEST(RigidBody, IsAsRightAsItSaysAtTheElementsOfAHand)
{
    for (const double a : {14e-3, 8e-3})
    {
        haptics::ClosedBody body =
            haptics::ClosedBody::from(haptics::roundBody({{kMiddle, kMiddle, a, a}}, 4e-3),
                                      std::numeric_limits<double>::infinity(),
                                      1000);
        const double elements = kWavelength_m / body.meanSide_m();
        EXPECT_NEAR(elements, 2.9, 0.1) << a;
        const haptics::RigidBody ball(std::move(body), kWavelength_m, 2);
        EXPECT_NEAR(ballError(ball, a, 3e-3), haptics::RigidBody::expectedError(elements), 0.005)
            << a;
        EXPECT_LT(ballError(ball, a, 1e-3), 0.08) << a;
        EXPECT_LT(ballError(ball, a, 10e-3), 0.02) << a;
    }
}

TEST(RigidBody, ScattersTheSameWhereItIsMovedTo)
{
    const haptics::RigidBody still = rigid(ballOf(3e-3, 1.5e-3));
    haptics::RigidBody moved = still;
    const Eigen::Isometry3d motion = Eigen::Translation3d(0.1, -0.2, 0.3) *
                                     Eigen::AngleAxisd(1.0, Eigen::Vector3d(0.6, 0.0, 0.8));
    moved.moveBy(motion);
    const Eigen::Vector3d source(0.01, 0.0, 0.04);
    Eigen::VectorXcd first, second;
    still.solve(fieldOf(source, kWaveNumber, still), first);
    moved.solve(fieldOf(motion * source, kWaveNumber, moved), second);
    const Eigen::Matrix3Xd points = Eigen::Vector3d(0.0, 5e-3, 0.0);
    EXPECT_LT(
        std::abs((still.scattered(points, first) - moved.scattered(motion * points, second))[0]),
        1e-4 * std::abs(still.scattered(points, first)[0]));
    EXPECT_TRUE(moved.isInside(motion * Eigen::Vector3d::Zero()));
    EXPECT_FALSE(moved.isInside(Eigen::Vector3d::Zero()));
}

// ka of an inner resonance, j1'(ka) = 0 and j0(ka) = 0: other equations have no single solution.
TEST(RigidBody, IsRightAtInnerResonances)
{
    for (const double ka : {2.0816, M_PI, 4.4934})
        EXPECT_LT(ballError(ka), 0.012) << ka;
}

// Source and point change places.
TEST(RigidBody, IsReciprocal)
{
    const haptics::RigidBody box = rigid(boxOf({0.01, 0.009, 0.008}));
    const Eigen::Vector3d a(0.05, 0.01, 0.0), b(-0.02, 0.03, 0.02);
    const auto from = [&](const Eigen::Vector3d& source, const Eigen::Vector3d& point)
    {
        Eigen::VectorXcd onBox;
        EXPECT_TRUE(box.solve(fieldOf(source, kWaveNumber, box), onBox).isConverged);
        return box.scattered(point, onBox, 2)[0];
    };
    const Complex there = from(a, b);
    EXPECT_LT(std::abs(there - from(b, a)), 0.01 / (a - b).norm()) << "of the incident field";
}

TEST(ClosedBody, RefusesWhatIsNotClosedByName)
{
    const haptics::TriangleMesh box = boxOf({0.02, 0.02, 0.02});
    EXPECT_EQ(refusalOf(box), "none");
    haptics::TriangleMesh open = box;
    open.triangles = box.triangles.leftCols(11).eval();
    EXPECT_NE(refusalOf(open).find("a hole"), std::string::npos) << refusalOf(open);
    haptics::TriangleMesh turned = box;
    std::swap(turned.triangles(0, 3), turned.triangles(1, 3));
    EXPECT_NE(refusalOf(turned).find("wound differently"), std::string::npos) << refusalOf(turned);
    haptics::TriangleMesh twice = box;
    twice.vertices.resize(3, 16);
    twice.vertices << box.vertices, box.vertices;
    twice.triangles.resize(3, 24);
    twice.triangles << box.triangles, (box.triangles.array() + 8).matrix();
    EXPECT_NE(refusalOf(twice), "none") << "two boxes in one place";
    haptics::TriangleMesh lines = box;
    lines.triangles.conservativeResize(3, 13);
    lines.triangles.col(12) << 0, 7, 7;
    EXPECT_NE(refusalOf(lines).find("lines or points"), std::string::npos) << refusalOf(lines);
    haptics::TriangleMesh nan = box;
    nan.vertices(1, 2) = std::nan("");
    EXPECT_NE(refusalOf(nan), "none");
    EXPECT_NE(refusalOf(boxOf({1.0, 1.0, 1.0})).find("more than 10000"), std::string::npos);
}

TEST(ClosedBody, IsCountedBeforehand)
{
    const haptics::TriangleMesh mesh = *haptics::flatFacesOf(*sphere(0.01, 6)).body;
    for (const double longest_m : {1.0, 4e-3, 1.5e-3})
        EXPECT_EQ(haptics::ClosedBody::count(mesh, longest_m, 10000),
                  haptics::ClosedBody::from(mesh, longest_m, 10000).size());
    EXPECT_EQ(haptics::ClosedBody::count(mesh, 1.5e-3, 500), 500) << "no more are counted";
}

TEST(ClosedBody, PointsOutwardsHoweverItIsWound)
{
    haptics::TriangleMesh box = boxOf({0.02, 0.02, 0.02});
    for (const bool isTurned : {false, true})
    {
        if (isTurned) box.triangles.row(0).swap(box.triangles.row(1));
        const auto body = haptics::ClosedBody::from(box, 5e-3, 10000);
        for (Eigen::Index i = 0; i < body.size(); ++i)
            EXPECT_GT(
                body.normals.col(i).dot(body.centres.col(i) - Eigen::Vector3d::Constant(0.01)),
                0.0);
        EXPECT_NEAR(body.areas.sum(), 6 * 4e-4, 1e-9);
        EXPECT_TRUE(body.isInside({0.01, 0.005, 0.019}));
        EXPECT_FALSE(body.isInside({0.01, 0.005, 0.021}));
        EXPECT_FALSE(body.isInside({-0.01, 0.0, 0.0}));
    }
}

TEST(ThinScreen, ConvergesToOneField)
{
    const Eigen::Vector3d source(0.01, 0.005, 0.04);
    const Eigen::VectorXcd fine = screenField(screenOf(20.0), source);
    const auto error = [&](double cells)
    { return (screenField(screenOf(cells), source) - fine).norm() / fine.norm(); };
    EXPECT_LT(error(8.0), 0.006);
    EXPECT_LT(error(12.0), 0.003);
}

// A plate of 23 wavelengths: the image of the source before it, its shadow behind it, but for what
// comes from the edges, 0.1 m away.
TEST(ThinScreen, MirrorsInFrontAndShadesBehind)
{
    haptics::ScreenPlate plate;
    plate.size_m = {0.2, 0.2};
    const haptics::ThinScreen screen(plate, kWavelength_m, 6.0);
    const Eigen::Vector3d source(0.003, 0.001, 0.04), image(0.003, 0.001, -0.04);
    Eigen::VectorXcd jump;
    ASSERT_TRUE(screen.solve(fieldOf(source, kWaveNumber, screen), jump).isConverged);
    Eigen::Matrix3Xd points(3, 4);
    points << 0.0, 0.005, 0.0, 0.0, 0.0, 0.0, 0.01, 0.0, 0.02, 0.015, 0.03, -0.02;
    const Eigen::VectorXcd field = screen.scattered(points, jump, 2);
    const auto waveOf = [&](const Eigen::Vector3d& from, Eigen::Index point)
    {
        const double r = (points.col(point) - from).norm();
        return std::polar(1.0 / r, -kWaveNumber * r);
    };
    for (const Eigen::Index point : {0, 1, 2})
        EXPECT_LT(std::abs(field[point] / waveOf(image, point) - 1.0), 0.08) << point;
    EXPECT_LT(std::abs(field[3] / waveOf(source, 3) + 1.0), 0.08);
    EXPECT_LT(std::abs(field[3] + field[0]), 1e-9 * std::abs(field[0])) << "odd across the plate";
}

// The solver's images with a Fresnel weight are a model of a plate, whose edges scatter; the screen
// is the truth.
TEST(ThinScreen, SaysThatFieldsCorrectedByImagesAreNearTheTruth)
{
    struct Case
    {
        double side_m, behind_m, most;
    };
    const Eigen::Vector3d centre(0.0, 0.0, 0.15);
    const haptics::ControlPoints points = haptics::spherePoints(100, 0.03, centre);
    const haptics::TransducerArray free = midair::test::fourUnits();
    for (const Case& one : {Case{0.2, 0.1, 0.015}, Case{0.1, 0.04, 0.06}})
    {
        haptics::TransducerArray array = free;
        array.reflectors = {midair::test::plateBehind(centre, one.side_m, one.behind_m)};
        haptics::ScatteredField truth = midair::test::truthOf(array.reflectors.front(), free, 1);
        const auto errorFor = [&](const haptics::TransducerArray& rows)
        {
            return midair::test::rmsError(midair::test::pressuresOf(
                midair::test::driveFor(points, rows), points.positions, truth));
        };
        const double before = errorFor(free), after = errorFor(array);
        EXPECT_LT(after, one.most) << one.side_m;
        EXPECT_GT(before, 4.0 * after) << one.side_m;
    }
}

TEST(ThinScreen, RefusesWhatHasNoCells)
{
    haptics::ScreenPlate plate;
    EXPECT_THROW(haptics::ThinScreen(plate, kWavelength_m), base::InputError);
    plate.size_m = {std::nan(""), 0.1};
    EXPECT_THROW(haptics::ThinScreen(plate, kWavelength_m), base::InputError);
    plate.size_m = {10.0, 10.0};
    EXPECT_THROW(haptics::ThinScreen(plate, kWavelength_m), base::InputError);
}

TEST(Gmres, SolvesWhatAnEliminationSolves)
{
    std::srand(3);
    const Eigen::MatrixXcd A =
        Eigen::MatrixXcd::Random(40, 40) + 8.0 * Eigen::MatrixXcd::Identity(40, 40);
    const Eigen::VectorXcd b = Eigen::VectorXcd::Random(40);
    Eigen::VectorXcd x;
    const auto apply = [&](const Eigen::VectorXcd& in, Eigen::VectorXcd& out) { out = A * in; };
    const haptics::GmresReport report = haptics::gmres(apply, b, x, 1e-10, 100);
    EXPECT_TRUE(report.isConverged);
    EXPECT_LT((x - A.partialPivLu().solve(b)).norm(), 1e-8 * x.norm());
    EXPECT_NEAR((b - A * x).norm() / b.norm(), report.residual, 1e-10);
    haptics::gmres(apply, Eigen::VectorXcd::Zero(40), x, 1e-10, 100);
    EXPECT_TRUE(x.isZero());
    EXPECT_FALSE(haptics::gmres(apply, b, x, 1e-10, 3).isConverged);
}

namespace
{

haptics::ScatteredField fieldWith(const haptics::TriangleMesh& body,
                                  const haptics::TransducerArray& array)
{
    const double wavelength_m = haptics::Medium().wavelength(array.frequency_Hz);
    return {{std::make_shared<haptics::RigidBody>(
                haptics::RigidBody::divided(body, wavelength_m), wavelength_m, 2)},
            array,
            haptics::Medium(),
            2};
}

} // namespace

// Points on the axis of a ball in a field of an array; the array's own sum, apart from the product.
TEST(SceneScattering, TellsWhatABallDoesToAFocus)
{
    haptics::TransducerArray array;
    array.directivity = haptics::Directivity::POINT;
    array.positions.resize(3, 25);
    for (int row = 0; row < 5; ++row)
        for (int column = 0; column < 5; ++column)
            array.positions.col(5 * row + column) << 0.01 * (column - 2), 0.01 * (row - 2), 0.0;
    array.normals = Eigen::Vector3d::UnitZ().replicate(1, 25);
    array.board.assign(25, 0);
    haptics::Medium medium;
    const double k = base::kTwoPi / medium.wavelength(array.frequency_Hz);
    const double a = 3e-3;
    const Eigen::Vector3d centre(0.0, 0.0, 0.06);
    haptics::TriangleMesh ball = ballOf(a, 1.3e-3);
    ball.vertices.colwise() += centre;
    Eigen::Matrix3Xd points(3, 2);
    points.col(0) = centre + Eigen::Vector3d(0.0, 0.0, -5e-3);
    points.col(1) = centre + Eigen::Vector3d(8e-3, 0.0, 0.0);
    const Eigen::VectorXcf q = Eigen::VectorXcf::Ones(25);
    haptics::ScatteredField truth = fieldWith(ball, array);
    const auto figures = haptics::scatteringOf(truth, {points}, {q});
    EXPECT_LT(figures.residual, haptics::RigidBody::kResidual);
    double off2 = 0.0, worst = 0.0;
    for (int l = 0; l < 2; ++l)
    {
        Complex alone = 0.0, with = 0.0;
        for (int i = 0; i < 25; ++i)
        {
            const Eigen::Vector3d source = array.positions.col(i) - centre,
                                  point = points.col(l) - centre;
            const double r = (point - source).norm();
            const Complex one = std::polar(array.sourceAmplitude_Pa_m / r, -k * r);
            alone += one;
            with += one;
            Complex sum = 0.0;
            for (int n = 0; n < 20; ++n)
            {
                const auto bessel = [](int order, double x)
                { return std::sph_bessel(static_cast<unsigned>(order), x); };
                sum += (2.0 * n + 1.0) * slopeOf(bessel, n, k * a) / slopeOf(hankel, n, k * a) *
                       hankel(n, k * source.norm()) * hankel(n, k * point.norm()) *
                       std::legendre(static_cast<unsigned>(n),
                                     source.dot(point) / source.norm() / point.norm());
            }
            with += array.sourceAmplitude_Pa_m * Complex(0.0, k) * sum;
        }
        const double off = std::abs(with) / std::abs(alone) - 1.0;
        off2 += off * off;
        worst = std::max(worst, std::abs(off));
    }
    EXPECT_GT(worst, 0.05) << "the ball must do something";
    EXPECT_NEAR(figures.rms, std::sqrt(0.5 * off2), 0.01);
    EXPECT_NEAR(figures.worst, worst, 0.015);
}

TEST(SceneScattering, RefusesPointsAndTransducersInside)
{
    haptics::TransducerArray array = haptics::TransducerArray::singleBoard();
    const Eigen::VectorXcf q = Eigen::VectorXcf::Ones(array.size());
    haptics::TriangleMesh ball = ballOf(8e-3, 2e-3);
    const Eigen::Vector3d aside(0.0, 0.0, 0.1);
    ball.vertices.colwise() += aside;
    const auto refusal = [&](const haptics::TriangleMesh& body, const Eigen::Vector3d& point)
    {
        try
        {
            haptics::ScatteredField truth = fieldWith(body, array);
            haptics::scatteringOf(truth, {point}, {q});
        }
        catch (const base::InputError& error)
        {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_EQ(refusal(ball, {0.0, 0.0, 0.15}), "");
    EXPECT_NE(refusal(ball, aside).find("point 0 at (0.0000, 0.0000, 0.1000) m is inside"),
              std::string::npos);
    ball.vertices.colwise() += Eigen::Vector3d(array.positions.col(7)) - aside;
    EXPECT_NE(refusal(ball, {0.0, 0.0, 0.15}).find("transducer "), std::string::npos);
}
