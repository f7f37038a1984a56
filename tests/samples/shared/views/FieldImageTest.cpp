#include "samples/shared/views/FieldImage.h"

#include "samples/shared/views/Offscreen.h"

#include <osgMidair/ColorMap>

#include <osgDB/ReadFile>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

using namespace midair;
using samples::FieldImage;

namespace
{

std::string temporary(const std::string& name)
{
    return (std::filesystem::temp_directory_path() /
            ("midair_" + std::to_string(::getpid()) + "_" + name))
        .string();
}

/// A bump of 1000 Pa at (20, 10) mm of a slice of 100 x 80 mm in the plane z = 0.
FieldImage bump()
{
    FieldImage image;
    image.grid.corner = Eigen::Vector3d(-0.05, -0.04, 0.0);
    image.grid.u = Eigen::Vector3d(0.1, 0.0, 0.0);
    image.grid.v = Eigen::Vector3d(0.0, 0.08, 0.0);
    image.grid.columns = 101;
    image.grid.rows = 81;
    const Eigen::Matrix3Xd places = image.grid.points();
    image.pressure_Pa.resize(places.cols());
    for (Eigen::Index i = 0; i < places.cols(); ++i)
        image.pressure_Pa[i] = std::polar(
            static_cast<float>(
                1000.0 *
                std::exp(-(places.col(i) - Eigen::Vector3d(0.02, 0.01, 0.0)).squaredNorm() / 1e-4)),
            static_cast<float>(i));
    image.title = "bump";
    return image;
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
    ASSERT_TRUE(samples::writeFieldImage(path, bump(), &message)) << message;
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
            const bool written = samples::writeFieldImage(path, bump(), &message);
            std::fprintf(stderr, "%s", message.c_str());
            std::exit(written ? 0 : 1);
        },
        ::testing::ExitedWithCode(0),
        "plain.png has no axes and no text: no OpenGL without a display: ");
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
    FieldImage image = bump();
    std::string message;
    image.pressure_Pa.conservativeResize(7);
    EXPECT_FALSE(samples::writeFieldImage(temporary("x.png"), image, &message));
    EXPECT_EQ(message, "a field image of 101 x 81 samples was given 7 pressures");
    image.grid.rows = 1;
    EXPECT_FALSE(samples::writeFieldImage(temporary("x.png"), image, &message));
    EXPECT_EQ(message, "a field image needs at least 2 x 2 samples, not 101 x 1");
    image = bump();
    image.pressure_Pa[3] = std::nanf("");
    EXPECT_FALSE(samples::writeFieldImage(temporary("x.png"), image, &message));
    EXPECT_EQ(message, "a field image was given pressures that are not finite");
    EXPECT_FALSE(samples::writeFieldImage("/nonexistent/field.png", bump(), &message));
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
    const Eigen::Matrix3Xd sides =
        samples::outlineInPlane(square(), Eigen::Isometry3d::Identity(), grid);
    ASSERT_EQ(sides.cols(), 8);
    double length = 0.0;
    for (int s = 0; s < 8; s += 2)
        length += (sides.col(s + 1) - sides.col(s)).norm();
    EXPECT_NEAR(length, 4.0, 1e-12);
    // Upright across it, a third above the middle: one line of length 1, in two pieces.
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(Eigen::Vector3d(0.0, 0.5, -0.3));
    pose.rotate(Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitX()));
    const Eigen::Matrix3Xd cut = samples::outlineInPlane(square(), pose, grid);
    ASSERT_EQ(cut.cols(), 4);
    EXPECT_NEAR((cut.col(1) - cut.col(0)).norm() + (cut.col(3) - cut.col(2)).norm(), 1.0, 1e-12);
    for (int i = 0; i < 4; ++i)
    {
        EXPECT_NEAR(cut(1, i), 0.5, 1e-12);
        EXPECT_NEAR(cut(2, i), 0.0, 1e-12);
    }
    // Above it: nothing.
    pose.translation().z() = 2.0;
    EXPECT_EQ(samples::outlineInPlane(square(), pose, grid).cols(), 0);
}
