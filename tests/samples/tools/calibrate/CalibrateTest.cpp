// Runs the built program as a user would.

#include "tests/samples/Shell.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iomanip>
#include <random>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace
{

const std::string kProgram = MIDAIR_BIN "/midair-calibrate";

std::string temporary(const std::string& name)
{
    return testing::TempDir() + "midair-" + name;
}

Eigen::Isometry3d truth()
{
    Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
    result.linear() =
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    result.translation() = Eigen::Vector3d(0.4, -1.2, 0.3);
    return result;
}

/// Fourteen pairs with 0.3 mm of noise, the sixth wrong by 60 mm; world points in \a worldUnit_m.
std::string pairsFile(const std::string& name, double worldUnit_m)
{
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> box(-0.1, 0.1);
    std::normal_distribution<double> noise(0.0, 0.3e-3);
    const std::string path = temporary(name);
    std::ofstream out(path);
    out << "world x,world y,world z,array x,array y,array z\n" << std::setprecision(12);
    for (int k = 0; k < 14; ++k)
    {
        const Eigen::Vector3d spot(box(random), box(random), box(random));
        const Eigen::Vector3d world = truth().inverse() * spot / worldUnit_m;
        Eigen::Vector3d array = spot + Eigen::Vector3d(noise(random), noise(random), noise(random));
        if (k == 5) array.z() += 0.06;
        out << world.x() << "," << world.y() << "," << world.z() << "," << array.x() << ","
            << array.y() << "," << array.z() << "\n";
    }
    return path;
}

Eigen::Matrix4d readMatrix(const std::string& path)
{
    std::ifstream in(path);
    std::string comment;
    std::getline(in, comment);
    EXPECT_EQ(comment,
              "# the rows of an osg::Matrixd, as Calibration has them: array = world * M, metres");
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero(); // of column vectors: the transpose
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            in >> matrix(row, column);
    EXPECT_TRUE(in.good() || in.eof());
    return matrix;
}

std::string sceneFile(const std::string& name, const std::string& node)
{
    const std::string path = temporary(name);
    std::ofstream(path) << "#Ascii Scene\n#Version 162\n#Generator OpenSceneGraph 3.6.5\n\n"
                        << node << " {\n  UniqueID 1\n}\n";
    return path;
}

TEST(MidairCalibrate, WritesTheMatrixAndSaysHowGoodItIs)
{
    const std::string matrix = temporary("matrix.txt");
    const Outcome outcome =
        shell(kProgram + " " + pairsFile("pairs.csv", 1.0) + " --matrix " + matrix);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("calibrated from 13 of 14 point pairs\n"), std::string::npos)
        << outcome.output;
    EXPECT_NE(outcome.output.find("warning: pairs left out as outliers: 6 ("), std::string::npos)
        << outcome.output;
    EXPECT_NE(
        outcome.output.find("likely error at the workspace's edge, 150 mm from its centre: 0."),
        std::string::npos)
        << outcome.output;
    // 13 pairs at 0.3 mm over 200 mm: angles to about 1 mrad, which 1.3 m of lever turn into 1.5
    // mm.
    EXPECT_LT((readMatrix(matrix) - truth().matrix()).cwiseAbs().maxCoeff(), 5e-3);
}

TEST(MidairCalibrate, TheMatrixIsThatOfASceneFileNumberByNumber)
{
    const std::string matrix = temporary("rows.txt");
    const std::string scene = sceneFile("rows.osgt", "osgMidair::HapticScene");
    const Outcome outcome = shell(kProgram + " " + pairsFile("pairs-rows.csv", 1.0) + " --matrix " +
                                  matrix + " --scene " + scene);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    std::ifstream in(matrix);
    std::string comment;
    std::getline(in, comment);
    std::ifstream file(scene);
    std::string word;
    while (file >> word && word != "Calibration")
        ;
    file >> word; // {
    for (int k = 0; k < 16; ++k)
    {
        double ours = 0.0;
        double theirs = 1.0;
        in >> ours;
        file >> theirs;
        EXPECT_NEAR(ours, theirs, 1e-5 + 1e-5 * std::abs(ours)) << k;
    }
    EXPECT_TRUE(in.good() && file.good());
}

