#include "haptics/base/InputError.h"
#include "haptics/surface/ObjReader.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace midair::haptics
{

namespace
{

const std::string kCorners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

std::string written(const std::string& text)
{
    // Tests run side by side, so each has a file of its own.
    const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
    const auto path = std::filesystem::path(testing::TempDir()) / ("midair_" + test + ".obj");
    std::ofstream(path, std::ios::binary) << text;
    return path.string();
}

TriangleMesh read(const std::string& text, std::vector<std::string>* warnings = nullptr)
{
    return readObj(written(text), warnings);
}

/// The lines of a plain text that begin with \a word.
std::vector<std::string> linesOf(const std::string& text, const std::string& word)
{
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);)
        if (line.rfind(word + " ", 0) == 0) lines.push_back(line);
    return lines;
}

double areaOf(const TriangleMesh& mesh)
{
    double sum = 0.0;
    for (const auto& t : mesh.triangles.colwise())
    {
        const Eigen::Vector3d a = mesh.vertices.col(t[0]);
        const Eigen::Vector3d ab = mesh.vertices.col(t[1]) - a;
        sum += 0.5 * ab.cross(Eigen::Vector3d(mesh.vertices.col(t[2]) - a)).norm();
    }
    return sum;
}

/// A polygon of \a corners (2 x n) in a plane that is turned, as the file's one face.
TriangleMesh polygon(const std::vector<Eigen::Vector2d>& corners,
                     const Eigen::Quaterniond& turn,
                     std::size_t first,
                     std::vector<std::string>* warnings = nullptr)
{
    std::ostringstream text;
    text.precision(17);
    for (const Eigen::Vector2d& corner : corners)
        text << "v " << (turn * Eigen::Vector3d(corner.x(), corner.y(), 0.25)).transpose() << "\n";
    text << "f";
    for (std::size_t i = 0; i < corners.size(); ++i)
        text << " " << (first + i) % corners.size() + 1;
    return read(text.str() + "\n", warnings);
}

double shoelace(const std::vector<Eigen::Vector2d>& p)
{
    double twice = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i)
    {
        const Eigen::Vector2d& next = p[(i + 1) % p.size()];
        twice += p[i].x() * next.y() - p[i].y() * next.x();
    }
    return 0.5 * std::abs(twice);
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

TEST(ObjLines, ElementsWithTooFewCornersAreLeftOutAndToldWithTheirLine)
{
    std::vector<std::string> warnings;
    const TriangleMesh mesh = read(kCorners + "f 1 2\nf 1 2 3\nl 4\np\nf\n", &warnings);
    EXPECT_EQ(mesh.triangles, Eigen::Vector3i(0, 1, 2));
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_EQ(warnings[0].substr(warnings[0].find(".obj") + 4),
              ", line 5: the face has 2 corners; it needs 3 or more: it is left out, and 3 more");
}

TEST(ObjLines, WhereSomeVerticesHaveColoursEachKeepsItsOwn)
{
    for (int without = 0; without < 3; ++without)
    {
        std::string text;
        for (int i = 0; i < 3; ++i)
            text += "v " + std::to_string(i) + " " + std::to_string(i * i) + " 0" +
                    (i == without ? "\n" : " 0.5 0.5 0.5\n");
        std::vector<std::string> warnings;
        const TriangleMesh mixed = read(text + "f 1 2 3\n", &warnings);
        ASSERT_EQ(mixed.intensity.size(), 3);
        for (int i = 0; i < 3; ++i)
            EXPECT_EQ(mixed.intensity[i], i == without ? 1.0F : 0.5F) << without << i;
        ASSERT_EQ(warnings.size(), 1U);
        EXPECT_NE(warnings[0].find(": 2 of 3 vertices have a colour; the others are white"),
                  std::string::npos)
            << warnings[0];
        const std::vector<std::string> plain =
            linesOf(readPlainObj(written(text + "f 1 2 3\n")).text, "v");
        EXPECT_EQ(plain.at(static_cast<std::size_t>(without)).substr(7), " 1 1 1 1") << plain[0];
    }
}

TEST(ObjLines, MarksOfEditorsAndEndsOfLinesAreThoseOfAnySystem)
{
    const TriangleMesh plain = read(kCorners + "f 1 2 3 4\n");
    EXPECT_EQ(read("\xef\xbb\xbf" + kCorners + "f 1 2 3 4\n").vertices, plain.vertices);
    std::string mac = kCorners + "f 1 2 3 4\n";
    std::replace(mac.begin(), mac.end(), '\n', '\r');
    EXPECT_EQ(read(mac).triangles, plain.triangles);
    EXPECT_EQ(errorOf("v 0 0 0\r\nv 1 0 0\r\rv 1 nan 0\r\n"),
              ", line 4: vertex 3 has the coordinate \"nan\"; it must be finite");
    EXPECT_EQ(errorOf("\xff\xfev"), ": the file is UTF-16, should be UTF-8 or ASCII");
    std::vector<std::string> warnings;
    read(kCorners + "curv 0 1 1 2\nf 1 2 3\n", &warnings);
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_NE(warnings[0].find(", line 5: free-form curves"), std::string::npos) << warnings[0];
}

