#include "haptics/surface/ObjReader.h"

#include "haptics/base/InputError.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace midair::haptics
{

namespace
{

const char* const kStar = MIDAIR_ROOT "/samples/models/star.obj";

/// A file in the temporary folder for as long as the test runs.
class ObjReader : public testing::Test
{
protected:
    ObjReader() :
        _path(std::filesystem::path(testing::TempDir()) /
              (std::string("midair_obj_") +
               testing::UnitTest::GetInstance()->current_test_info()->name() + ".obj"))
    {
    }
    ~ObjReader() override { std::filesystem::remove(_path); }

    TriangleMesh read(const std::string& text)
    {
        std::ofstream(_path, std::ios::binary) << text;
        warnings.clear();
        return readObj(_path.string(), &warnings);
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
            EXPECT_EQ(what.rfind(_path.string(), 0), 0U) << what;
            return what.substr(_path.string().size());
        }
        return "no error";
    }

    std::vector<std::string> warnings;

    const std::filesystem::path& path() const { return _path; }

private:
    std::filesystem::path _path;
};

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

double area(const TriangleMesh& mesh)
{
    double sum = 0.0;
    for (const auto& t : mesh.triangles.colwise())
    {
        const Eigen::Vector3d a = mesh.vertices.col(t[0]);
        sum += 0.5 * (mesh.vertices.col(t[1]) - a).cross(mesh.vertices.col(t[2]) - a).norm();
    }
    return sum;
}

/// Signed, by the divergence theorem: positive for a closed mesh wound outwards.
double volume(const TriangleMesh& mesh)
{
    double sum = 0.0;
    for (const auto& t : mesh.triangles.colwise())
    {
        sum += mesh.vertices.col(t[0]).dot(mesh.vertices.col(t[1]).cross(mesh.vertices.col(t[2]))) /
               6.0;
    }
    return sum;
}

} // namespace

TEST_F(ObjReader, ReadsTheStar)
{
    std::vector<std::string> none;
    const TriangleMesh star = readObj(kStar, &none);
    EXPECT_TRUE(none.empty());
    EXPECT_EQ(star.vertices.cols(), 11);
    EXPECT_EQ(star.triangles.cols(), 18);
    EXPECT_EQ(star.intensity.size(), 0);
    EXPECT_DOUBLE_EQ(star.extent().x(), 0.12);
    EXPECT_EQ(star.extent().z(), 0.015);
    // Closed and wound consistently: each directed edge occurs once, with its opposite.
    Eigen::MatrixXi directed = Eigen::MatrixXi::Zero(11, 11);
    for (const auto& t : star.triangles.colwise())
    {
        for (int k = 0; k < 3; ++k)
            ++directed(t[k], t[(k + 1) % 3]);
    }
    EXPECT_EQ(directed.maxCoeff(), 1);
    EXPECT_EQ(directed, directed.transpose());
    // Outwards; a pyramid over the star: base area times a third of the height. 1e-6: the file's
    // six decimals.
    double base = 0.0;
    for (int i = 0; i < 10; ++i)
    {
        const Eigen::Vector3d a = star.vertices.col(i);
        const Eigen::Vector3d b = star.vertices.col((i + 1) % 10);
        base += 0.5 * (a.x() * b.y() - a.y() * b.x());
    }
    EXPECT_NEAR(volume(star), base * 0.015 / 3.0, 1e-12);
}

TEST_F(ObjReader, TriangulatesQuadsAndPolygons)
{
    const TriangleMesh quad = read(kSquare + "f 1 2 3 4\n");
    EXPECT_EQ(quad.triangles.cols(), 2);
    EXPECT_DOUBLE_EQ(area(quad), 1.0);

    // The star's outline as one concave decagon: 5 R r sin 36 degrees.
    std::string text;
    for (int i = 0; i < 10; ++i)
    {
        const double radius = i % 2 == 0 ? 1.0 : 0.4;
        std::ostringstream line;
        line << "v " << radius * std::cos(M_PI * i / 5) << " 2 " << radius * std::sin(M_PI * i / 5)
             << "\n";
        text += line.str();
    }
    const TriangleMesh star = read(text + "f 1 2 3 4 5 6 7 8 9 10\n");
    EXPECT_EQ(star.triangles.cols(), 8);
    EXPECT_NEAR(area(star), 10 * 0.5 * 0.4 * std::sin(M_PI / 5), 1e-5); // six digits written
    EXPECT_TRUE(warnings.empty());
}

