#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "tests/TrustedVariables.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>
using namespace midair::haptics;

namespace
{

// The keys that every file needs, and one transducer.
const std::string kKeys =
    R"("frequency_Hz": 40000, "sourceAmplitude_Pa_m": 10.1, "directivity": "point")";
const std::string kOneTransducer =
    R"("transducers": [{"position_m": [0, 0, 0], "normal": [0, 0, 1]}])";

void expectEqual(const TransducerArray& a, const TransducerArray& b)
{
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.frequency_Hz, b.frequency_Hz);
    EXPECT_EQ(a.sourceAmplitude_Pa_m, b.sourceAmplitude_Pa_m);
    EXPECT_EQ(a.exposureAmplitude_Pa_m, b.exposureAmplitude_Pa_m);
    EXPECT_EQ(a.directivity, b.directivity);
    EXPECT_EQ(a.ringing_s, b.ringing_s);
    EXPECT_TRUE(a.positions == b.positions);
    EXPECT_TRUE(a.normals == b.normals);
    ASSERT_EQ(a.phaseOffset_rad.size(), b.phaseOffset_rad.size());
    EXPECT_TRUE(a.phaseOffset_rad == b.phaseOffset_rad);
    ASSERT_EQ(a.gain.size(), b.gain.size());
    EXPECT_TRUE(a.gain == b.gain);
    EXPECT_EQ(a.board, b.board);
    EXPECT_EQ(a.drive.phaseLevels, b.drive.phaseLevels);
    EXPECT_EQ(a.drive.amplitudeLevels, b.drive.amplitudeLevels);
}

class TemporaryFolder
{
public:
    TemporaryFolder() : _path(testing::TempDir() + "midair-arrays-" + std::to_string(::getpid()))
    {
        std::filesystem::remove_all(_path);
        std::filesystem::create_directories(_path);
    }
    ~TemporaryFolder() { std::filesystem::remove_all(_path); }

    std::string write(const std::string& name, const std::string& text) const
    {
        const std::string path = _path + "/" + name;
        std::ofstream(path) << text;
        return path;
    }
    const std::string& path() const { return _path; }

private:
    std::string _path;
};

} // namespace

TEST(TransducerArrayFile, TransducersRingAsTheirTypeDoesOrAsTheFileSays)
{
    const auto ringing_s = [](const std::string& directivity, const std::string& more)
    {
        return TransducerArray::fromJson(
                   R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 1, "directivity": ")" +
                       directivity + "\"" + more + ", " + kOneTransducer + "}",
                   "a.json")
            .ringing_s;
    };
    EXPECT_EQ(ringing_s("t4010a1-table", ""), 190e-6);
    EXPECT_EQ(ringing_s("t4010a1-harmonics", ""), 190e-6);
    EXPECT_EQ(ringing_s("point", ""), 0.0);
    EXPECT_EQ(ringing_s("point", R"(, "ringing": 276e-6)"), 276e-6);
    EXPECT_EQ(ringing_s("t4010a1-table", R"(, "ringing": 0)"), 0.0);
    for (const std::string& name : TransducerArray::names())
        EXPECT_EQ(TransducerArray::load(name).ringing_s, 190e-6) << name;
    TransducerArray array = TransducerArray::singleBoard();
    array.ringing_s = 1.6e-4;
    expectEqual(TransducerArray::fromJson(array.toJson(), "a.json"), array);
    for (const double wrong : {-1e-6, 0.011, std::nan("")})
    {
        array.ringing_s = wrong;
        std::string error;
        EXPECT_FALSE(array.isValid(&error));
        EXPECT_EQ(error.find("ringing is "), 0u) << error;
    }
}

TEST(TransducerArrayFile, WhatEarsHearIsWrittenAsWell)
{
    const TransducerArray octagon = TransducerArray::load("octagon");
    EXPECT_EQ(octagon.exposureAmplitude_Pa_m, 10.1);
    expectEqual(TransducerArray::fromJson(octagon.toJson(), "again"), octagon);
}

