#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <Eigen/Geometry>

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

using namespace midair::haptics;

// What is compared here agrees to the rounding of doubles: k R reaches some 10^3 rad, whose
// rounding is 2e-13.
constexpr double kExact = 1e-11;

namespace
{

const double kPi = std::acos(-1.0);

// One transducer at the origin, facing +z.
TransducerArray oneTransducer(Directivity model = Directivity::POINT)
{
    TransducerArray array;
    array.sourceAmplitude_Pa_m = 10.1;
    array.directivity = model;
    array.positions = Eigen::Vector3d::Zero();
    array.normals = Eigen::Vector3d::UnitZ();
    array.board = {0};
    return array;
}

std::complex<double>
fieldAt(const Eigen::Vector3d& point, const TransducerArray& array, const Medium& medium = {})
{
    return referencePropagationMatrix(point, array, medium)(0, 0);
}

Eigen::Vector3d at(double R, double angle_deg)
{
    const double theta = angle_deg * kPi / 180.0;
    return {R * std::sin(theta), 0.0, R * std::cos(theta)};
}

} // namespace

TEST(PropagationReference, OnAxisIsTheSourceAmplitudeOverTheDistance)
{
    const Medium medium;
    for (const Directivity model :
         {Directivity::T4010A1_HARMONICS, Directivity::T4010A1_TABLE, Directivity::POINT})
    {
        const std::complex<double> p = fieldAt({0, 0, 0.3}, oneTransducer(model));
        EXPECT_NEAR(std::abs(p), 10.1 / 0.3 * std::exp(-0.3 * medium.attenuation(40e3)), kExact);
        const double phase = -2.0 * kPi * 40e3 * 0.3 / medium.soundSpeed();
        EXPECT_NEAR(std::arg(p * std::polar(1.0, -phase)), 0.0, kExact);
    }
}

TEST(PropagationReference, DatasheetLevelAtThirtyCentimetres)
{
    // 121.5 dB SPL rms at 0.30 m; the air takes 0.4 dB on the way, which the data sheet's figure
    // already has lost.
    const Medium medium;
    const double rms = std::abs(fieldAt({0, 0, 0.3}, oneTransducer())) / std::sqrt(2.0);
    const double air_dB = 0.3 * medium.attenuation(40e3) * 20.0 / std::log(10.0);
    EXPECT_NEAR(20.0 * std::log10(rms / 20e-6) + air_dB, 121.5, 0.02);
}

TEST(PropagationReference, SpreadsSphericallyAndIsAttenuated)
{
    const Medium medium;
    const double beta = medium.attenuation(40e3);
    const TransducerArray array = oneTransducer();
    for (const double R : {0.01, 0.1, 0.4, 1.5})
    {
        const double ratio = std::abs(fieldAt(at(2 * R, 25), array) / fieldAt(at(R, 25), array));
        EXPECT_NEAR(ratio, 0.5 * std::exp(-beta * R), kExact);
    }
}

TEST(PropagationReference, OneTurnOfPhaseAWavelengthOutwards)
{
    const Medium medium{14.5, 0.5, 101325.0};
    const double lambda = medium.wavelength(40e3);
    EXPECT_NEAR(lambda, 8.5e-3, 5e-6);
    const TransducerArray array = oneTransducer();
    const std::complex<double> here = fieldAt(at(0.2, 40), array, medium);
    EXPECT_NEAR(std::arg(fieldAt(at(0.2 + lambda, 40), array, medium) / here), 0.0, kExact);
    // e^{+j omega t}: outgoing waves lag, a quarter of a wavelength further by pi/2.
    EXPECT_NEAR(
        std::arg(fieldAt(at(0.2 + lambda / 4, 40), array, medium) / here), -kPi / 2, kExact);
    // Twice the frequency, half the wavelength.
    TransducerArray higher = array;
    higher.frequency_Hz = 80e3;
    EXPECT_NEAR(std::arg(fieldAt(at(0.2 + lambda / 4, 40), higher, medium) /
                         fieldAt(at(0.2, 40), higher, medium) * -1.0),
                0.0,
                kExact);
}