TEST_F(ObjReader, CutsConcaveQuadsInside)
{
    // Arrow heads with the notch at each corner; the shorter diagonal of the flat one lies outside.
    for (int first = 0; first < 4; ++first)
    {
        for (const double notch : {-0.2, 0.8})
        {
            std::ostringstream text;
            const double corners[4][2] = {{0, 1}, {-0.3, -0.5}, {0, notch}, {0.3, -0.5}};
            for (const auto& corner : corners)
                text << "v " << corner[0] << " " << corner[1] << " 0\n";
            text << "f";
            for (int k = 0; k < 4; ++k)
                text << " " << (first + k) % 4 + 1;
            const TriangleMesh mesh = read(text.str() + "\n");
            ASSERT_EQ(mesh.triangles.cols(), 2);
            EXPECT_NEAR(area(mesh), 0.3 * (1.0 - notch), 1e-12) << first << " " << notch;
        }
    }
}

TEST_F(ObjReader, TriangulatesSmallPolygons)
{
    // A hexagon 0.2 mm across, in metres: areas near 1e-8 are not nothing.
    std::ostringstream text;
    text.precision(17);
    for (int i = 0; i < 6; ++i)
    {
        text << "v " << 1e-4 * std::cos(M_PI * i / 3) << " " << 1e-4 * std::sin(M_PI * i / 3)
             << " 0\n";
    }
    const TriangleMesh mesh = read(text.str() + "f 1 2 3 4 5 6\n");
    EXPECT_EQ(mesh.triangles.cols(), 4);
    EXPECT_NEAR(area(mesh), 1.5 * std::sqrt(3.0) * 1e-8, 1e-20);
}

TEST_F(ObjReader, TakesWhatExportersWrite)
{
    // Negative indices, missing normals and texture coordinates, carriage returns, comments,
    // several shapes, groups, smoothing, a folded line, lines and points, numbers in all spellings,
    // no newline at the end.
    const TriangleMesh mesh =
        read("# made by hand\r\nmtllib\r\no first\r\n"
             "v +0. 0 -0.0 \r\nv 1 .0 0\r\nv 1E0 1e+0 0.0e-5\r\nf -3//1 -2//1 -1//1 # tail\r\n"
             "g a b\r\ns off\r\nv 0 1 0 1.0\r\nvt 0.5 0.5\r\n"
             "o second\r\nf 1/1/9 3/1/9 \\\r\n 4/7\r\nl 1 2\r\np 3\r\nf 1 3 4");
    EXPECT_EQ(mesh.vertices.cols(), 4);
    ASSERT_EQ(mesh.triangles.cols(), 5); // with the line and the point, which come last
    EXPECT_EQ(mesh.triangles.col(0), Eigen::Vector3i(0, 1, 2));
    EXPECT_EQ(mesh.triangles.col(1), Eigen::Vector3i(0, 2, 3));
    EXPECT_EQ(mesh.vertices.col(2), Eigen::Vector3d(1, 1, 0));
    EXPECT_EQ(mesh.intensity.size(), 0);
    EXPECT_TRUE(warnings.empty());
}

TEST_F(ObjReader, TakesVerticesAfterTheirFaces)
{
    EXPECT_EQ(read("f 1 2 3\n" + kSquare).triangles.cols(), 1);
}

TEST_F(ObjReader, WarnsOfAMissingMaterialFile)
{
    const TriangleMesh mesh = read("mtllib not-there.mtl\n" + kSquare + "usemtl red\nf 1 2 3\n");
    EXPECT_EQ(mesh.triangles.cols(), 1);
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_EQ(
        warnings[0],
        path().string() +
            ", line 1: the material file \"not-there.mtl\" is not there; materials are not needed");
}

