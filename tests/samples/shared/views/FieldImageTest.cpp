#include "samples/shared/views/FieldImage.h"

#include "haptics/surface/ObjReader.h"
#include "samples/shared/views/Offscreen.h"

#include <osgMidair/ColorMap>

#include <osgDB/ReadFile>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

using namespace midair;

namespace
{

std::string temporary(const std::string& name)
{
    return (std::filesystem::temp_directory_path() /
            ("midair_" + std::to_string(::getpid()) + "_" + name))
        .string();
}

/// A bump of 1000 Pa at (20, 10) mm of a slice of 100 x 80 mm in the plane z = 0.
osgMidair::FieldPicture bump()
{
    haptics::FieldGrid grid;
    grid.corner = Eigen::Vector3d(-0.05, -0.04, 0.0);
    grid.u = Eigen::Vector3d(0.1, 0.0, 0.0);
    grid.v = Eigen::Vector3d(0.0, 0.08, 0.0);
    grid.columns = 101;
    grid.rows = 81;
    const Eigen::Matrix3Xd places = grid.points();
    Eigen::VectorXf pressure_Pa(places.cols());
    for (Eigen::Index i = 0; i < places.cols(); ++i)
        pressure_Pa[i] = static_cast<float>(
            1000.0 *
            std::exp(-(places.col(i) - Eigen::Vector3d(0.02, 0.01, 0.0)).squaredNorm() / 1e-4));
    osgMidair::FieldPicture picture = samples::fieldPicture(grid, pressure_Pa);
    picture.title = "bump";
    return picture;
}

/// Pixels of \a image that are within \a tolerance (0 .. 1) of \a color, and the middle of the box
/// round them.
int count(const osg::Image& image, const osg::Vec3f& color, float tolerance, osg::Vec2& middle)
{
    int found = 0;
    osg::Vec2 low(1e6F, 1e6F);
    osg::Vec2 high(-1e6F, -1e6F);
    for (int y = 0; y < image.t(); ++y)
        for (int x = 0; x < image.s(); ++x)
        {
            const osg::Vec4 pixel = image.getColor(x, y);
            if ((osg::Vec3f(pixel.r(), pixel.g(), pixel.b()) - color).length() > tolerance)
                continue;
            ++found;
            low.set(std::min(low.x(), 1.0F * x), std::min(low.y(), 1.0F * y));
            high.set(std::max(high.x(), 1.0F * x), std::max(high.y(), 1.0F * y));
        }
    middle = (low + high) / 2.0F;
    return found;
}

/// The length of all segments together, m.
double lengthOf(const std::vector<osg::Vec3d>& segments)
{
    double length = 0.0;
    for (std::size_t s = 0; s + 1 < segments.size(); s += 2)
        length += (segments[s + 1] - segments[s]).length();
    return length;
}

haptics::TriangleMesh square()
{
    haptics::TriangleMesh mesh;
    mesh.vertices.resize(3, 4);
    mesh.vertices << 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0;
    mesh.triangles.resize(3, 2);
    mesh.triangles << 0, 0, 1, 2, 2, 3;
    return mesh;
}

} // namespace

TEST(FieldImage, ShowsTheFieldWhereItIs)
{
    std::string message;
    const std::string path = temporary("bump.png");
    ASSERT_TRUE(samples::writeFieldPicture(path, bump(), message)) << message;
    const osg::ref_ptr<osg::Image> image = osgDB::readRefImageFile(path);
    std::filesystem::remove(path);
    ASSERT_TRUE(image.valid());
    if (!message.empty()) GTEST_SKIP() << message;
    // The largest pressure is yellow: once in the slice, once at the top of the scale, which the
    // left part leaves out.
    osg::ref_ptr<osg::Image> slice = new osg::Image;
    const int width = image->s() - 140;
    slice->allocateImage(width, image->t(), 1, GL_RGB, GL_UNSIGNED_BYTE, 1);
    for (int y = 0; y < image->t(); ++y)
        for (int x = 0; x < width; ++x)
            slice->setColor(image->getColor(x, y), x, y);
    osg::Vec2 peak;
    osg::Vec2 quiet;
    EXPECT_GT(count(*slice, osgMidair::ColorMap::pressure().color(1.0F), 0.08F, peak), 50);
    const int quietPixels =
        count(*slice, osgMidair::ColorMap::pressure().color(0.0F), 0.05F, quiet);
    EXPECT_GT(quietPixels, 100000);
    // 6.2 pixels a mm; the slice's corners are quiet, so the box round what is quiet is the slice.
    // Yellow spreads over 2 mm.
    EXPECT_NEAR(peak.x() - quiet.x(), 20.0F * 6.2F, 4.0F);
    EXPECT_NEAR(peak.y() - quiet.y(), 10.0F * 6.2F, 4.0F);
}

