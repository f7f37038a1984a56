#include "haptics/base/InputError.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/sequence/FieldOrder.h"
#include "haptics/sequence/Modulator.h"
#include "haptics/sequence/SequenceComposer.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>

#include <gtest/gtest.h>

namespace midair::haptics
{
namespace
{

TimeMultiplexer matched()
{
    return TimeMultiplexer([] { return makeSolver("gauss-newton", SolverOptions()); });
}

// |p| at each point by the formula in double precision, apart from everything that solves.
Eigen::VectorXd
achieved(const ControlPoints& points, const TransducerArray& array, const Eigen::VectorXcf& q)
{
    return (referencePropagationMatrix(points.positions, array, Medium()) *
            q.cast<std::complex<double>>())
        .cwiseAbs();
}

TEST(TimeMultiplexer, UnequalTargetsKeepTheirRatiosAcrossFields)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    // Two strong points in one field, six weaker ones in the other: each as loud as it could would
    // turn that round.
    std::vector<ControlPoints> parts{spherePoints(2, 0.02), spherePoints(6, 0.03)};
    parts[1].targets *= 0.5;
    TimeMultiplexer fields = matched();
    std::vector<Eigen::VectorXcf> q;
    const SolveReport report = fields.solve(parts, array, Medium(), q);
    ASSERT_EQ(q.size(), 2u);
    const double first = achieved(parts[0], array, q[0]).mean();
    const double second = achieved(parts[1], array, q[1]).mean();
    EXPECT_NEAR(second / first, 0.5, 0.005); // a level of duty is 0.3 % and less
    EXPECT_EQ(report.points, 8);
    EXPECT_NEAR(report.level_Pa, first, 0.005 * first);
    // One of the two plays at full amplitude.
    EXPECT_NEAR(std::max(q[0].cwiseAbs().maxCoeff(), q[1].cwiseAbs().maxCoeff()), 1.0f, 1e-6f);
}

TEST(TimeMultiplexer, AnObjectThatIsModulatedLeavesTheOtherSteady)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ControlPoints points = spherePoints(12, 0.03);
    Eigen::VectorXd depth = Eigen::VectorXd::Zero(12);
    depth.tail(6).setOnes();
    const std::vector<ControlPoints> steps = modulationSteps(points, depth, 8);
    ASSERT_EQ(steps.size(), 8u);
    EXPECT_EQ(steps[4].size(), 6) << "half of them are silent in the middle of the period";
    TimeMultiplexer fields = matched();
    std::vector<Eigen::VectorXcf> q;
    fields.solve(steps, array, Medium(), q);
    const double level = achieved(points, array, q[0]).mean();
    for (int j = 0; j < 8; ++j)
    {
        const Eigen::VectorXd p =
            achieved(steps[static_cast<std::size_t>(j)], array, q[static_cast<std::size_t>(j)]);
        for (int l = 0; l < 6; ++l)
            EXPECT_NEAR(p[l], level, 0.01 * level) << "step " << j << ", point " << l;
        // The pressure on the skin goes with the square: 1 - (1 - cos)/2.
        const double wanted = 0.5 * (1.0 + std::cos(2.0 * M_PI * j / 8));
        for (int l = 6; l < p.size(); ++l)
            EXPECT_NEAR(std::pow(p[l] / level, 2), wanted, 0.02) << "step " << j;
    }
}

TEST(TimeMultiplexer, AbsoluteTargetsAreNotScaled)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    std::vector<ControlPoints> parts{spherePoints(3, 0.02), spherePoints(6, 0.03)};
    parts[0].targets *= 1000.0;
    parts[1].targets *= 500.0;
    parts[0].absolute = parts[1].absolute = true;
    TimeMultiplexer fields = matched();
    std::vector<Eigen::VectorXcf> q;
    fields.solve(parts, array, Medium(), q);
    EXPECT_NEAR(achieved(parts[0], array, q[0]).mean(), 1000.0, 5.0);
    EXPECT_NEAR(achieved(parts[1], array, q[1]).mean(), 500.0, 5.0);
}

TEST(TimeMultiplexer, APartWithoutPointsIsSilent)
{
    std::vector<ControlPoints> parts{spherePoints(4, 0.02), spherePoints(0, 0.02)};
    TimeMultiplexer fields = matched();
    std::vector<Eigen::VectorXcf> q;
    const SolveReport report = fields.solve(parts, TransducerArray::singleBoard(), Medium(), q);
    EXPECT_EQ(q[1].cwiseAbs().maxCoeff(), 0.0f);
    EXPECT_NE(report.stop, StopReason::NOTHING_TO_DO);
    EXPECT_GT(q[0].cwiseAbs().minCoeff(), 0.99f);
    EXPECT_THROW(fields.solve({}, TransducerArray::singleBoard(), Medium(), q), base::InputError);
}

