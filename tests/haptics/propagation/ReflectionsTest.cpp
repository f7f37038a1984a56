// Reflectors in double precision, against integrals, geometry and mirrored arrays written apart.
#include "haptics/propagation/Reflections.h"

#include "haptics/propagation/ReferencePropagation.h"

#include <Eigen/Geometry>

#include <cmath>
#include <complex>
#include <random>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

using Complex = std::complex<double>;

constexpr double kWavelength_m = 8.58e-3;

Reflector plate(double width_m, double height_m)
{
    Reflector one;
    one.position = {0.01, -0.02, 0.1};
    one.normal = Eigen::Vector3d(0.2, -0.1, 1.0).normalized();
    one.along = one.normal.cross(Eigen::Vector3d(0.3, 1.0, 0.0)).normalized();
    one.size_m = {width_m, height_m};
    one.accuracy_mm = 0.2;
    return one;
}

class Places
{
public:
    Eigen::Vector3d next(double halfExtent_m)
    {
        std::uniform_real_distribution<double> uniform(-halfExtent_m, halfExtent_m);
        return {uniform(_random), uniform(_random), uniform(_random)};
    }

private:
    std::mt19937 _random{7};
};

// F(v) by Simpson's rule.
Complex integrated(double v)
{
    constexpr int kSteps = 200000;
    const double h = v / kSteps;
    const auto f = [](double u) { return std::polar(1.0, -0.5 * M_PI * u * u); };
    Complex sum = f(0.0) + f(v);
    for (int k = 1; k < kSteps; ++k)
        sum += f(k * h) * (k % 2 == 1 ? 4.0 : 2.0);
    return 0.5 + Complex(0.5, 0.5) * sum * h / 3.0;
}

// The share as the formula of the study reads: the path to the image of the point, or to the point
// itself, cut by the plane.
Complex shareByCut(const Reflector& one, const Eigen::Vector3d& t, const Eigen::Vector3d& x)
{
    const double hx = one.normal.dot(x - one.position), ht = one.normal.dot(t - one.position);
    const Eigen::Vector3d end = hx * ht > 0.0 ? Eigen::Vector3d(x - 2.0 * hx * one.normal) : x;
    const Eigen::ParametrizedLine<double, 3> line =
        Eigen::ParametrizedLine<double, 3>::Through(t, end);
    const Eigen::Hyperplane<double, 3> plane(one.normal, one.position);
    const Eigen::Vector3d hit = line.intersectionPoint(plane);
    const double r1 = (hit - t).norm(), r2 = (hit - end).norm();
    const Eigen::Vector3d across = one.normal.cross(one.along);
    Complex share = 1.0;
    for (int e = 0; e < 2; ++e)
    {
        const Eigen::Vector3d axis = e == 0 ? one.along : across;
        const double X = axis.dot(hit - one.position), cosine = axis.dot(line.direction());
        const double scale =
            std::sqrt(2.0 / kWavelength_m * (1.0 / r1 + 1.0 / r2) * (1.0 - cosine * cosine));
        share *= integrated((0.5 * one.size_m[e] - X) * scale) -
                 integrated((-0.5 * one.size_m[e] - X) * scale);
    }
    return share;
}

} // namespace

TEST(Reflections, ShareBeyondAnEdgeIsTheFresnelIntegral)
{
    for (const double v : {0.0, 0.3, 1.0, 1.5999, 1.6001, 2.5, 7.0, 20.0})
        for (const double sign : {1.0, -1.0})
            EXPECT_NEAR(std::abs(shareBeyondEdge(sign * v) - integrated(sign * v)), 0.0, 1e-11)
                << sign * v;
    EXPECT_EQ(shareBeyondEdge(0.0), Complex(0.5, 0.0));
    EXPECT_EQ(shareBeyondEdge(1e300), Complex(1.0, 0.0));
    EXPECT_EQ(shareBeyondEdge(-1e300), Complex(0.0, 0.0));
}

TEST(Reflections, ShareIsThatOfTheStudysFormula)
{
    const Reflector one = plate(0.2, 0.12);
    Places places;
    for (int k = 0; k < 40; ++k)
    {
        const Eigen::Vector3d t = places.next(0.2), x = places.next(0.2);
        EXPECT_NEAR(
            std::abs(shareTurned(one, t, x, kWavelength_m) - shareByCut(one, t, x)), 0.0, 1e-8)
            << k;
    }
}