TEST(TransducerArrayFile, FlatListIsReadAsWritten)
{
    const TransducerArray array = TransducerArray::fromJson(R"({
        "name": "three", "frequency_Hz": 25000, "sourceAmplitude_Pa_m": 5.5, "directivity": "t4010a1-table",
        "phaseLevels": 0, "amplitudeLevels": [0, 0.25, 1],
        "transducers": [
            {"position_m": [0.1, -0.2, 0.3], "normal": [0, 0, -2], "gain": 0.9},
            {"position_m": [0, 0, 0], "normal": [3, 4, 0], "board": 0, "comment": "loose"},
            {"position_m": [0, 0.1, 0], "normal": [1, 0, 0], "board": 1, "phaseOffset_rad": -0.5}]})",
                                                            "a.json");
    EXPECT_EQ(array.name, "three");
    EXPECT_EQ(array.frequency_Hz, 25e3);
    EXPECT_EQ(array.sourceAmplitude_Pa_m, 5.5);
    EXPECT_EQ(array.directivity, Directivity::T4010A1_TABLE);
    ASSERT_EQ(array.size(), 3);
    EXPECT_EQ(array.positions.col(0), Eigen::Vector3d(0.1, -0.2, 0.3));
    EXPECT_EQ(array.normals.col(0), Eigen::Vector3d(0, 0, -1));
    EXPECT_TRUE(array.normals.col(1).isApprox(Eigen::Vector3d(0.6, 0.8, 0), 1e-15));
    EXPECT_EQ(array.board, (std::vector<int>{0, 0, 1}));
    EXPECT_EQ(array.gain, Eigen::Vector3d(0.9, 1.0, 1.0));
    EXPECT_EQ(array.phaseOffset_rad, Eigen::Vector3d(0.0, 0.0, -0.5));
    EXPECT_EQ(array.drive.phaseLevels, 0);
    EXPECT_EQ(array.drive.amplitudeLevels, (std::vector<float>{0.0f, 0.25f, 1.0f}));
    EXPECT_TRUE(array.isValid());
}

TEST(TransducerArrayFile, WithoutTheOptionalKeysThereAreNoOffsetsAndGains)
{
    const TransducerArray array =
        TransducerArray::fromJson("{" + kKeys + "," + kOneTransducer + "}", "a");
    EXPECT_EQ(array.phaseOffset_rad.size(), 0);
    EXPECT_EQ(array.gain.size(), 0);
    EXPECT_EQ(array.drive.phaseLevels, 256);
    EXPECT_TRUE(array.drive.amplitudeLevels.empty());
    EXPECT_EQ(array.name, "");
}

