// What must not matter does not matter: for every method by name.
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <Eigen/Geometry>

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

// Levels of phase would turn a difference in the last bit into one of a level.
TransducerArray arrayWithoutLevels()
{
    TransducerArray array = TransducerArray::octagonalPrism();
    array.drive = DriveResolution{0, {}};
    return array;
}

ControlPoints unequalPoints(int n)
{
    ControlPoints points = spherePoints(n, 0.03, {0.005, -0.01, 0.008});
    points.targets = Eigen::VectorXd::LinSpaced(n, 0.6, 1.0);
    return points;
}

struct Field
{
    SolveReport report;
    Eigen::VectorXcf q;
    Eigen::VectorXd y; // |G q|, in double
};

Field fieldOf(const std::string& name, const ControlPoints& points, const TransducerArray& array)
{
    Field field;
    field.report = makeSolver(name)->solve(points, array, Medium{}, field.q);
    field.y = (referencePropagationMatrix(points.positions, array, Medium{}) *
               field.q.cast<std::complex<double>>())
                  .cwiseAbs();
    return field;
}

// Greedy chooses the best of 256 levels for each transducer in turn: where two are equal but for
// rounding, the last bit decides, and everything after it goes another way. Its fields agree in how
// good they are, not point by point.
bool isDecidedByTheLastBit(const std::string& name)
{
    return name == "greedy";
}

// SDP-BCD visits the points in an order that is drawn by index, and two of Gauss-Newton's cold
// starts have phases that are: the same draw meets other points when they are permuted.
bool dependsOnOrder(const std::string& name)
{
    return isDecidedByTheLastBit(name) || name == "sdp-bcd" || name == "gauss-newton";
}

void expectSameField(const Field& field, const Field& expected, const Eigen::VectorXd& y)
{
    // Float pressures are good to 1e-5; rounds enlarge that while they settle.
    EXPECT_NEAR(field.report.rms, expected.report.rms, 1e-3);
    EXPECT_NEAR(field.report.loudness, expected.report.loudness, 1e-3);
    EXPECT_LT((y - expected.y).cwiseAbs().maxCoeff(), 3e-3 * expected.y.mean());
}

void expectAsGood(const Field& field, const Field& expected)
{
    EXPECT_LT(field.report.rms, 3.0 * expected.report.rms + 1e-3);
    EXPECT_GT(field.report.rms, expected.report.rms / 3.0 - 1e-3);
    EXPECT_NEAR(field.report.loudness, expected.report.loudness, 0.05);
}

} // namespace

TEST(EverySolver, IsTheSameWhereverSceneAndArrayAreTurnedTo)
{
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(1.1, Eigen::Vector3d(0.3, -0.8, 0.5).normalized()).toRotationMatrix();
    const TransducerArray array = arrayWithoutLevels();
    TransducerArray turnedArray = array;
    turnedArray.positions = turn * array.positions;
    turnedArray.normals = turn * array.normals;
    const ControlPoints points = unequalPoints(10);
    ControlPoints turnedPoints = points;
    turnedPoints.positions = turn * points.positions;
    turnedPoints.normals = turn * points.normals;
    for (const std::string& name : solverNames())
    {
        SCOPED_TRACE(name);
        const Field field = fieldOf(name, points, array);
        const Field turned = fieldOf(name, turnedPoints, turnedArray);
        if (isDecidedByTheLastBit(name))
            expectAsGood(turned, field);
        else
            expectSameField(turned, field, turned.y);
    }
}

TEST(EverySolver, TakesRelativeTargetsInAnyUnit)
{
    // A power of two changes no digits: the activations are the same to the bit, and so is the
    // level, which is the array's.
    const TransducerArray array = TransducerArray::octagonalPrism();
    const ControlPoints points = unequalPoints(10);
    for (const double factor : {0.00048828125, 4096.0})
    {
        ControlPoints scaled = points;
        scaled.targets *= factor;
        for (const std::string& name : solverNames())
        {
            SCOPED_TRACE(name);
            const Field field = fieldOf(name, points, array);
            const Field other = fieldOf(name, scaled, array);
            EXPECT_EQ(other.q, field.q);
            EXPECT_EQ(other.report.rms, field.report.rms);
            EXPECT_EQ(other.report.level_Pa, field.report.level_Pa);
        }
    }
}

TEST(EverySolver, PlaysAbsoluteTargetsInProportion)
{
    // Quiet enough for the array: twice the targets, twice the pressures, by the amplitude of all.
    const TransducerArray array = arrayWithoutLevels();
    ControlPoints points = unequalPoints(10);
    points.targets *= 300.0;
    points.absolute = true;
    ControlPoints louder = points;
    louder.targets *= 2.0;
    SolverOptions options;
    for (const std::string& name : solverNames())
    {
        SCOPED_TRACE(name);
        Eigen::VectorXcf q, louderQ;
        const SolveReport report = makeSolver(name, options)->solve(points, array, Medium{}, q);
        const SolveReport other =
            makeSolver(name, options)->solve(louder, array, Medium{}, louderQ);
        EXPECT_NEAR(report.level_Pa, 300.0, 3.0); // the method's own error moves the level a little
        EXPECT_NEAR(other.level_Pa / report.level_Pa, 2.0, 1e-3);
        EXPECT_LT((louderQ - 2.0f * q).norm(), 1e-3f * louderQ.norm());
    }
}

TEST(EverySolver, IsTheSameInWhateverOrderThePointsCome)
{
    const TransducerArray array = arrayWithoutLevels();
    const ControlPoints points = unequalPoints(10);
    ControlPoints backwards = points;
    backwards.positions = points.positions.rowwise().reverse().eval();
    backwards.normals = points.normals.rowwise().reverse().eval();
    backwards.targets = points.targets.reverse().eval();
    for (const std::string& name : solverNames())
    {
        SCOPED_TRACE(name);
        const Field field = fieldOf(name, points, array);
        const Field other = fieldOf(name, backwards, array);
        if (dependsOnOrder(name))
            expectAsGood(other, field);
        else
            expectSameField(other, field, other.y.reverse());
    }
}

TEST(EverySolver, MakesUpForTheTransducersPhaseOffsets)
{
    // Offsets of the transducers' phases are made up for: the field is the same, the drive turned
    // back by them.
    const TransducerArray array = arrayWithoutLevels();
    TransducerArray offset = array;
    offset.phaseOffset_rad = Eigen::VectorXd::LinSpaced(array.size(), 0.0, 40.0);
    const ControlPoints points = unequalPoints(10);
    for (const std::string& name : solverNames())
    {
        SCOPED_TRACE(name);
        const Field field = fieldOf(name, points, array);
        const Field other = fieldOf(name, points, offset);
        if (isDecidedByTheLastBit(name))
            expectAsGood(other, field);
        else
            expectSameField(other, field, other.y);
    }
}