TEST(MidairCalibrate, ReadsStdinAndUnits)
{
    const std::string metres = temporary("metres.txt");
    const std::string millimetres = temporary("millimetres.txt");
    const Outcome a =
        shell(kProgram + " --matrix " + metres + " < " + pairsFile("pairs-m.csv", 1.0));
    const Outcome b = shell(kProgram + " - --unit mm --matrix " + millimetres + " < " +
                            pairsFile("pairs-mm.csv", 1e-3));
    EXPECT_EQ(a.code, 0) << a.output;
    EXPECT_EQ(b.code, 0) << b.output;
    // The same spots, written with 12 digits.
    EXPECT_LT((readMatrix(metres) - readMatrix(millimetres)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(MidairCalibrate, RefusesTheWrongUnitAndWritesNothing)
{
    const std::string matrix = temporary("unwritten.txt");
    std::remove(matrix.c_str());
    const Outcome outcome =
        shell(kProgram + " " + pairsFile("wrong-unit.csv", 1e-3) + " --matrix " + matrix);
    EXPECT_EQ(outcome.code, 1) << outcome.output;
    EXPECT_NE(outcome.output.find("so they are probably in millimetres where metres are expected"),
              std::string::npos)
        << outcome.output;
    EXPECT_FALSE(std::ifstream(matrix).good());
}

/// The Calibration of a HapticScene in an .osgt file, as OSG writes it: rows of the transpose.
Eigen::Matrix4d calibrationIn(const std::string& path)
{
    std::ifstream in(path);
    std::string word;
    while (in >> word && word != "Calibration")
        ;
    in >> word; // {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            in >> matrix(row, column);
    EXPECT_TRUE(in.good());
    return matrix;
}

TEST(MidairCalibrate, WritesTheMatrixIntoAScene)
{
    const std::string in = sceneFile("in.osgt", "osgMidair::HapticScene");
    const std::string out = temporary("out.osgt");
    std::remove(out.c_str());
    const Outcome outcome = shell(kProgram + " " + pairsFile("pairs-scene.csv", 1.0) + " --scene " +
                                  in + " --out " + out);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("calibration written into 1 HapticScene of " + out),
              std::string::npos)
        << outcome.output;
    // As for the matrix file above.
    EXPECT_LT((calibrationIn(out) - truth().matrix()).cwiseAbs().maxCoeff(), 5e-3);
}

TEST(MidairCalibrate, ASceneWithoutAHapticSceneIsNamed)
{
    const std::string in = sceneFile("plain.osgt", "osg::Group");
    const Outcome outcome =
        shell(kProgram + " " + pairsFile("pairs-plain.csv", 1.0) + " --scene " + in);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.output.find("midair-calibrate: there is no osgMidair::HapticScene in \"" +
                                  in + "\" to hold a calibration\n"),
              std::string::npos)
        << outcome.output;
}

TEST(MidairCalibrate, InputErrorsAreNamed)
{
    const Outcome missing = shell(kProgram + " /nowhere/pairs.csv");
    EXPECT_EQ(missing.code, 2);
    EXPECT_EQ(
        missing.output,
        "midair-calibrate: point pairs \"/nowhere/pairs.csv\": can't be read: No such file or "
        "directory; give a file of point pairs, or - for stdin\n");
    const Outcome endless = shell(kProgram + " /dev/zero");
    EXPECT_EQ(endless.code, 2);
    EXPECT_EQ(endless.output,
              "midair-calibrate: point pairs \"/dev/zero\": is a device or a pipe, should be a "
              "regular file; give a file of point pairs, or - for stdin\n");
    const Outcome tooMuch = shell("head -c 16777217 /dev/zero | " + kProgram + " -");
    EXPECT_EQ(tooMuch.code, 2);
    EXPECT_EQ(tooMuch.output,
              "midair-calibrate: stdin has over 16 MiB, should have at most as much\n");
    const Outcome line = shell("echo 1 2 3 | " + kProgram + " -");
    EXPECT_EQ(line.code, 2);
    EXPECT_EQ(line.output,
              "midair-calibrate: stdin, line 1: 3 columns; a point pair has six: world x, y, z, "
              "array x, y, "
              "z\n");
    const Outcome unit = shell("echo 1 2 3 4 5 6 | " + kProgram + " --unit cubit");
    EXPECT_EQ(unit.code, 2);
    EXPECT_EQ(unit.output,
              "midair-calibrate: unit \"cubit\" is not known; give m, cm, mm, um, in, ft, or the "
              "metres a "
              "unit has\n");
}

} // namespace
