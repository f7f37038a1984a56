#include "haptics/scattering/ScatteringSolver.h"

#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/scattering/RigidBody.h"
#include "tests/haptics/scattering/Plates.h"
#include "tests/haptics/scattering/Scattered.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using midair::test::ballOf;
using midair::test::fourUnits;
using midair::test::plateBehind;

namespace
{

// What a corrected drive does, recomputed in double; \a errors: as told, after each round.
struct Corrected
{
    haptics::SolveReport report;
    double rms = 0.0;
    std::vector<double> errors;
};

Corrected correct(std::shared_ptr<haptics::ScatteredField> truth,
                  const haptics::ControlPoints& points,
                  const haptics::TransducerArray& free,
                  const haptics::TransducerArray& rows,
                  int rounds = haptics::ScatteringSolver::kRounds,
                  bool hasOptics = true)
{
    Corrected made;
    haptics::ScatteringSolver solver(
        haptics::makeSolver("gauss-newton"),
        truth,
        [&](int, double rms) { made.errors.push_back(rms); },
        rounds,
        hasOptics);
    Eigen::VectorXcf q;
    made.report = solver.solve(points, rows, haptics::Medium(), q);
    truth->setDrive(q);
    const Eigen::VectorXcd p =
        haptics::referencePropagationMatrix(points.positions, free, haptics::Medium()) *
            q.cast<std::complex<double>>() +
        truth->scattered_Pa(points.positions);
    made.rms = midair::test::rmsError(p);
    return made;
}

std::shared_ptr<haptics::ScatteredField>
fieldWith(haptics::TriangleMesh body, const Eigen::Vector3d& at, const haptics::TransducerArray& of)
{
    body.vertices.colwise() += at;
    const double wavelength_m = haptics::Medium().wavelength(of.frequency_Hz);
    return std::make_shared<haptics::ScatteredField>(
        std::vector<std::shared_ptr<const haptics::Scatterer>>{std::make_shared<haptics::RigidBody>(
            haptics::RigidBody::divided(body, wavelength_m), wavelength_m)},
        of,
        haptics::Medium(),
        1);
}

} // namespace

// A finger: a ball of 8 mm at the points, whose rows don't know it.
TEST(ScatteringSolver, CorrectsForAFinger)
{
    const haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    const haptics::ControlPoints points = haptics::spherePoints(100, 0.03);
    const Eigen::Vector3d beside = 0.039 * points.normals.col(50);
    const auto truth = fieldWith(ballOf(8e-3, 1.4e-3), beside, array);
    const Corrected made = correct(truth, points, array, array, 3);
    ASSERT_GE(made.errors.size(), 2U);
    EXPECT_GT(made.errors.front(), 0.02) << "the finger is felt";
    EXPECT_LE(made.rms, 0.002);
    EXPECT_NEAR(made.report.rms, made.rms, 1e-4);
    EXPECT_LE(made.rms, made.errors.front());
}

// Images are in the rows; what the screen's edges scatter besides is corrected.
TEST(ScatteringSolver, CorrectsForWhatImagesOfAPlateHaveNot)
{
    struct Case
    {
        double side_m, behind_m, most;
    };
    const Eigen::Vector3d centre(0.0, 0.0, 0.15);
    const haptics::ControlPoints points = haptics::spherePoints(100, 0.03, centre);
    const haptics::TransducerArray free = fourUnits();
    for (const Case& one : {Case{0.2, 0.1, 0.01}, Case{0.1, 0.04, 0.03}})
    {
        haptics::TransducerArray array = free;
        array.reflectors = {plateBehind(centre, one.side_m, one.behind_m)};
        const auto truth = std::make_shared<haptics::ScatteredField>(
            midair::test::truthOf(array.reflectors.front(), free, 1));
        const Corrected made = correct(truth, points, free, array);
        EXPECT_LE(made.rms, one.most) << one.side_m;
        EXPECT_NEAR(made.report.rms, made.rms, 1e-4) << one.side_m;
        EXPECT_LT(3.0 * made.rms, made.errors.front()) << one.side_m;
    }
}

// A ball of more than two wavelengths behind the points, which reflects to them.
TEST(ScatteringSolver, OpticsInTheRowsKnowMostOfWhatALargeBodyScatters)
{
    const haptics::TransducerArray array = haptics::TransducerArray::singleBoard();
    const haptics::ControlPoints points = haptics::spherePoints(12, 0.02, {0.0, 0.0, 0.14});
    const auto truth = fieldWith(ballOf(10e-3, 1.4e-3), {0.0, 0.005, 0.172}, array);
    const Corrected free = correct(truth, points, array, array, 0, false);
    const Corrected made = correct(truth, points, array, array, 0);
    EXPECT_GT(free.rms, 0.1) << "the ball is felt";
    EXPECT_LT(made.rms, 0.5 * free.rms);
    const Corrected corrected = correct(truth, points, array, array);
    EXPECT_LE(corrected.rms, 0.003);
    const auto rows = truth->optics_Pa(points.positions);
    ASSERT_TRUE(rows);
    Eigen::VectorXcf q = Eigen::VectorXcf::Ones(array.size());
    truth->setDrive(q);
    const Eigen::VectorXcd scattered = truth->scattered_Pa(points.positions);
    EXPECT_LT(((*rows * q).cast<std::complex<double>>() - scattered).norm(),
              0.5 * scattered.norm());
}

TEST(ScatteringSolver, KeepsTheBestAndRefusesPointsInside)
{
    const haptics::TransducerArray array = haptics::TransducerArray::singleBoard();
    const haptics::ControlPoints points = haptics::spherePoints(12, 0.02, {0.0, 0.0, 0.15});
    // Too many points, too near for what free rows can correct: whatever comes, nothing worse.
    const auto behind = fieldWith(ballOf(12e-3, 1.4e-3), {0.0, 0.0, 0.184}, array);
    const Corrected made = correct(behind, points, array, array, 6);
    for (const double error : made.errors)
        EXPECT_LE(made.rms, error + 1e-4);
    haptics::ScatteringSolver solver(
        haptics::makeSolver("gauss-newton"),
        fieldWith(ballOf(8e-3, 1.4e-3), points.positions.col(3), array));
    Eigen::VectorXcf q;
    const haptics::SolveReport report = solver.solve(points, array, haptics::Medium(), q);
    EXPECT_EQ(report.stop, haptics::StopReason::REFUSED);
    EXPECT_EQ(report.message.find("point 3 at "), 0U) << report.message;
    EXPECT_EQ(q.size(), array.size());
    EXPECT_TRUE(q.isZero());
    const haptics::SolveReport none =
        solver.solve(haptics::ControlPoints(), array, haptics::Medium(), q);
    EXPECT_EQ(none.stop, haptics::StopReason::NOTHING_TO_DO);
    EXPECT_TRUE(q.isZero());
}