TEST(TransducerArrayFile, BoardsFaceAnyWay)
{
    const TransducerArray array = TransducerArray::fromJson("{" + kKeys + R"(, "boards": [
        {"position_m": [0, 0, 0.2], "normal": [0, 0, -1], "columns": 3, "rows": 2, "pitch_m": 0.01},
        {"position_m": [0, -0.1, 0], "normal": [0, 1, 0], "columns": 2, "rows": 2, "pitch_m": 0.02, "without": [[2, 1]],
         "gain": 0.5},
        {"position_m": [1, 2, 3], "normal": [1, 1, 1], "columnsAlong": [1, 0, 0], "places_m": [[0, 0], [0.1, 0], [0, 0.1]],
         "phaseOffset_rad": [0.1, 0.2, 0.3]}]})",
                                                            "a.json");
    ASSERT_EQ(array.size(), 6 + 3 + 3);
    EXPECT_EQ(array.board, (std::vector<int>{0, 0, 0, 0, 0, 0, 1, 1, 1, 2, 2, 2}));
    // Facing -z, level columns run along -x, rows up.
    EXPECT_TRUE(array.positions.col(0).isApprox(Eigen::Vector3d(0.01, -0.005, 0.2), 1e-14));
    EXPECT_TRUE(array.positions.col(2).isApprox(Eigen::Vector3d(-0.01, -0.005, 0.2), 1e-14));
    EXPECT_TRUE(array.positions.col(3).isApprox(Eigen::Vector3d(0.01, 0.005, 0.2), 1e-14));
    // Facing up: columns along +x, rows along y x x = -z; column 2 of row 1 is left out.
    EXPECT_TRUE(array.positions.col(6).isApprox(Eigen::Vector3d(-0.01, -0.1, 0.01), 1e-14));
    EXPECT_TRUE(array.positions.col(7).isApprox(Eigen::Vector3d(-0.01, -0.1, -0.01), 1e-14));
    EXPECT_TRUE(array.positions.col(8).isApprox(Eigen::Vector3d(0.01, -0.1, -0.01), 1e-14));
    // A slanted board: its places stay in its plane, at their distances, columns and rows at right
    // angles.
    const Eigen::Vector3d normal = Eigen::Vector3d(1, 1, 1).normalized();
    const Eigen::Vector3d middle(1, 2, 3);
    EXPECT_EQ(array.positions.col(9), middle);
    const Eigen::Vector3d u = array.positions.col(10) - middle;
    const Eigen::Vector3d v = array.positions.col(11) - middle;
    EXPECT_NEAR(u.norm(), 0.1, 1e-14);
    EXPECT_NEAR(v.norm(), 0.1, 1e-14);
    EXPECT_TRUE((u.cross(v) / 0.01).isApprox(normal, 1e-12));
    EXPECT_TRUE(array.normals.col(11).isApprox(normal, 1e-14));

    Eigen::VectorXd gain = Eigen::VectorXd::Ones(12);
    gain.segment(6, 3).setConstant(0.5);
    EXPECT_EQ(array.gain, gain);
    Eigen::VectorXd offset = Eigen::VectorXd::Zero(12);
    offset.tail(3) << 0.1, 0.2, 0.3;
    EXPECT_EQ(array.phaseOffset_rad, offset);
}

TEST(TransducerArrayFile, RoundTripIsExact)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    expectEqual(TransducerArray::fromJson(array.toJson(), "a.json"), array);

    array = TransducerArray::singleBoard();
    array.name = "with \"quotes\" and \xC3\xA9";
    array.directivity = Directivity::POINT;
    array.phaseOffset_rad = Eigen::VectorXd::LinSpaced(array.size(), -3.0, 3.0);
    array.gain = Eigen::VectorXd::LinSpaced(array.size(), 0.0, 1.1);
    array.normals.col(7) = Eigen::Vector3d(0.3, -0.2, 0.7).normalized();
    array.drive.phaseLevels = 10;
    array.drive.amplitudeLevels = {0.1f, 1.0f};
    expectEqual(TransducerArray::fromJson(array.toJson(), "a.json"), array);

    const TemporaryFolder folder;
    const std::string path = folder.path() + "/saved.json";
    array.save(path);
    expectEqual(TransducerArray::load(path), array);
}

TEST(TransducerArrayFile, AnInvalidArrayIsNotWritten)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.positions(1, 3) = std::nan("");
    try
    {
        array.toJson();
        FAIL();
    }
    catch (const midair::base::InputError& error)
    {
        EXPECT_STREQ(
            error.what(),
            "array 'board' can't be written: a position, phase offset or gain is not finite");
    }
}

