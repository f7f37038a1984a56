#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/solvers/HologramSolver.h"

#include <string>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

std::string fileWith(const std::string& dead)
{
    return R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10.1, "directivity": "point",
               "boards": [{"position_m": [0, 0, 0], "normal": [0, 0, 1],
                           "columns": 3, "rows": 2, "pitch_m": 0.01}],
               "dead": )" +
           dead + "}";
}

std::string refusal(const std::string& dead)
{
    try
    {
        TransducerArray::fromJson(fileWith(dead), "a.json");
    }
    catch (const midair::base::InputError& error)
    {
        return error.what();
    }
    return {};
}

} // namespace

TEST(DeadTransducers, AFileNamesThemByTheirNumbers)
{
    const TransducerArray array = TransducerArray::fromJson(fileWith("[4, 1]"), "a.json");
    EXPECT_EQ(array.dead, (std::vector<int>{1, 4}));
    ASSERT_EQ(array.gain.size(), 6);
    for (int i = 0; i < 6; ++i)
        EXPECT_EQ(array.gain[i], i == 1 || i == 4 ? 0.0 : 1.0);
    EXPECT_TRUE(array.isValid());
    const TransducerArray again = TransducerArray::fromJson(array.toJson(), "b.json");
    EXPECT_EQ(again.dead, array.dead);
    EXPECT_TRUE(again.gain == array.gain);
}

TEST(DeadTransducers, ImpossibleNumbersAreRefused)
{
    EXPECT_EQ(refusal("[6]"),
              "a.json: dead[0] is 6; it must be the number of a transducer, 0 to 5");
    EXPECT_EQ(refusal("[-1]"),
              "a.json: dead[0] is -1; it must be the number of a transducer, 0 to 5");
    EXPECT_EQ(refusal("[2, 2]"), "a.json: dead[1] is 2; it must be there once");
    EXPECT_EQ(refusal("7"),
              "a.json: dead is 7; it must be a list of numbers of transducers, from 0");
    EXPECT_EQ(refusal("[]"), "");
}

TEST(DeadTransducers, AListThatDoesNotFitTheGainsIsNotValid)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.dead = {3};
    std::string error;
    EXPECT_FALSE(array.isValid(&error));
    EXPECT_EQ(error, "the dead transducers are not ascending numbers of transducers of gain 0");
    array.setDead({3, 1});
    EXPECT_TRUE(array.isValid(&error)) << error;
    EXPECT_EQ(array.dead, (std::vector<int>{1, 3}));
}

// Every solver knows: the pressures are right though the dead ones do nothing.
TEST(DeadTransducers, FieldsAreSolvedForWithoutThem)
{
    TransducerArray array = TransducerArray::singleBoard();
    std::vector<int> dead;
    for (int i = 0; i < array.size(); i += 3)
        dead.push_back(i);
    array.setDead(dead);
    ControlPoints points;
    points.positions.resize(3, 4);
    points.positions << -0.02, 0.02, 0.0, 0.0, 0.0, 0.0, -0.02, 0.02, 0.15, 0.15, 0.15, 0.16;
    points.normals = Eigen::Matrix3Xd::Zero(3, 4);
    points.targets = Eigen::VectorXd::Ones(4);
    const Medium medium;
    const Eigen::MatrixXcd G = referencePropagationMatrix(points.positions, array, medium);
    for (const std::string& name : solverNames())
    {
        Eigen::VectorXcf q;
        const SolveReport report = makeSolver(name)->solve(points, array, medium, q);
        ASSERT_TRUE(q.allFinite()) << name;
        for (const int i : dead)
            q[i] = 0.0F;
        const Eigen::VectorXd p = (G * q.cast<std::complex<double>>()).cwiseAbs();
        EXPECT_NEAR(p.mean() / report.level_Pa, 1.0, 0.02) << name;
        EXPECT_GT(p.minCoeff(), 0.8 * p.maxCoeff()) << name;
    }
}
