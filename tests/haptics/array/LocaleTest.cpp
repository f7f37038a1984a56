// A decimal comma of the program's locale changes no number, neither read nor written.
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/sequence/Modulator.h"
#include "haptics/solvers/HologramSolver.h"
#include "haptics/surface/Outline.h"
#include "haptics/surface/SurfaceSampler.h"
#include "tests/CommaLocale.h"

#include <gtest/gtest.h>

using namespace midair::haptics;

TEST(HapticsLocale, ChangesNoNumberOfAnArrayFile)
{
    const TransducerArray before = TransducerArray::load("ultraino64");
    const std::string json = before.toJson();
    const CommaLocale comma;
    if (!comma.isSet()) GTEST_SKIP();
    EXPECT_EQ(before.toJson(), json);
    const TransducerArray array = TransducerArray::fromJson(json, "json");
    EXPECT_TRUE(array.positions == before.positions);
    EXPECT_EQ(TransducerArray::load("ultraino64").sourceAmplitude_Pa_m, 10.1);
}

TEST(HapticsLocale, ChangesNoNumberOfAMessage)
{
    const CommaLocale comma;
    if (!comma.isSet()) GTEST_SKIP();
    std::string error;
    ModulatorOptions modulation;
    modulation.amplitudeRate_Hz = 1000.5;
    EXPECT_FALSE(modulation.isValid(&error));
    EXPECT_EQ(error, "amplitudeRate_Hz is 1000.5; it must be within 0 .. 500");
    SolverOptions solver;
    solver.rmsTolerance = -0.5;
    EXPECT_FALSE(solver.isValid(&error));
    EXPECT_EQ(error, "solver option rmsTolerance is -0.5; it must be within 0 .. 1");
    Medium medium;
    medium.temperature_C = -300.5;
    EXPECT_FALSE(medium.isValid(&error));
    EXPECT_NE(error.find("is -300.5; it must be within"), std::string::npos) << error;
    TransducerArray array;
    array.positions = array.normals = Eigen::Vector3d::UnitZ().replicate(1, 12345);
    EXPECT_FALSE(array.isValid(&error));
    EXPECT_EQ(error,
              "12345 positions, 12345 normals, 0 board indices; there must be as many of each");
}
