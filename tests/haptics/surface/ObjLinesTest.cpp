#include "haptics/base/InputError.h"
#include "haptics/surface/ObjReader.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace midair::haptics
{

namespace
{

const std::string kCorners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TriangleMesh read(const std::string& text)
{
    // Tests run side by side, so each has a file of its own.
    const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
    const auto path = std::filesystem::path(testing::TempDir()) / ("midair_" + test + ".obj");
    std::ofstream(path, std::ios::binary) << text;
    return readObj(path.string());
}

/// What the error says after the path; "no error" if there was none.
std::string errorOf(const std::string& text)
{
    try
    {
        read(text);
    }
    catch (const base::InputError& error)
    {
        const std::string what = error.what();
        return what.substr(what.find(".obj") + 4);
    }
    return "no error";
}

} // namespace

TEST(ObjLines, LinesAndPointsAreTrianglesWithoutArea)
{
    const TriangleMesh mesh = read(kCorners + "p 4\nl 1/1 2/2 -2\nf 1 2 3\np 1 2\n");
    Eigen::Matrix3Xi wanted(3, 6);
    wanted << 0, 3, 0, 1, 0, 1, // face, p 4, l 1 2, l 2 3, p 1, p 2
        1, 3, 1, 2, 0, 1,       //
        2, 3, 1, 2, 0, 1;
    EXPECT_EQ(mesh.triangles, wanted);
    EXPECT_EQ(read(kCorners + "l 1 2\n").triangles, Eigen::Vector3i(0, 1, 1));
}

TEST(ObjLines, BrokenOnesAreNamed)
{
    EXPECT_EQ(errorOf(kCorners + "l 1\n"), ", line 5: the line has 1 vertices; it needs 2 or more");
    EXPECT_EQ(errorOf(kCorners + "p\n"),
              ", line 5: the point element has 0 vertices; it needs 1 or more");
    EXPECT_EQ(errorOf(kCorners + "l 1 2 5\n"),
              ", line 5: the line or point refers to vertex 5; the file has 4 vertices");
}

} // namespace midair::haptics
