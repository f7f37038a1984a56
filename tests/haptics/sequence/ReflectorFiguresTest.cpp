// What is told of reflectors, against fields in double precision with reflectors that are off.
#include "haptics/sequence/ReflectorFigures.h"

#include "haptics/propagation/ReferencePropagation.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <Eigen/Geometry>

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

Reflector screen()
{
    Reflector one;
    one.name = "screen";
    one.position = {0.0, 0.01, 0.25};
    one.normal = Eigen::Vector3d(0.05, 0.1, -1.0).normalized();
    one.along = one.normal.unitOrthogonal();
    one.size_m = {0.3, 0.25};
    one.accuracy_mm = 0.5;
    return one;
}

/// A field of ten points for \a solvedFor.
FieldSequence solved(const TransducerArray& solvedFor)
{
    FieldSequence sequence;
    sequence.parts = {spherePoints(10, 0.02, {0.0, 0.0, 0.15})};
    sequence.fields.resize(1);
    sequence.report = makeSolver("gauss-newton")
                          ->solve(sequence.parts[0], solvedFor, Medium(), sequence.fields[0]);
    return sequence;
}

double trueRms(const FieldSequence& sequence, const TransducerArray& array)
{
    const ControlPoints& points = sequence.parts[0];
    const Eigen::VectorXd y = (referencePropagationMatrix(points.positions, array, Medium()) *
                               sequence.fields[0].cast<std::complex<double>>())
                                  .cwiseAbs();
    const double s = y.dot(points.targets) / points.targets.squaredNorm();
    return std::sqrt((y.array() / (s * points.targets.array()) - 1.0).square().mean());
}

} // namespace

TEST(ReflectorFigures, AreThoseOfTheDriveAndOfReflectorsThatAreOff)
{
    TransducerArray array = TransducerArray::singleBoard(), free = array;
    array.reflectors = {screen()};
    const FieldSequence uncorrected = solved(free), corrected = solved(array);
    const ReflectorFigures before = reflectorFigures(uncorrected, array, Medium());
    const ReflectorFigures after = reflectorFigures(corrected, array, Medium());
    EXPECT_NEAR(before.freeRms, trueRms(uncorrected, free), 3e-4);
    EXPECT_NEAR(before.rms, trueRms(uncorrected, array), 3e-4);
    EXPECT_GT(before.rms, 0.03);
    EXPECT_GE(before.worst, before.rms);
    EXPECT_NEAR(after.rms, trueRms(corrected, array), 3e-4);
    EXPECT_LT(after.rms, 1e-3);
    EXPECT_LT(after.expectedRms, before.expectedRms);
    // The residual of a reflector that is off by its accuracy, to either side.
    for (const double side : {-1.0, 1.0})
    {
        TransducerArray truth = array;
        truth.reflectors[0].position += side * 0.5e-3 * truth.reflectors[0].normal;
        for (const auto& [figures, sequence] :
             {std::pair{after, corrected}, std::pair{before, uncorrected}})
        {
            EXPECT_GT(figures.expectedRms, trueRms(sequence, truth) / 1.5) << side;
            EXPECT_LT(figures.expectedRms, trueRms(sequence, truth) * 1.5) << side;
        }
    }
    array.reflectors[0].reflection = 0.0;
    const ReflectorFigures none = reflectorFigures(uncorrected, array, Medium());
    EXPECT_EQ(none.rms, none.freeRms);
    EXPECT_EQ(none.expectedRms, none.rms);
}

TEST(ReflectorFigures, TellHiddenTransducersAndWhatCannotBeCorrected)
{
    TransducerArray array = TransducerArray::singleBoard();
    const ControlPoints points = spherePoints(10, 0.02, {0.0, 0.0, 0.15});
    array.reflectors = {screen()};
    EXPECT_EQ(hiddenTransducers(points.positions, array, Medium()), 0);
    EXPECT_EQ(whyUncorrectable(points.positions, array, Medium()), "");
    array.reflectors[0].position[2] = 0.05; // in between
    EXPECT_EQ(hiddenTransducers(points.positions, array, Medium()), array.size());
    array.reflectors[0].reflection = 0.1;
    EXPECT_EQ(hiddenTransducers(points.positions, array, Medium()), 0);
    array.reflectors[0].accuracy_mm = 1.5;
    EXPECT_EQ(
        whyUncorrectable(points.positions, array, Medium()),
        "the accuracy of reflector 'screen' is 1.5 mm, and a correction needs 1 mm or better");
    array.reflectors[0].accuracy_mm = 0.1;
    array.reflectors[0].position[2] = 0.178;
    EXPECT_NE(whyUncorrectable(points.positions, array, Medium()).find("nearer than a wavelength"),
              std::string::npos);
    EXPECT_EQ(reflectorFigures(FieldSequence(), array, Medium()).rms, 0.0);
}
