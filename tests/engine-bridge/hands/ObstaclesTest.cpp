#include "engine-bridge/hands/Obstacles.h"

#include "haptics/base/InputError.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr double kWavelength = 8.58e-3;

/// (1 + j)/2 integral from \a v of e^{-j pi t^2/2}, by the midpoint rule; the far end fades out so
/// that it doesn't ring.
std::complex<double> integrated(double v)
{
    const double end = 14.0;
    const double step = 2e-4;
    std::complex<double> sum = 0.0;
    for (double t = v + 0.5 * step; t < end; t += step)
    {
        const double fade = t < 7.0 ? 1.0 : 0.5 + 0.5 * std::cos(M_PI * (t - 7.0) / 7.0);
        sum += fade * std::polar(step, -0.5 * M_PI * t * t);
    }
    return std::complex<double>(0.5, 0.5) * sum;
}

TEST(Fresnel, KnifeEdgeIsTheIntegral)
{
    for (const double v : {-4.0, -2.0, -1.2, -0.5, 0.0, 0.3, 1.0, 2.4, 5.0})
        EXPECT_LT(std::abs(knifeEdge(v) - integrated(v)), 4e-3)
            << v; // f and g are each good to 2e-3
    EXPECT_NEAR(std::abs(knifeEdge(0.0)), 0.5, 1e-12);
    EXPECT_NEAR(20.0 * std::log10(std::abs(knifeEdge(1.0))), -13.9, 0.1); // ITU-R P.526, figure 9
}

TEST(Fresnel, RectangleBlocksByBabinet)
{
    EXPECT_NEAR(pastRectangle(0.0, 1e3, -1e3, 1e3), 0.5, 1e-3); // a half-plane that touches the way
    EXPECT_LT(pastRectangle(-50.0, 50.0, -50.0, 50.0), 0.02);   // a wall
    // On the axis of a strip both sides arrive in phase: twice one edge.
    EXPECT_NEAR(pastRectangle(-1.0, 1.0, -1e3, 1e3), 2.0 * std::abs(integrated(1.0)), 5e-3);
    EXPECT_EQ(pastRectangle(kLit, 2.0, -1e3, 1e3), 1.0);
    EXPECT_NEAR(
        pastRectangle(kLit - 1e-6, 1e3, -1e3, 1e3), 1.0, 1e-9); // no jump at the edge of light
    // Small things cast no shadow: what is taken away is about their area in Fresnel zones.
    EXPECT_NEAR(pastRectangle(-0.05, 0.05, -0.05, 0.05), 1.0, 0.01);
}

/// Amplitude behind a rectangle by the Huygens sum over the open part of its plane (Fresnel's
/// approximation not made).
double huygens(const Vector3d& source,
               const Vector3d& point,
               double z,
               double x1,
               double x2,
               double y1,
               double y2)
{
    const double k = 2.0 * M_PI / kWavelength;
    const double step = 1.5e-3;
    const auto wave = [&](double x, double y)
    {
        const Vector3d spot(x, y, z);
        const double r1 = (spot - source).norm();
        const double r2 = (point - spot).norm();
        return std::polar(1.0 / (r1 * r2), -k * (r1 + r2));
    };
    // What the rectangle blocks, over what an open plane lets through (known: the direct wave times
    // lambda j).
    std::complex<double> blocked = 0.0;
    const int nx = static_cast<int>(std::ceil((x2 - x1) / step));
    const int ny = static_cast<int>(std::ceil((y2 - y1) / step));
    for (int i = 0; i < nx; ++i)
        for (int j = 0; j < ny; ++j)
            blocked += wave(x1 + (i + 0.5) * (x2 - x1) / nx, y1 + (j + 0.5) * (y2 - y1) / ny) *
                       ((x2 - x1) / nx * (y2 - y1) / ny);
    const double r = (point - source).norm();
    const std::complex<double> open =
        std::polar(1.0 / r, -k * r) * std::complex<double>(0.0, -kWavelength);
    return std::abs(1.0 - blocked / open);
}