TEST(FieldImage, WithoutOpenGlItIsWrittenWithoutText)
{
    const std::string path = temporary("plain.png");
    // In a process of its own, since OpenGL's vendors are looked up once.
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(
        {
            ::setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent.json", 1);
            std::string message;
            const bool written = samples::writeFieldPicture(path, bump(), message);
            std::fprintf(stderr, "%s", message.c_str());
            std::exit(written ? 0 : 1);
        },
        ::testing::ExitedWithCode(0),
        "plain.png .*no OpenGL without a display: ");
    const osg::ref_ptr<osg::Image> image = osgDB::readRefImageFile(path);
    if (!image) // the child has another process id
        for (const auto& entry :
             std::filesystem::directory_iterator(std::filesystem::temp_directory_path()))
            if (entry.path().filename().string().find("_plain.png") != std::string::npos)
                std::filesystem::remove(entry.path());
    std::filesystem::remove(path);
}

TEST(FieldImage, SaysWhatDoesNotFit)
{
    osgMidair::FieldPicture image = bump();
    std::string message;
    image.pressures_Pa.resize(7);
    EXPECT_FALSE(samples::writeFieldPicture(temporary("x.png"), image, message));
    EXPECT_EQ(message, "a field image of 101 x 81 samples was given 7 pressures");
    image.rows = 1;
    EXPECT_FALSE(samples::writeFieldPicture(temporary("x.png"), image, message));
    EXPECT_EQ(message, "a field image needs at least 2 x 2 samples, not 101 x 1");
    image = bump();
    image.pressures_Pa[3] = std::nanf("");
    EXPECT_FALSE(samples::writeFieldPicture(temporary("x.png"), image, message));
    EXPECT_EQ(message, "a field image was given pressures that are not finite");
    EXPECT_FALSE(samples::writeFieldPicture("/nonexistent/field.png", bump(), message));
    EXPECT_EQ(
        message,
        "can't write the picture /nonexistent/field.png (is the folder there, and is it a .png?)");
}

TEST(BestSlice, LiesInTheObjectsPlane)
{
    haptics::ControlPoints points;
    points.positions.resize(3, 5);
    // A tilted square of 40 mm with one point raised: the plane stays with the four.
    const Eigen::Vector3d u = Eigen::Vector3d(1.0, 0.3, 0.0).normalized();
    const Eigen::Vector3d normal = Eigen::Vector3d(-0.3, 1.0, 0.2).normalized();
    const Eigen::Vector3d n = (normal - normal.dot(u) * u).normalized();
    const Eigen::Vector3d v = n.cross(u);
    const Eigen::Vector3d centre(0.01, 0.02, -0.01);
    int k = 0;
    for (const double a : {-0.02, 0.02})
        for (const double b : {-0.02, 0.02})
            points.positions.col(k++) = centre + a * u + b * v;
    points.positions.col(4) = centre + 0.004 * n;
    const haptics::FieldGrid grid = samples::bestSlice(points, 0.02, 1e-3);
    const Eigen::Vector3d across = grid.u.cross(grid.v).normalized();
    EXPECT_NEAR(std::abs(across.dot(n)), 1.0, 1e-9);
    for (int l = 0; l < 4; ++l)
        EXPECT_NEAR(across.dot(points.positions.col(l) - grid.corner), 0.0, 1e-9);
    EXPECT_NEAR(grid.u.dot(grid.v), 0.0, 1e-12);
    // Samples 1 mm apart along both edges.
    EXPECT_NEAR(grid.u.norm() / (grid.columns - 1), 1e-3, 2e-5);
    EXPECT_NEAR(grid.v.norm() / (grid.rows - 1), 1e-3, 2e-5);
}

TEST(BestSlice, WithoutPointsItIsTheMiddle)
{
    const haptics::FieldGrid grid = samples::bestSlice({}, 0.05, 1e-3);
    EXPECT_LT((grid.corner - Eigen::Vector3d(-0.05, 0.0, -0.05)).norm(), 1e-12);
    EXPECT_EQ(grid.columns, 101);
    EXPECT_EQ(grid.rows, 101);
}

