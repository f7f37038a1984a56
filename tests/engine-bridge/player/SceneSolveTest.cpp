#include "engine-bridge/player/SceneSolve.h"

#include "engine-bridge/solving/ArrayLevels.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <complex>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

// As it would play: corrected if that gains, else told; and measured with it in either case.
TEST(SceneSolve, KnowsTheReflectorsOfTheScene)
{
    SceneSolve scene;
    haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    keepToSignal(array.drive);
    scene.array = std::make_shared<const haptics::TransducerArray>(array);
    scene.snapshot = squareSnapshot();
    base::MessageLog messages;
    const SolvedScene free = solveScene(scene, messages);
    haptics::FlatFace plate;
    plate.rectangle.name = "plate";
    plate.rectangle.position = {0.0, -0.05, 0.0};
    plate.rectangle.normal = Eigen::Vector3d::UnitY();
    plate.rectangle.size_m = {0.2, 0.15};
    for (const double accuracy_mm : {0.2, 5.0})
    {
        plate.rectangle.accuracy_mm = accuracy_mm;
        scene.snapshot.reflectors = {plate};
        const SolvedScene solved = solveScene(scene, messages);
        ASSERT_EQ(solved.array->reflectors.size(), 1u);
        const Eigen::VectorXcf& q = solved.fields.sequence.fields.at(0);
        EXPECT_EQ(q == free.fields.sequence.fields.at(0), accuracy_mm > 1.0);
        const Eigen::VectorXd y =
            (haptics::referencePropagationMatrix(
                 solved.fields.points.positions, *solved.array, solved.medium) *
             q.cast<std::complex<double>>())
                .cwiseAbs();
        EXPECT_LT((y - solved.fields.achieved_Pa).norm(), 1e-4 * y.norm());
        EXPECT_EQ(solved.fields.sequence.report.rms > 0.02, accuracy_mm > 1.0);
    }
    ASSERT_EQ(messages.all().size(), 1u);
    EXPECT_NE(messages.all()[0].find("reflector 'plate': its accuracy is 5 mm"), std::string::npos);
}