TEST(Obstacles, FingerAcrossTheWayIsHuygensRectangle)
{
    const Vector3d source(0, 0, 0.23);
    const Vector3d point(0, 0, 0);
    for (const double z : {0.04, 0.08})
        for (const double x : {0.0, 0.004, 0.008, 0.012})
        {
            const Capsule finger = {Vector3d(x, -0.025, z), Vector3d(x, 0.03, z), 0.008};
            const double weight = shadowWeight(source, point, finger, kWavelength);
            const double summed =
                std::min(1.0, huygens(source, point, z, x - 0.008, x + 0.008, -0.033, 0.038));
            EXPECT_NEAR(weight, summed, 0.06)
                << z << " " << x; // Fresnel's approximation at tens of degrees
        }
}

TEST(Obstacles, FarOffTheWayNothingIsLost)
{
    const Capsule finger = {Vector3d(0.05, -0.03, 0.1), Vector3d(0.05, 0.03, 0.1), 0.008};
    EXPECT_EQ(shadowWeight(Vector3d(0, 0, 0.23), Vector3d(0, 0, 0), finger, kWavelength), 1.0);
    const Capsule behindTheArray = {Vector3d(-0.03, 0, 0.3), Vector3d(0.03, 0, 0.3), 0.03};
    EXPECT_EQ(shadowWeight(Vector3d(0, 0, 0.23), Vector3d(0, 0, 0), behindTheArray, kWavelength),
              1.0);
    const Capsule behindThePoint = {Vector3d(-0.03, 0, -0.03), Vector3d(0.03, 0, -0.03), 0.008};
    EXPECT_EQ(shadowWeight(Vector3d(0, 0, 0.23), Vector3d(0, 0, 0), behindThePoint, kWavelength),
              1.0);
}

TEST(Obstacles, AHandsBreadthIsDarkAndWeightsAreSoft)
{
    const Capsule arm = {Vector3d(0, -0.2, 0.05), Vector3d(0, 0.2, 0.05), 0.04};
    EXPECT_LT(shadowWeight(Vector3d(0, 0, 0.23), Vector3d(0, 0, 0), arm, kWavelength), 0.15);
    // From the dark to the light there is no step: the arm moved aside by tenths of a millimetre.
    double last = 0.0;
    for (double x = 0.0; x < 0.08; x += 1e-4)
    {
        const Capsule aside = {Vector3d(x, -0.2, 0.05), Vector3d(x, 0.2, 0.05), 0.04};
        const double weight =
            shadowWeight(Vector3d(0, 0, 0.23), Vector3d(0, 0, 0), aside, kWavelength);
        EXPECT_GE(weight, 0.0);
        EXPECT_LE(weight, 1.0);
        if (x > 0.0)
        {
            EXPECT_LT(std::abs(weight - last), 0.02) << x;
        }
        last = weight;
    }
    EXPECT_EQ(last, 1.0);
}

TEST(Obstacles, SkinIsLitFromItsOwnSideOnly)
{
    const Capsule finger = {Vector3d(-0.03, 0, 0), Vector3d(0.03, 0, 0), 0.008};
    const Vector3d inside(0, 0, 0.005); // felt on the skin at z = 8 mm
    double last = 1.0;
    for (int hundredths = 0; hundredths <= 18000; ++hundredths)
    {
        const double degrees = 0.01 * hundredths;
        const double angle =
            degrees * M_PI / 180.0; // from straight above the skin, round the finger
        const Vector3d source(0, 0.23 * std::sin(angle), 0.008 + 0.23 * std::cos(angle));
        const double weight = shadowWeight(source, inside, finger, kWavelength);
        if (degrees < 30)
        {
            EXPECT_GT(weight, 0.95) << degrees;
        }
        if (hundredths == 9000)
        {
            EXPECT_NEAR(weight, 0.5, 0.05);
        }
        EXPECT_LT(std::abs(weight - last), 0.015) << degrees; // no step, not at the horizon either
        last = weight;
    }
    EXPECT_LT(last, 0.35); // from below, round an 8 mm finger, which is thin against the wave
}