TEST(Reflections, AreReciprocal)
{
    const std::vector<Reflector> all = {plate(0.2, 0.12), plate(0.05, 0.3)};
    Places places;
    for (int k = 0; k < 100; ++k)
    {
        const Eigen::Vector3d a = places.next(0.2), b = places.next(0.2);
        const auto entry = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to)
        {
            Complex sum = 0.0;
            forEachPath(
                all,
                from,
                to,
                kWavelength_m,
                [&](const Eigen::Vector3d& at)
                {
                    const double r = (at - from).norm();
                    return std::polar(1.0 / r, -2.0 * M_PI * r / kWavelength_m);
                },
                [&](const Complex& part, const Eigen::Vector3d&) { sum += part; });
            return sum;
        };
        const Complex there = entry(a, b);
        EXPECT_NEAR(std::abs(there - entry(b, a)), 0.0, 1e-5 * std::abs(there)) << k;
    }
}

TEST(Reflections, PlanesWithoutEndAreMirroredArrays)
{
    TransducerArray array = TransducerArray::singleBoard();
    const Medium medium;
    Reflector plane = plate(1.0, 1.0);
    plane.size_m.setConstant(Reflector::kEndless);
    plane.reflection = 0.7;
    plane.reflectionPhase_rad = 0.4;
    TransducerArray mirrored = array;
    const Eigen::Matrix3d turn =
        Eigen::Matrix3d::Identity() - 2.0 * plane.normal * plane.normal.transpose();
    mirrored.positions =
        (turn * (array.positions.colwise() - plane.position)).colwise() + plane.position;
    mirrored.normals = turn * array.normals;
    Eigen::Matrix3Xd points(3, 20);
    Places places;
    for (auto point : points.colwise()) // all below the plane
        point = Eigen::Vector3d(0.0, 0.0, 0.05) + places.next(0.02);
    const Eigen::MatrixXcd expected =
        referencePropagationMatrix(points, array, medium) +
        std::polar(0.7, 0.4) * referencePropagationMatrix(points, mirrored, medium);
    array.reflectors = {plane};
    const Eigen::MatrixXcd G = referencePropagationMatrix(points, array, medium);
    EXPECT_LT((G - expected).cwiseAbs().maxCoeff(), 1e-10 * expected.cwiseAbs().maxCoeff());

    // Mirror symmetry: a point and its image hear the same of both arrays together.
    array.reflectors.front().reflection = 1.0;
    array.reflectors.front().reflectionPhase_rad = 0.0;
    const Eigen::MatrixXcd before = referencePropagationMatrix(points, array, medium);
    TransducerArray other = mirrored;
    other.reflectors = array.reflectors;
    Eigen::Matrix3Xd images = points;
    for (auto point : images.colwise())
        point = plane.mirrored(Eigen::Vector3d(point));
    const Eigen::MatrixXcd behind = referencePropagationMatrix(images, other, medium);
    EXPECT_LT((before - behind).cwiseAbs().maxCoeff(), 1e-5 * before.cwiseAbs().maxCoeff());
}

TEST(Reflections, HaveNoJumpBesideTheRectangleAndAreFiniteEverywhere)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.reflectors = {plate(0.1, 0.06)};
    const Reflector& one = array.reflectors.front();
    const Medium medium;
    const auto at = [&](const Eigen::Vector3d& place)
    { return referencePropagationMatrix(place, array, medium).row(0).eval(); };
    for (const double beside_m : {0.051, 0.06, 0.1}) // from the centre; the edge is at 0.05
    {
        const Eigen::Vector3d place = one.position + beside_m * one.along;
        const auto front = at(place - 1e-11 * one.normal), back = at(place + 1e-11 * one.normal);
        EXPECT_LT((front - back).norm(), 2e-3 * front.norm()) << beside_m;
    }
    // The edge of the mirror and of the shadow.
    for (const double side_m : {-0.02, 0.02})
        for (double beside_m = 0.03; beside_m < 0.07; beside_m += 1e-3)
        {
            const Eigen::Vector3d place = one.position + beside_m * one.along + side_m * one.normal;
            const auto here = at(place), next = at(place + 1e-8 * one.along);
            EXPECT_LT((here - next).norm(), 1e-4 * here.norm() + 1e-9) << beside_m;
        }
    for (const Eigen::Vector3d& place : {one.position,
                                         Eigen::Vector3d(array.positions.col(0)),
                                         Eigen::Vector3d(one.position + 0.05 * one.along)})
        EXPECT_TRUE(at(place).allFinite());
    array.reflectors.front().position = array.positions.col(3);
    EXPECT_TRUE(at({0.0, 0.0, 0.1}).allFinite());
}

