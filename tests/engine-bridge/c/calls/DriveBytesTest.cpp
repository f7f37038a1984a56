// The drives of midair_solve() are those of midair-solve, byte by byte.
#include "tests/Emulator.h"
#include "tests/engine-bridge/c/Star.h"
#include "tests/samples/Shell.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace
{

namespace fs = std::filesystem;

std::string bytesOf(const std::string& path)
{
    std::ifstream in(path, std::ios::binary);
    std::ostringstream bytes;
    bytes << in.rdbuf();
    return bytes.str();
}

/// One input, as midair-solve takes it and as the C interface does.
struct Input
{
    std::string name;
    std::string options;
    std::vector<std::pair<std::string, std::string>> settings;
    std::vector<std::pair<std::string, std::string>> properties;
    std::string array = "octagon";
};

/// Its name alone, as messages have it: the bytes between its members are not set.
void PrintTo(const Input& input, std::ostream* out)
{
    *out << input.name;
}

class DriveBytes : public testing::TestWithParam<Input>
{
protected:
    DriveBytes() : folder(testing::TempDir() + "midair-c-bytes-" + GetParam().name)
    {
        fs::remove_all(folder);
        fs::create_directories(folder);
    }

    /// Compares all drives of \a solved with those in the folder; returns their number.
    std::size_t compared(const Solved& solved) const
    {
        std::size_t same = 0;
        for (std::size_t k = 0; k < solved.info.fields; ++k)
        {
            const std::string own = folder + "/own.csv";
            EXPECT_EQ(midair_field_write_drive(solved.field, k, own.c_str()), MIDAIR_OK);
            const std::string number = (k + 1 < 10 ? "0" : "") + std::to_string(k + 1);
            const std::string theirs =
                folder + (solved.info.fields == 1 ? "/drive.csv" : "/drive_" + number + ".csv");
            const std::string wanted = bytesOf(theirs);
            EXPECT_GT(wanted.size(), 1000U) << theirs;
            if (bytesOf(own) == wanted) ++same;
        }
        return same;
    }

    const std::string folder;
};

} // namespace

TEST_P(DriveBytes, AreThoseOfMidairSolve)
{
    const Input& input = GetParam();
    const std::string star = std::string(MIDAIR_ROOT) + "/samples/models/star.obj";
    const auto program =
        shell(startOf(MIDAIR_BIN "/midair-solve") + " " + star + " --size 0.08 --array " +
              input.array + " " + input.options + " --out " + folder);
    ASSERT_EQ(program.code, 0) << program.output;
    Opened of(input.array.c_str());
    const midair_object object = addStar(of.scene);
    for (const auto& [name, value] : input.settings)
        ASSERT_EQ(midair_set(of.scene, name.c_str(), value.c_str()), MIDAIR_OK)
            << midair_last_error();
    for (const auto& [name, value] : input.properties)
        ASSERT_EQ(midair_object_set(of.scene, object, name.c_str(), value.c_str()), MIDAIR_OK)
            << midair_last_error();
    const Solved solved(of.scene);
    ASSERT_EQ(solved.status, MIDAIR_OK) << solved.why;
    EXPECT_EQ(compared(solved), solved.info.fields);
}

INSTANTIATE_TEST_SUITE_P(
    OfTheStar,
    DriveBytes,
    testing::Values(Input{"surface", "", {}, {}},
                    Input{"vertices", "--sampling vertices", {}, {{"sampling", "vertices"}}},
                    Input{"edges",
                          "--sampling edges --spacing 7mm",
                          {},
                          {{"sampling", "edges"}, {"spacing", "7 mm"}}},
                    Input{"pressure", "--pressure 400", {}, {{"pressure", "400 Pa"}}},
                    Input{"capped",
                          "--max-pressure 300 --temperature 27",
                          {{"maxPressure", "300 Pa"}, {"temperature", "27"}},
                          {}},
                    Input{"ears", "--ear-limit 128", {{"earLimit", "128"}}, {}},
                    Input{"cycle", "--cycle 3", {{"cycle", "3"}}, {}},
                    Input{"subsets", "--subsets 2", {{"subsets", "2"}}, {}},
                    Input{"amplitudes",
                          "--no-phase-only --loudness 0.7",
                          {{"phaseOnly", "false"}, {"loudness", "0.7"}},
                          {}}),
    [](const auto& info) { return info.param.name; });

TEST(DriveBytesOfPoints, AreThoseOfMidairSolve)
{
    const std::string folder = testing::TempDir() + "midair-c-bytes-points";
    fs::remove_all(folder);
    fs::create_directories(folder);
    std::ofstream(folder + "/points.csv") << "x_m,y_m,z_m,nx,ny,nz,target_Pa\n"
                                             "0,0,0.01,0,0,1,800\n"
                                             "0.02,0.01,0,0,0,1,713.7\n"
                                             "-0.015,-0.02,0.005,0,1,0,333.3\n";
    const auto program = shell(startOf(MIDAIR_BIN "/midair-solve") + " --points-file " + folder +
                               "/points.csv --out " + folder);
    ASSERT_EQ(program.code, 0) << program.output;
    Opened of;
    const double positions[] = {0, 0, 0.01, 0.02, 0.01, 0, -0.015, -0.02, 0.005};
    const double pressures[] = {800, 713.7, 333.3};
    midair_object points = 0;
    ASSERT_EQ(midair_add_points(of.scene, positions, pressures, 3, 1, &points), MIDAIR_OK);
    const Solved solved(of.scene);
    ASSERT_EQ(solved.status, MIDAIR_OK) << solved.why;
    const std::string own = folder + "/own.csv";
    ASSERT_EQ(midair_field_write_drive(solved.field, 0, own.c_str()), MIDAIR_OK);
    EXPECT_EQ(bytesOf(own), bytesOf(folder + "/drive.csv"));
    std::vector<midair_point> told(3);
    ASSERT_EQ(midair_field_points(solved.field, told.data(), told.size()), MIDAIR_OK);
    EXPECT_FLOAT_EQ(static_cast<float>(told[1].wanted_Pa), 713.7F);
    EXPECT_NEAR(told[1].achieved_Pa, 713.7, 10.0);
    EXPECT_EQ(told[1].object, points);
}

TEST(DriveBytesOfPoints, AreNotThoseOfOtherPoints)
{
    Opened of;
    const double near[] = {0, 0, 0.01};
    midair_object points = 0;
    ASSERT_EQ(midair_add_points(of.scene, near, nullptr, 1, 0, &points), MIDAIR_OK);
    const Solved solved(of.scene);
    const double moved[] = {0, 0, 0.0105};
    ASSERT_EQ(midair_move_vertices(of.scene, points, moved, 1), MIDAIR_OK);
    const Solved other(of.scene);
    EXPECT_NE(solved.activations(), other.activations());
}