TEST(TimeMultiplexer, ARefusalIsTold)
{
    std::vector<ControlPoints> parts{spherePoints(4, 0.02, {0, 0, 0.1}),
                                     spherePoints(4, 0.02, {0, 0, 0.1})};
    parts[1].positions(0, 2) = std::nan("");
    TimeMultiplexer fields = matched();
    std::vector<Eigen::VectorXcf> q;
    const SolveReport report = fields.solve(parts, TransducerArray::singleBoard(), Medium(), q);
    EXPECT_EQ(report.stop, StopReason::REFUSED);
    EXPECT_NE(report.message.find("control point 2"), std::string::npos) << report.message;
}

TEST(TimeMultiplexer, WithoutPointsAreSilent)
{
    const TransducerArray array = TransducerArray::singleBoard();
    TimeMultiplexer fields = matched();
    std::vector<Eigen::VectorXcf> q;
    const std::vector<ControlPoints> nothing = subsetsInTurn(ControlPoints(), 2);
    ASSERT_EQ(nothing.size(), 1u);
    SolveReport report = fields.solve({nothing[0], nothing[0]}, array, Medium(), q);
    EXPECT_EQ(report.stop, StopReason::NOTHING_TO_DO);
    EXPECT_EQ(report.message, "there are no control points");
    EXPECT_EQ(report.points, 0);
    EXPECT_EQ(report.rms, 0.0);
    for (const Eigen::VectorXcf& field : q)
        EXPECT_TRUE(field.isZero(0.0f));
    // One that has none is not worth a word beside one that has some.
    report = fields.solve({nothing[0], spherePoints(4, 0.01, {0, 0, 0.1})}, array, Medium(), q);
    EXPECT_NE(report.stop, StopReason::NOTHING_TO_DO);
    EXPECT_EQ(report.message, "");
    EXPECT_TRUE(q[0].isZero(0.0f));
    EXPECT_FALSE(q[1].isZero(0.0f));
}

TEST(TimeMultiplexer, PointsWithoutNormalsAreAppendedWithZeros)
{
    ControlPoints bare;
    bare.positions = Eigen::Matrix3Xd::Ones(3, 40);
    bare.targets = Eigen::VectorXd::Ones(40);
    ControlPoints whole = spherePoints(40, 0.01);
    whole.object.assign(40, 7);

    ControlPoints all = bare;
    append(all, whole);
    ASSERT_EQ(all.normals.cols(), 80);
    EXPECT_TRUE(all.normals.leftCols(40).isZero(0.0));
    EXPECT_EQ(all.normals.rightCols(40), whole.normals);
    EXPECT_TRUE(all.object.empty()) << "of half of them it isn't known";

    all = whole;
    append(all, bare);
    ASSERT_EQ(all.normals.cols(), 80);
    EXPECT_EQ(all.normals.leftCols(40), whole.normals);
    EXPECT_TRUE(all.normals.rightCols(40).isZero(0.0));
    EXPECT_TRUE(all.object.empty());

    all = ControlPoints();
    append(all, whole);
    append(all, ControlPoints());
    append(all, whole);
    EXPECT_EQ(all.object.size(), 80u);
    EXPECT_EQ(all.positions.rightCols(40), whole.positions);
}

TEST(ModulationSteps, SayWhatIsWrong)
{
    const ControlPoints points = spherePoints(3, 0.02);
    EXPECT_THROW(modulationSteps(points, Eigen::VectorXd::Ones(3), 1), base::InputError);
    EXPECT_THROW(modulationSteps(points, Eigen::VectorXd::Ones(2), 8), base::InputError);
    EXPECT_THROW(modulationSteps(points, Eigen::VectorXd::Constant(3, 1.5), 8), base::InputError);
}

TEST(FieldOrder, ScalesToTheNearestLevel)
{
    DriveResolution drive;
    drive.amplitudeLevels = {0.0f, 0.4f, 0.8f, 1.0f};
    Eigen::VectorXcf q(3);
    q << std::polar(1.0f, 0.3f), std::polar(1.0f, -2.0f), 0.0f;
    scaleField(q, 0.75f, drive);
    EXPECT_NEAR(std::abs(q[0]), 0.8f, 1e-6f);
    EXPECT_NEAR(std::arg(q[1]), -2.0f, 1e-6f);
    EXPECT_EQ(q[2], std::complex<float>(0.0f));
}

TEST(FieldOrder, AlignsWithinHalfALevel)
{
    DriveResolution drive;
    drive.phaseLevels = 256;
    const Eigen::VectorXcf last = Eigen::VectorXcf::Constant(5, std::polar(1.0f, 1.0f));
    Eigen::VectorXcf q = Eigen::VectorXcf::Constant(5, std::polar(1.0f, -2.0f));
    alignField(q, last, drive);
    EXPECT_NEAR(std::arg(q[0] * std::conj(last[0])), 0.0f, M_PI / 256);
    Eigen::VectorXcf other(4);
    other.setOnes();
    alignField(other, last, drive); // nothing to align with
    EXPECT_EQ(other[0], std::complex<float>(1.0f));
}

} // namespace
} // namespace midair::haptics
