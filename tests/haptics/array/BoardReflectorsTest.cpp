// Boards of an array that reflect the sound of the others: read from files, and against mirrored
// arrays in double precision.
#include "haptics/array/BoardReflectors.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/propagation/Reflections.h"
#include "haptics/sequence/ReflectorFigures.h"
#include "haptics/sequence/SequenceComposer.h"
#include "tests/haptics/solvers/ScenePoints.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <string>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

/// The file of \a array with more \a keys.
std::string fileWith(const TransducerArray& array, const std::string& keys)
{
    std::string json = array.toJson();
    return json.insert(json.find('{') + 1, keys + ",");
}

std::string boardMessage(const TransducerArray& array, const std::string& keys)
{
    try
    {
        TransducerArray::fromJson(fileWith(array, keys), "a.json");
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return "no error";
}

/// Two boards of 8 x 8, face to face, 0.2 m apart.
TransducerArray desk()
{
    return TransducerArray::fromJson(R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10.1,
        "directivity": "t4010a1-table", "boards": [
        {"position_m": [0, -0.1, 0], "normal": [0, 1, 0], "columns": 8, "rows": 8, "pitch_m": 0.0105},
        {"position_m": [0, 0.1, 0], "normal": [0, -1, 0], "columns": 8, "rows": 8, "pitch_m": 0.0105}
        ]})",
                                     "desk.json");
}

Eigen::Matrix3Xd somePlaces(int count, double within_m)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-within_m, within_m);
    return Eigen::Matrix3Xd::NullaryExpr(3, count, [&] { return uniform(random); });
}

TransducerArray octagonWith(double accuracy_mm)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    array.reflectors = boardReflectors(array, 1.0, 0.0, accuracy_mm);
    return array;
}

ReflectorFigures figuresOf(const TransducerArray& solvedFor, const TransducerArray& reality)
{
    const ControlPoints points = spherePoints(100, 0.03);
    base::MessageLog messages;
    const FieldSequence held =
        SequenceComposer({}, messages).compose(0, points, {}, solvedFor, Medium());
    return reflectorFigures(held, reality, Medium());
}

} // namespace

TEST(BoardReflectors, EachTransducerOfTheOctagonStandsOnOneOfEight)
{
    const TransducerArray array = octagonWith(2.0);
    ASSERT_EQ(array.reflectors.size(), 8U);
    std::string error;
    EXPECT_TRUE(array.isValid(&error)) << error;
    for (int i = 0; i < array.size(); ++i)
    {
        const Eigen::Vector3d place = array.positions.col(i);
        const Eigen::Vector3d ahead = place + 0.01 * array.normals.col(i);
        int carrying = 0;
        for (const Reflector& one : array.reflectors)
        {
            if (!one.carries(place))
            {
                EXPECT_TRUE(isReflected(one, place, Eigen::Vector3d::Zero())) << i;
                continue;
            }
            ++carrying;
            EXPECT_LT(one.distanceTo(place), 1e-3);
            EXPECT_FALSE(isReflected(one, place, ahead) || isShaded(one, place, ahead)) << i;
            EXPECT_FALSE(isReflected(one, place, -ahead) || isShaded(one, place, -ahead)) << i;
        }
        EXPECT_EQ(carrying, 1) << i;
    }
}

TEST(BoardReflectors, AreTheWallsOfTheOctagon)
{
    // Two boards a wall, one above the other.
    for (const Reflector& one : octagonWith(2.0).reflectors)
    {
        EXPECT_NEAR(one.normal.y(), 0.0, 1e-9) << "the axis is y";
        EXPECT_NEAR(one.normal.dot(one.position.normalized()), -1.0, 1e-6) << "it faces the axis";
        EXPECT_GT(one.size_m.maxCoeff(), 1.5 * one.size_m.minCoeff());
    }
}

// Without ends: the sound of each board, and of its mirror image in the other.
TEST(BoardReflectors, FaceToFaceAreMirroredArrays)
{
    TransducerArray array = desk();
    const Medium medium;
    const Eigen::Matrix3Xd points = somePlaces(20, 0.04);
    TransducerArray free = array, mirrored = array;
    for (int i = 0; i < array.size(); ++i)
    {
        const double wall_m = i < 64 ? 0.1 : -0.1; // that of the other board
        mirrored.positions(1, i) = 2.0 * wall_m - array.positions(1, i);
        mirrored.normals(1, i) = -array.normals(1, i);
    }
    const Eigen::MatrixXcd expected =
        referencePropagationMatrix(points, free, medium) +
        std::polar(0.9, 0.3) * referencePropagationMatrix(points, mirrored, medium);
    array.reflectors = boardReflectors(array, 0.9, 0.3, 0.5);
    ASSERT_EQ(array.reflectors.size(), 2U);
    for (Reflector& one : array.reflectors)
        one.size_m.setConstant(Reflector::kEndless);
    const Eigen::MatrixXcd G = referencePropagationMatrix(points, array, medium);
    EXPECT_LT((G - expected).cwiseAbs().maxCoeff(), 1e-10 * expected.cwiseAbs().maxCoeff());
}