/// A dome of \a count transducers 230 mm round the origin.
haptics::TransducerArray dome(int count)
{
    haptics::TransducerArray array;
    array.positions.resize(3, count);
    for (int i = 0; i < count; ++i)
    {
        const double z = 1.0 - 1.6 * (i + 0.5) / count;
        const double phi = 2.399963 * i;
        const double ring = std::sqrt(1.0 - z * z);
        array.positions.col(i) = 0.23 * Vector3d(ring * std::cos(phi), ring * std::sin(phi), z);
    }
    array.normals = -array.positions / 0.23;
    return array;
}

Eigen::Matrix3Xd points(int count)
{
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> uniform(-0.03, 0.03);
    Eigen::Matrix3Xd result(3, count);
    for (int l = 0; l < count; ++l)
        result.col(l) = Vector3d(uniform(random), uniform(random), uniform(random));
    return result;
}

std::vector<Capsule> hand()
{
    HandFrame frame;
    Eigen::Isometry3d palm = Eigen::Isometry3d::Identity();
    palm.translation() = Vector3d(0, 0.05, 0.06);
    frame.hands.push_back(openHand(1, palm));
    std::vector<Capsule> result;
    for (const HandCapsule& capsule : handCapsules(frame))
        result.push_back(capsule.shape);
    return result;
}

TEST(Obstacles, CulledGainsAreThoseOfEveryWay)
{
    const haptics::TransducerArray array = dome(400);
    const Eigen::Matrix3Xd spots = points(6);
    const Eigen::MatrixXd weights = shadowWeights(spots, array, hand(), kWavelength);
    ShadowOptions options;
    options.wavelength_m = kWavelength;
    options.maxTests = 1000000;
    ShadowCounters counters;
    const Eigen::VectorXd gains = shadowGains(spots, array, hand(), options, &counters);
    const Eigen::VectorXd expected = weights.cwiseAbs2().colwise().mean().cwiseSqrt().transpose();
    EXPECT_LT((gains - expected).cwiseAbs().maxCoeff(),
              1e-12); // culling leaves out what weighs 1, exactly
    EXPECT_EQ(counters.spots, 6);
    EXPECT_EQ(counters.pairs, 6L * 400 * kHandBones);
    EXPECT_LT(counters.tested, counters.pairs / 2);
    EXPECT_LT(gains.minCoeff(), 0.5); // the hand does cast a shadow
    EXPECT_EQ(gains.maxCoeff(), 1.0); // and not everywhere
}

TEST(Obstacles, TheBudgetBoundsTheTests)
{
    const haptics::TransducerArray array = dome(400);
    const Eigen::Matrix3Xd spots = points(200);
    ShadowOptions options;
    options.wavelength_m = kWavelength;
    options.maxTests = 20000;
    ShadowCounters counters;
    const Eigen::VectorXd some = shadowGains(spots, array, hand(), options, &counters);
    EXPECT_LT(counters.spots, 200);
    EXPECT_GT(counters.spots, 3);
    EXPECT_LT(counters.tested, 2 * options.maxTests); // spots differ in what is near them
    options.maxTests = 10000000;
    const Eigen::VectorXd all = shadowGains(spots, array, hand(), options);
    EXPECT_LT((some - all).cwiseAbs().mean(), 0.1); // a sample of the points is like all of them
    options.maxTests = 1;
    shadowGains(spots, array, hand(), options, &counters);
    EXPECT_EQ(counters.spots, 1);
}

TEST(Obstacles, WithoutObstaclesAllGainsAreOne)
{
    const haptics::TransducerArray array = dome(50);
    EXPECT_EQ(shadowGains(points(3), array, {}, {}), Eigen::VectorXd::Ones(50));
    EXPECT_EQ(shadowGains(Eigen::Matrix3Xd(3, 0), array, hand(), {}), Eigen::VectorXd::Ones(50));
    const Capsule broken = {Vector3d(NAN, 0, 0), Vector3d(0, 0, 0), 0.01};
    EXPECT_EQ(shadowGains(points(3), array, {broken}, {}), Eigen::VectorXd::Ones(50));
    ShadowOptions options;
    options.maxTests = 0;
    try
    {
        shadowGains(points(3), array, {}, options);
        FAIL();
    }
    catch (const base::InputError& error)
    {
        EXPECT_STREQ(error.what(), "ShadowOptions: maxTests is 0; it must be at least 1");
    }
}

} // namespace

} // namespace midair::bridge