// Each in several planes, from each corner on, in both ways round: no triangle is outside.
TEST(ObjLines, ConcavePolygonsAreCutInside)
{
    using Corners = std::vector<Eigen::Vector2d>;
    Corners comb;
    for (int tooth = 0; tooth < 5; ++tooth)
        for (const auto& [x, y] : {std::pair(0.0, 1.0), {0.1, 1.0}, {0.1, 0.2}, {0.3, 0.2}})
            comb.emplace_back(0.3 * tooth + x, y);
    comb.emplace_back(1.5, 0.0);
    comb.emplace_back(0.0, 0.0);
    Corners spiral;
    for (int i = 0; i < 40; ++i)
        spiral.emplace_back(std::cos(0.3 * i) * (1 + 0.1 * i), std::sin(0.3 * i) * (1 + 0.1 * i));
    for (int i = 39; i >= 0; --i)
        spiral.emplace_back(std::cos(0.3 * i) * (0.7 + 0.1 * i),
                            std::sin(0.3 * i) * (0.7 + 0.1 * i));
    // The hole is joined to the outline by an edge there and back.
    const Corners ring = {
        {0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}};
    const Corners u = {{-3, -3}, {3, -3}, {3, 3}, {2, 3}, {2, -2}, {-2, -2}, {-2, 3}, {-3, 3}};
    const Corners inLine = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
    int polygons = 0;
    for (Corners corners : {comb, spiral, ring, u, inLine})
        for (const bool isBack : {false, true})
        {
            if (isBack) std::reverse(corners.begin(), corners.end());
            for (const auto& axis :
                 {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, 2, 3)})
                for (std::size_t first = 0; first < corners.size(); first += 3)
                {
                    const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.1, axis.normalized()));
                    std::vector<std::string> warnings;
                    const TriangleMesh mesh = polygon(corners, turn, first, &warnings);
                    // Triangles outside, or twice in one place, would add to the sum.
                    ASSERT_EQ(mesh.triangles.cols(), static_cast<int>(corners.size()) - 2);
                    ASSERT_NEAR(areaOf(mesh), shoelace(corners), 1e-9 * shoelace(corners));
                    ASSERT_TRUE(warnings.empty()) << warnings[0];
                    ++polygons;
                }
        }
    EXPECT_GT(polygons, 200);
}

TEST(ObjLines, APolygonThatCrossesItselfIsToldWithItsLine)
{
    const std::vector<Eigen::Vector2d> star = {{0, 3}, {2, -3}, {-3, 1}, {3, 1}, {-2, -3}};
    std::vector<std::string> warnings;
    EXPECT_EQ(polygon(star, Eigen::Quaterniond::Identity(), 0, &warnings).triangles.cols(), 3);
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_NE(warnings[0].find(", line 6: the face crosses itself"), std::string::npos)
        << warnings[0];
}

// What OSG's reader, which has buffers of 4,096 characters and indexes blindly, gets in its place.
TEST(ObjLines, ThePlainTextIsOneThatNoReaderGetsWrong)
{
    std::string text = "\xef\xbb\xbf" + kCorners + "vt 0 0\nvt 1 1\nvn 0 0 1\no " +
                       std::string(9000, 'x') + "\nusemtl re#d\nf 1/1/1 2/2/1 3/9/1 4//7\n";
    text += "l 1 2 3\np 4\nf 1 2\nmtllib nowhere.mtl\nf -1/-1 -2/x/1 -3//\n";
    const PlainObj plain = readPlainObj(written(text));
    const std::vector<std::string> faces = linesOf(plain.text, "f");
    ASSERT_EQ(faces.size(), 3U) << plain.text;
    EXPECT_EQ(faces[0], "f 1/1/1 2/2/1 4");
    EXPECT_EQ(faces[1], "f 2/2/1 3//1 4");
    EXPECT_EQ(faces[2], "f 4/2 3//1 2");
    EXPECT_EQ(linesOf(plain.text, "l"), (std::vector<std::string>{"l 1 2", "l 2 3"}));
    EXPECT_EQ(linesOf(plain.text, "p"), (std::vector<std::string>{"p 4"}));
    EXPECT_EQ(linesOf(plain.text, "usemtl"), (std::vector<std::string>{"usemtl re#d"}));
    EXPECT_TRUE(linesOf(plain.text, "mtllib").empty());
    std::istringstream in(plain.text);
    for (std::string line; std::getline(in, line);)
        EXPECT_LT(line.size(), 4096U);
    EXPECT_EQ(plain.origin, Eigen::Vector3d::Zero());
    EXPECT_EQ(plain.warnings.size(), 1U); // f 1 2
    EXPECT_EQ(plain.notes.size(), 1U);    // mtllib
}

TEST(ObjLines, MapCoordinatesKeepTheirDigits)
{
    const std::string square = "v 500000.025 4649776.025 100.5\nv 500000.075 4649776.025 100.5\n"
                               "v 500000.075 4649776.075 100.5\nv 500000.025 4649776.075 100.5\n"
                               "f 1 2 3 4\n";
    const Eigen::Vector3d extent = read(square).extent();
    EXPECT_NEAR(extent.x(), 0.05, 1e-9); // doubles at 5e6
    EXPECT_NEAR(extent.y(), 0.05, 1e-9);
    const PlainObj plain = readPlainObj(written(square));
    EXPECT_NEAR((plain.origin - Eigen::Vector3d(500000.05, 4649776.05, 100.5)).norm(), 0.0, 1e-8);
    std::istringstream first(linesOf(plain.text, "v").at(0).substr(2));
    Eigen::Vector3d corner;
    first >> corner.x() >> corner.y() >> corner.z();
    EXPECT_NEAR((corner - Eigen::Vector3d(-0.025, -0.025, 0.0)).norm(), 0.0, 1e-8);
    // What has its digits stays where it is.
    EXPECT_EQ(readPlainObj(written("v 1 1 0\nv 1.05 1 0\nv 1 1.05 0\nf 1 2 3\n")).origin,
              Eigen::Vector3d::Zero());
}

} // namespace midair::haptics