TEST(PropagationReference, TableDirectivityAtItsAngles)
{
    const double measured_dB[] = {0, 0, 0, -1, -3, -6, -9, -12, -14};
    const TransducerArray array = oneTransducer(Directivity::T4010A1_TABLE);
    const double onAxis = std::abs(fieldAt({0, 0, 0.25}, array));
    for (int k = 0; k < 9; ++k)
        EXPECT_NEAR(20.0 * std::log10(std::abs(fieldAt(at(0.25, 10.0 * k), array)) / onAxis),
                    measured_dB[k],
                    1e-9);
}

TEST(PropagationReference, RearEmission)
{
    const double front = std::abs(fieldAt({0, 0, 0.2}, oneTransducer()));
    const auto rear = [front](Directivity model) {
        return std::abs(fieldAt({0, 0, -0.2}, oneTransducer(model))) / front;
    };
    EXPECT_NEAR(rear(Directivity::T4010A1_HARMONICS), 0.04, 0.005);
    EXPECT_EQ(rear(Directivity::T4010A1_TABLE), 0.0);
    EXPECT_NEAR(rear(Directivity::POINT), 1.0, kExact);
}

TEST(PropagationReference, PhaseOffsetLeadsAndGainMultiplies)
{
    TransducerArray array = oneTransducer();
    const std::complex<double> plain = fieldAt(at(0.2, 30), array);
    array.phaseOffset_rad = Eigen::VectorXd::Constant(1, 0.7);
    array.gain = Eigen::VectorXd::Constant(1, 0.6);
    const std::complex<double> ratio = fieldAt(at(0.2, 30), array) / plain;
    EXPECT_NEAR(std::arg(ratio), 0.7, kExact);
    EXPECT_NEAR(std::abs(ratio), 0.6, kExact);
}

TEST(PropagationReference, RowsArePointsAndColumnsAreTransducers)
{
    const TransducerArray array = TransducerArray::singleBoard();
    Eigen::Matrix3Xd points(3, 2);
    points << 0.0, 0.03, 0.0, -0.02, 0.1, 0.2;
    const Eigen::MatrixXcd G = referencePropagationMatrix(points, array, Medium());
    ASSERT_EQ(G.rows(), 2);
    ASSERT_EQ(G.cols(), 249);
    for (const int i : {0, 100, 248})
        for (const int l : {0, 1})
        {
            TransducerArray one = oneTransducer(array.directivity);
            one.positions = array.positions.col(i);
            EXPECT_NEAR(std::abs(G(l, i) - fieldAt(points.col(l), one)), 0.0, kExact);
        }
}

TEST(PropagationReference, TurningAndMovingEverythingChangesNothing)
{
    TransducerArray array = TransducerArray::singleBoard();
    Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Random(3, 5) * 0.1;
    points.row(2).array() += 0.2;
    const Eigen::MatrixXcd before = referencePropagationMatrix(points, array, Medium());
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    const Eigen::Vector3d move(0.3, -0.1, 0.2);
    array.positions = ((turn * array.positions).colwise() + move).eval();
    array.normals = (turn * array.normals).eval();
    points = ((turn * points).colwise() + move).eval();
    const Eigen::MatrixXcd after = referencePropagationMatrix(points, array, Medium());
    EXPECT_LT((after - before).cwiseAbs().maxCoeff(), 1e-9 * before.cwiseAbs().maxCoeff());
}

TEST(PropagationReference, IsFiniteOnTopOfATransducer)
{
    // The distance is not taken below 5 mm.
    const TransducerArray array = oneTransducer();
    const std::complex<double> there = fieldAt(Eigen::Vector3d::Zero(), array);
    EXPECT_NEAR(std::abs(there - fieldAt({0, 0, 5e-3}, array)), 0.0, 1e-8);
    for (const Directivity model : {Directivity::T4010A1_HARMONICS, Directivity::T4010A1_TABLE})
        EXPECT_TRUE(
            std::isfinite(std::abs(fieldAt(Eigen::Vector3d::Zero(), oneTransducer(model)))));
}