// The scattered wave of a rigid plate by physical optics: 2 p dG/dn over its face.
TEST(Reflections, AgreeWithPhysicalOpticsOfAPlate)
{
    const Reflector one = plate(0.08, 0.08);
    const double k = 2.0 * M_PI / kWavelength_m;
    const Eigen::Vector3d t = one.position - 0.4 * one.normal + 0.03 * one.along;
    constexpr int kCells = 120;
    double worst = 0.0;
    for (const double side : {-1.0, 1.0})
        for (const double beside_m : {-0.05, -0.03, 0.0, 0.02, 0.04})
        {
            const Eigen::Vector3d x =
                one.position + side * 0.3 * one.normal + beside_m * one.across();
            Complex integral = 0.0;
            const double cell = 0.08 / kCells;
            for (int a = 0; a < kCells; ++a)
                for (int b = 0; b < kCells; ++b)
                {
                    const Eigen::Vector3d y = one.position + (cell * (a + 0.5) - 0.04) * one.along +
                                              (cell * (b + 0.5) - 0.04) * one.across();
                    const Eigen::Vector3d d = x - y;
                    const double r = d.norm(), from = (y - t).norm();
                    // towards the source's side the scattered wave adds, behind it takes away
                    integral += 2.0 * std::polar(1.0 / from, -k * from) * Complex(1.0 / r, k) *
                                std::polar(1.0 / (4.0 * M_PI * r), -k * r) *
                                (-d.dot(one.normal) / r) * cell * cell;
                }
            const double way = (side < 0.0 ? (one.mirrored(x) - t).norm() : (x - t).norm());
            const Complex image = shareTurned(one, t, x, kWavelength_m) *
                                  std::polar(side < 0.0 ? 1.0 / way : -1.0 / way, -k * way);
            worst = std::max(worst, std::abs(image - integral) * way);
        }
    // Of the image's wave. Larger plates differ more, by up to a tenth: the ways by their edges are
    // longer than their parabola.
    EXPECT_LT(worst, 0.03);
    EXPECT_GT(worst, 1e-4);
}

TEST(Reflections, OfReflectionZeroAreTheFreeFieldToTheBit)
{
    TransducerArray array = TransducerArray::singleBoard();
    const Eigen::Vector3d point(0.01, 0.02, 0.15);
    const Eigen::MatrixXcd free = referencePropagationMatrix(point, array, Medium());
    array.reflectors = {plate(0.2, 0.2)};
    EXPECT_NE(referencePropagationMatrix(point, array, Medium()), free);
    array.reflectors.front().reflection = 0.0;
    EXPECT_EQ(referencePropagationMatrix(point, array, Medium()), free);
}

TEST(Reflections, PathsAddUpToTheEntry)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.reflectors = {plate(0.2, 0.2), plate(0.05, 0.1)};
    array.reflectors.back().position[2] = 0.2;
    const Eigen::Vector3d point(0.01, 0.02, 0.05);
    const Eigen::RowVectorXcd G = referencePropagationMatrix(point, array, Medium());
    Eigen::RowVectorXcd sum = Eigen::RowVectorXcd::Zero(array.size());
    const auto paths = referencePaths(point, array, Medium());
    EXPECT_EQ(paths.size(), 3U * static_cast<std::size_t>(array.size()));
    for (const SoundPath& path : paths)
    {
        sum[path.transducer] += path.entry;
        EXPECT_GE(path.length_m, (array.positions.col(path.transducer) - point).norm() - 1e-12);
    }
    EXPECT_LT((sum - G).cwiseAbs().maxCoeff(), 1e-12 * G.cwiseAbs().maxCoeff());
}