TEST_F(ObjReader, ReadsColoursAsIntensity)
{
    const TriangleMesh mesh =
        read("v 0 0 0 1 1 1\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0 0 0 0\nv 0 1 0 1 0.5 0\nf 1 2 3 4\n");
    ASSERT_EQ(mesh.intensity.size(), 4);
    EXPECT_EQ(mesh.intensity[0], 1.0F);
    EXPECT_EQ(mesh.intensity[1], 0.5F);
    EXPECT_EQ(mesh.intensity[2], 0.0F);
    EXPECT_EQ(mesh.intensity[3], 0.5F);
    EXPECT_TRUE(warnings.empty());
    // 0 .. 255 is something else.
    EXPECT_EQ(read("v 0 0 0 1 1 1\nv 1 0 0 255 0 0\nv 1 1 0 1 1 1\nf 1 2 3\n").intensity.size(), 0);
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_EQ(warnings[0],
              path().string() +
                  ", line 2: a vertex colour is outside 0 .. 1; colours are left out");
}

TEST_F(ObjReader, NamesFileAndLineOfWhatIsBroken)
{
    EXPECT_EQ(errorOf(""), ": the file is empty");
    EXPECT_EQ(errorOf("# nothing\n"), ": the file has no vertices");
    EXPECT_EQ(errorOf("\x7f"
                      "ELF\0\1\2\3"),
              ": the file has no vertices");
    EXPECT_EQ(errorOf(kSquare),
              ": the file has no faces, lines or points (4 vertices); there is nothing to feel");
    EXPECT_EQ(errorOf("f 1 2 3\n"), ": the file has no vertices");
    EXPECT_EQ(errorOf(kSquare + "f 1 2 5\n"),
              ", line 5: the face refers to vertex 5; the file has 4 vertices");
    EXPECT_EQ(errorOf(kSquare + "f 1 2 -5\n"),
              ", line 5: face corner \"-5\" counts back beyond the first of the 4 vertices so far");
    EXPECT_EQ(errorOf(kSquare + "f 1 2 0\n"), ", line 5: face corner \"0\": indices count from 1");
    EXPECT_EQ(errorOf(kSquare + "f 1 2 99999999999999999999\n"),
              ", line 5: face corner \"99999999999999999999\" is out of range");
    EXPECT_EQ(errorOf(kSquare + "f 1 2 4294967297\n"),
              ", line 5: the face refers to vertex 4294967297; the file has 4 vertices");
    EXPECT_EQ(errorOf(kSquare + "f 1 two 3\n"),
              ", line 5: face corner \"two\" is not a vertex index");
    EXPECT_EQ(errorOf(kSquare + "f 1 2.5 3\n"),
              ", line 5: face corner \"2.5\" is not a vertex index");
    EXPECT_EQ(errorOf(kSquare + "f 1 /1 3\n"),
              ", line 5: face corner \"/1\" is not a vertex index");
    EXPECT_EQ(errorOf(kSquare + "\nf 1 2\n"),
              ", line 6: the face has 2 corners; it needs 3 or more");
    EXPECT_EQ(errorOf("v 0 0\n"), ", line 1: vertex 1 has 2 coordinates; it needs 3");
    EXPECT_EQ(errorOf("v 0 0 0\nv 1 nan 0\n"),
              ", line 2: vertex 2 has the coordinate \"nan\"; it must be finite");
    EXPECT_EQ(errorOf("v 0 0 0\nv 1 0 -inf\n"),
              ", line 2: vertex 2 has the coordinate \"-inf\"; it must be finite");
    EXPECT_EQ(errorOf("v 0 0 0\nv 1 0 1e999\n"),
              ", line 2: vertex coordinate \"1e999\" is too large");
    EXPECT_EQ(errorOf("v 0 0 0\nv 1 0 1,5\n"), ", line 2: \"1,5\" is not a number");
    EXPECT_EQ(errorOf("v 0 0 0\nv 1 0 0x10\n"), ", line 2: \"0x10\" is not a number");
    EXPECT_EQ(errorOf("v 0 0 0\nv 1 0 1 red 0 0\n"), ", line 2: \"red\" is not a number");
}