TEST(TransducerArrayFile, MissingFilesAndUnknownNamesSayWhatIsKnown)
{
    std::string known;
    for (const std::string& name : TransducerArray::names())
        known += (known.empty() ? "" : ", ") + name;
    EXPECT_EQ(known.find("octagon, board, "), 0u);
    for (const char* name : {"octagonn", "missing.json", "/no/such/folder/x.json", ""})
        try
        {
            TransducerArray::load(name);
            FAIL() << name;
        }
        catch (const midair::base::InputError& error)
        {
            EXPECT_EQ(std::string(error.what()),
                      "array '" + std::string(name) +
                          "': there is no such file, and no array of that name; known are octagon, "
                          "board, autd3, octagon-autd3, openmpd, "
                          "sonicsurface, ultraino64, or the path of a JSON file");
        }
    const TemporaryFolder folder;
    try
    {
        TransducerArray::load(folder.path());
        FAIL();
    }
    catch (const midair::base::InputError& error)
    {
        EXPECT_EQ(std::string(error.what()),
                  "array file '" + folder.path() + "' is a folder; a JSON file is expected");
    }
    try
    {
        TransducerArray::singleBoard().save(folder.path() + "/none/x.json");
        FAIL();
    }
    catch (const midair::base::InputError& error)
    {
        EXPECT_EQ(std::string(error.what()),
                  "array file '" + folder.path() + "/none/x.json' can't be written");
    }
}

TEST(TransducerArrayFile, OwnFoldersComeBeforeTheShippedOnes)
{
    const TemporaryFolder folder;
    folder.write("mine.json", "{" + kKeys + "," + kOneTransducer + "}");
    folder.write("openmpd.json", "{" + kKeys + "," + kOneTransducer + "}");
    midair::base::trustVariablesOfProgram();
    ::setenv("OSG_MIDAIR_ARRAYS", ("/no/such/folder:" + folder.path()).c_str(), 1);
    const TransducerArray mine = TransducerArray::load("mine");
    const TransducerArray replaced = TransducerArray::load("openmpd");
    const std::vector<std::string> names = TransducerArray::names();
    ::unsetenv("OSG_MIDAIR_ARRAYS");

    EXPECT_EQ(mine.size(), 1);
    EXPECT_EQ(mine.name, "mine"); // the file names none
    EXPECT_EQ(replaced.size(), 1);
    EXPECT_EQ(TransducerArray::load("openmpd").size(), 256);
    for (const char* name : {"octagon",
                             "board",
                             "autd3",
                             "mine",
                             "octagon-autd3",
                             "openmpd",
                             "sonicsurface",
                             "ultraino64"})
        EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
}

TEST(TransducerArrayFile, ShippedArraysAreTheDevicesTheyName)
{
    const TransducerArray sonic = TransducerArray::load("sonicsurface");
    EXPECT_EQ(sonic.drive.phaseLevels, 32);
    EXPECT_EQ(sonic.drive.amplitudeLevels, (std::vector<float>{0.0f, 1.0f}));
    const TransducerArray openmpd = TransducerArray::load("openmpd");
    EXPECT_EQ(openmpd.drive.phaseLevels, 128);
    ASSERT_EQ(openmpd.drive.amplitudeLevels.size(), 65u);
    const TransducerArray ultraino = TransducerArray::load("ultraino64");
    EXPECT_EQ(ultraino.drive.phaseLevels, 10);
    ASSERT_EQ(ultraino.drive.amplitudeLevels.size(), 6u);
    const double pi = std::acos(-1.0);
    for (int d = 0; d <= 64; ++d) // duty d of 128
        EXPECT_NEAR(openmpd.drive.amplitudeLevels[static_cast<std::size_t>(d)],
                    std::sin(pi * d / 128.0),
                    1e-7);
    for (int n = 0; n <= 5; ++n) // n high steps of ten
        EXPECT_NEAR(ultraino.drive.amplitudeLevels[static_cast<std::size_t>(n)],
                    std::sin(pi * n / 10.0),
                    1e-7);

    // Each is a full square grid round the origin, in whatever order: of 10.5 mm, Ultraino's
    // of 10.0 mm.
    for (const TransducerArray* array : {&sonic, &openmpd, &ultraino})
    {
        EXPECT_TRUE(array->isValid());
        const int side = array == &ultraino ? 8 : 16;
        const double pitch_m = array == &ultraino ? 10.0e-3 : 10.5e-3;
        ASSERT_EQ(array->size(), side * side) << array->name;
        std::vector<int> seen(static_cast<std::size_t>(side * side), 0);
        for (int i = 0; i < array->size(); ++i)
        {
            const double column = array->positions(0, i) / pitch_m + 0.5 * (side - 1);
            const double row = array->positions(1, i) / pitch_m + 0.5 * (side - 1);
            EXPECT_NEAR(column, std::round(column), 1e-9);
            EXPECT_NEAR(row, std::round(row), 1e-9);
            ++seen.at(static_cast<std::size_t>(std::lround(row) * side + std::lround(column)));
            EXPECT_EQ(array->positions(2, i), 0.0);
            EXPECT_EQ(array->normals.col(i), Eigen::Vector3d::UnitZ());
        }
        EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), side * side) << array->name;
    }
    // A spot check of the wiring: OpenMPD's pin 249.
    EXPECT_TRUE(openmpd.positions.col(249).isApprox(Eigen::Vector3d(-0.07875, 0.07875, 0), 1e-12));
}