TEST(BoardReflectors, RowsOfTheSolverAgreeWithTheReference)
{
    for (TransducerArray array : {desk(), TransducerArray::octagonalPrism()})
    {
        array.reflectors = boardReflectors(array, 0.8, 0.5, 2.0);
        const Eigen::Matrix3Xd points = somePlaces(12, 0.05);
        PropagationMatrix matrix;
        matrix.bind(array, Medium());
        matrix.build(points);
        const Eigen::MatrixXcd G = referencePropagationMatrix(points, array, Medium());
        const double usual = G.cwiseAbs().mean();
        double worst = 0.0;
        for (int l = 0; l < points.cols(); ++l)
            for (std::size_t lane = 0; lane < matrix.order().size(); ++lane)
                if (!matrix.isFiller(static_cast<int>(lane)))
                    worst = std::max(
                        worst,
                        std::abs(std::complex<double>(matrix.at(l, static_cast<int>(lane))) -
                                 G(l, matrix.order()[lane])));
        // Each of seven images adds up to 1e-4 of itself (kernels::sharesTurned()).
        EXPECT_LT(worst, 2e-3 * usual) << array.size();
    }
}

// A study of the same walls in double found 4 to 5 % of rms with full reflection.
TEST(BoardReflectors, AreToldAsAnErrorAndCanBeCorrected)
{
    const TransducerArray free = TransducerArray::octagonalPrism();
    const TransducerArray boards = octagonWith(0.2);
    const ReflectorFigures told = figuresOf(free, boards);
    EXPECT_LT(told.freeRms, 2e-3);
    EXPECT_GT(told.rms, 0.02);
    EXPECT_LT(told.rms, 0.08);
    const ReflectorFigures corrected = figuresOf(boards, boards);
    EXPECT_LT(corrected.rms, 2e-3);
    EXPECT_GT(corrected.expectedRms, corrected.rms);
}

TEST(BoardReflectors, AreReadFromTheFilesOfArrays)
{
    const TransducerArray read = TransducerArray::fromJson(
        fileWith(desk(),
                 R"("boardReflection": 0.7, "boardReflectionPhase_rad": -0.2,
                    "boardAccuracy_mm": 0.5)"),
        "a.json");
    EXPECT_EQ(read.reflectors, boardReflectors(desk(), 0.7, -0.2, 0.5));
    EXPECT_EQ(read.reflectors.front().called(0), "reflector 'board plane 0'");
    EXPECT_NEAR(read.reflectors.front().size_m[0], 8 * 0.0105, 1e-12);
    EXPECT_EQ(TransducerArray::fromJson(read.toJson(), "b.json").reflectors, read.reflectors);
    // Told, not corrected, as long as nobody measured where the boards reflect.
    const TransducerArray rough =
        TransducerArray::fromJson(fileWith(desk(), R"("boardReflection": 1)"), "a.json");
    EXPECT_GT(rough.reflectors.front().accuracy_mm, kMostCorrectedAccuracy_mm);
    EXPECT_EQ(whyUncorrectable(somePlaces(5, 0.02), rough, Medium()), "");
    EXPECT_TRUE(TransducerArray::fromJson(fileWith(desk(), R"("boardReflection": 0)"), "a.json")
                    .reflectors.empty());
    // Beside eight others.
    TransducerArray full = desk();
    Reflector other;
    other.position.z() = -0.4;
    other.accuracy_mm = 0.2;
    full.reflectors.assign(kMostReflectors, other);
    EXPECT_EQ(TransducerArray::fromJson(fileWith(full, R"("boardReflection": 1)"), "a.json")
                  .reflectors.size(),
              10U);
}

TEST(BoardReflectors, WhatIsWrongIsNamed)
{
    const auto refuses = [](const std::string& keys, const std::string& part)
    {
        const std::string message = boardMessage(desk(), keys);
        EXPECT_EQ(message.find("a.json: "), 0U) << message;
        EXPECT_NE(message.find(part), std::string::npos) << message;
    };
    refuses(R"("boardReflection": 1.2)", "boardReflection is 1.2; it must be the amplitude");
    refuses(R"("boardReflection": "much")", "boardReflection is \"much\"");
    refuses(R"("boardReflection": 1, "boardAccuracy_mm": 4)", "boardAccuracy_mm is 4");
    refuses(R"("boardReflection": 1, "boardReflectionPhase_rad": true)",
            "boardReflectionPhase_rad is true");
    refuses(R"("boardAccuracy_mm": 1)", "has 'boardAccuracy_mm' but no 'boardReflection'");
    TransducerArray bent = desk();
    bent.positions(1, 5) += 0.003;
    EXPECT_NE(boardMessage(bent, R"("boardReflection": 1)")
                  .find("boardReflection can't be used: board 0 is not flat: transducer"),
              std::string::npos)
        << boardMessage(bent, R"("boardReflection": 1)");
    std::string boards;
    for (int k = 0; k < 9; ++k)
        boards += std::string(k > 0 ? "," : "") + R"({"position_m": [0, 0, )" +
                  std::to_string(0.01 * k) +
                  R"(], "normal": [0, 0, 1], "columns": 2, "rows": 2, "pitch_m": 0.01})";
    try
    {
        TransducerArray::fromJson(R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10,
            "directivity": "point", "boardReflection": 1, "boards": [)" +
                                      boards + "]}",
                                  "a.json");
        ADD_FAILURE();
    }
    catch (const base::InputError& error)
    {
        EXPECT_NE(std::string(error.what()).find("boards are in 9 planes; at most 8 can reflect"),
                  std::string::npos)
            << error.what();
    }
}