TEST_F(ObjReader, NamesFilesThatArentThere)
{
    for (const std::string& name : {std::string("/no/such/folder/mesh.obj"), std::string("")})
    {
        try
        {
            readObj(name);
            FAIL() << "no error";
        }
        catch (const base::InputError& error)
        {
            EXPECT_EQ(std::string(error.what()),
                      name + ": can't be read: No such file or directory");
        }
    }
    try
    {
        readObj(testing::TempDir());
        FAIL() << "no error";
    }
    catch (const base::InputError& error)
    {
        EXPECT_EQ(std::string(error.what()), testing::TempDir() + ": this is a folder, not a file");
    }
}

TEST_F(ObjReader, SurvivesMutations)
{
    std::ifstream stream(kStar, std::ios::binary);
    const std::string star((std::istreambuf_iterator<char>(stream)),
                           std::istreambuf_iterator<char>());
    std::mt19937 random(20150622); // any fixed seed
    const std::string alphabet = "0123456789-+.eEvfg#/\\ \n\t\r\0nai\xff";
    int readable = 0;
    int refused = 0;
    for (int i = 0; i < 500; ++i)
    {
        std::string text = star;
        for (unsigned k = random() % 6 + 1; k > 0 && !text.empty(); --k)
        {
            const std::size_t at = random() % text.size();
            switch (random() % 4)
            {
            case 0:
                text[at] = alphabet[random() % alphabet.size()];
                break;
            case 1:
                text.insert(at, 1, alphabet[random() % alphabet.size()]);
                break;
            case 2:
                text.erase(at, random() % 8);
                break;
            default:
                text.insert(at, text.substr(random() % text.size(), random() % 40));
            }
        }
        if (i % 50 == 0) text.resize(random() % text.size());
        try
        {
            const TriangleMesh mesh = read(text);
            ASSERT_TRUE(mesh.vertices.allFinite());
            ASSERT_GT(mesh.triangles.cols(), 0);
            ASSERT_GE(mesh.triangles.minCoeff(), 0);
            ASSERT_LT(mesh.triangles.maxCoeff(), mesh.vertices.cols());
            ++readable;
        }
        catch (const base::InputError& error)
        {
            ASSERT_NE(std::string(error.what()).find(path().string()), std::string::npos);
            ++refused;
        }
    }
    // Both ways are gone.
    EXPECT_GT(readable, 50);
    EXPECT_GT(refused, 50);
}

TEST(TriangleMesh, KnowsItsExtent)
{
    EXPECT_EQ(TriangleMesh().extent(), Eigen::Vector3d::Zero());
    TriangleMesh mesh;
    mesh.vertices.resize(3, 2);
    mesh.vertices << 1, 4, 2, 0, 5, 5;
    EXPECT_EQ(mesh.extent(), Eigen::Vector3d(3, 2, 0));
}

TEST(TriangleMesh, ScalesToASize)
{
    const TriangleMesh star = readObj(kStar).scaledTo(0.08);
    EXPECT_NEAR(star.extent().maxCoeff(), 0.08, 1e-16);
    // Centred: both ends of each axis are as far out, up to rounding.
    EXPECT_LT((star.vertices.rowwise().minCoeff() + star.vertices.rowwise().maxCoeff()).norm(),
              1e-16);
    EXPECT_EQ(star.triangles.cols(), 18);
}

TEST(TriangleMesh, RefusesToScaleNothing)
{
    const auto errorOf = [](const TriangleMesh& mesh, double size)
    {
        try
        {
            mesh.scaledTo(size);
        }
        catch (const base::InputError& error)
        {
            return std::string(error.what());
        }
        return std::string("no error");
    };
    TriangleMesh mesh = readObj(kStar);
    EXPECT_EQ(errorOf(mesh, 0.0),
              "The size to scale a mesh to is 0 m; it must be positive and finite");
    EXPECT_EQ(errorOf(mesh, std::nan("")),
              "The size to scale a mesh to is nan m; it must be positive and finite");
    EXPECT_EQ(errorOf(TriangleMesh(), 0.1), "A mesh without vertices can't be scaled");
    mesh.vertices(0, 3) = std::nan("");
    EXPECT_EQ(errorOf(mesh, 0.1), "Vertex 3 of the mesh is not finite; the mesh can't be scaled");
    mesh.vertices.setConstant(2.0);
    EXPECT_EQ(errorOf(mesh, 0.1), "All vertices of the mesh lie in one point; it can't be scaled");
}

} // namespace midair::haptics