TEST(Outline, OfWhatLiesInThePlaneAndOfWhatCrossesIt)
{
    haptics::FieldGrid grid;
    grid.corner = Eigen::Vector3d(-1.0, -1.0, 0.0);
    grid.u = Eigen::Vector3d(3.0, 0.0, 0.0);
    grid.v = Eigen::Vector3d(0.0, 3.0, 0.0);
    // In the plane: the four sides and not the diagonal.
    const std::vector<osg::Vec3d> sides =
        samples::outlineInPlane(square(), Eigen::Isometry3d::Identity(), grid);
    EXPECT_EQ(sides.size(), 8U);
    EXPECT_NEAR(lengthOf(sides), 4.0, 1e-12);
    // Upright across it, a third above the middle: one line of length 1, in two pieces.
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(Eigen::Vector3d(0.0, 0.5, -0.3));
    pose.rotate(Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitX()));
    const std::vector<osg::Vec3d> cut = samples::outlineInPlane(square(), pose, grid);
    ASSERT_EQ(cut.size(), 4U);
    EXPECT_NEAR(lengthOf(cut), 1.0, 1e-12);
    for (const osg::Vec3d& end : cut)
    {
        EXPECT_NEAR(end.y(), 0.5, 1e-12);
        EXPECT_NEAR(end.z(), 0.0, 1e-12);
    }
    // Above it: nothing.
    pose.translation().z() = 2.0;
    EXPECT_TRUE(samples::outlineInPlane(square(), pose, grid).empty());
}

// Of a closed solid each edge has two faces, and rounding puts its flat back on either side of the
// plane: all ten edges of the star are there, once each, wherever it stands.
TEST(Outline, OfAClosedSolidHasAllEdgesOfItsFlatSide)
{
    const haptics::TriangleMesh star =
        haptics::readObj(MIDAIR_ROOT "/samples/models/star.obj").scaledTo(0.038);
    ASSERT_EQ(star.vertices.cols(), 11);
    double around = 0.0;
    for (int k = 0; k < 10; ++k)
        around += (star.vertices.col(k) - star.vertices.col((k + 1) % 10)).norm();
    for (int turn = 0; turn < 24; ++turn)
    {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translate(Eigen::Vector3d(0.003 * turn, -0.01, 0.002 * turn));
        pose.rotate(
            Eigen::AngleAxisd(0.3 * turn, Eigen::Vector3d(1.0, 0.2 * turn, -0.5).normalized()));
        haptics::ControlPoints points;
        points.positions = pose * star.vertices;
        const haptics::FieldGrid grid = samples::bestSlice(points, 0.02, 1e-3);
        const std::vector<osg::Vec3d> outline = samples::outlineInPlane(star, pose, grid);
        EXPECT_EQ(outline.size(), 20U) << turn;
        EXPECT_NEAR(lengthOf(outline), around, 1e-9) << turn;
    }
}

// Between its flat back and its ridge ten faces are cut; a corner in the plane is one end of two
// cuts.
TEST(Outline, CutsFacesAlsoAtACorner)
{
    const haptics::TriangleMesh star = haptics::readObj(MIDAIR_ROOT "/samples/models/star.obj");
    haptics::FieldGrid grid;
    grid.corner = Eigen::Vector3d(-0.1, -0.1, 0.0075);
    grid.u = Eigen::Vector3d(0.2, 0.0, 0.0);
    grid.v = Eigen::Vector3d(0.0, 0.2, 0.0);
    EXPECT_EQ(samples::outlineInPlane(star, Eigen::Isometry3d::Identity(), grid).size(), 20U);
    // Upright through the ridge and the uppermost tip, x = 0: the closed line round a triangle,
    // whose lower side is in two pieces, and the upper ones are edges.
    grid.corner = Eigen::Vector3d(0.0, -0.1, -0.1);
    grid.u = Eigen::Vector3d(0.0, 0.2, 0.0);
    grid.v = Eigen::Vector3d(0.0, 0.0, 0.2);
    const std::vector<osg::Vec3d> upright =
        samples::outlineInPlane(star, Eigen::Isometry3d::Identity(), grid);
    const double up = 0.063088, low = 0.024097, high = 0.015;
    EXPECT_NEAR(lengthOf(upright), up + low + std::hypot(up, high) + std::hypot(low, high), 1e-5);
    for (const osg::Vec3d& end : upright)
        EXPECT_NEAR(end.x(), 0.0, 2e-5);
}