// The data sheet's -6 dB at 50 degrees are what whoever puts hands above a board gets; the paper's
// harmonics (-2.2 dB) are those with which the source amplitude of its array was derived.
TEST(TransducerArrayFile, BoardsHaveTheMeasuredDirectivityAndThePrismThePapers)
{
    for (const std::string& name : TransducerArray::names())
    {
        const TransducerArray array = TransducerArray::load(name);
        const double at50_dB =
            20.0 *
            std::log10(directivity(array.directivity, std::cos(midair::base::toRadians(50.0))));
        if (name == "octagon" || name == "octagon-autd3")
            EXPECT_NEAR(at50_dB, -2.2, 0.05);
        else
            EXPECT_NEAR(at50_dB, -6.0, 1e-9) << name;
    }
    EXPECT_EQ(TransducerArray().directivity, Directivity::T4010A1_TABLE);
}

// The board's published control program (upnalab/SonicSurface,
// ControlSoftware/Python/SonicSurface.py) has these emitters, in the order of the wire, at (column,
// emission, row), which is right-handed there: its focus is computed with them as they stand. The
// rows have their middle at 2 mm.
TEST(TransducerArrayFile, SonicSurfaceIsTheBoardAndNotItsMirrorImage)
{
    struct Emitter
    {
        int wire;
        double column_m;
        double row_m;
    };
    const Emitter published[] = {{0, -0.07875, 0.08075},
                                 {1, -0.05775, 0.08075},
                                 {3, -0.06825, 0.07025},
                                 {64, -0.03675, 0.08075},
                                 {100, -0.03675, -0.01375},
                                 {128, 0.00525, 0.08075},
                                 {192, 0.04725, 0.08075},
                                 {255, 0.05775, -0.06625}};
    const TransducerArray array = TransducerArray::load("sonicsurface");
    // Of their frame, x along the columns, y the emission, z along the rows, into ours.
    Eigen::Matrix3d turn;
    turn.col(0) = Eigen::Vector3d::UnitX();
    turn.col(1) = array.normals.col(0);
    turn.col(2) = turn.col(0).cross(turn.col(1));
    ASSERT_NEAR(turn.determinant(), 1.0, 1e-12) << "a board can be turned, not mirrored";
    const Eigen::Vector3d focus(0.02, 0.03, 0.12);
    const Eigen::Vector3d theirFocus = turn.transpose() * focus;
    for (const Emitter& emitter : published)
    {
        const Eigen::Vector3d there(emitter.column_m, 0.0, emitter.row_m - 0.002);
        EXPECT_NEAR((array.positions.col(emitter.wire) - turn * there).norm(), 0.0, 1e-9)
            << emitter.wire;
        // So a focus is where it is asked for: all paths to it are as long as in the published
        // frame.
        EXPECT_NEAR(
            (array.positions.col(emitter.wire) - focus).norm(), (there - theirFocus).norm(), 1e-9)
            << emitter.wire;
    }
}
