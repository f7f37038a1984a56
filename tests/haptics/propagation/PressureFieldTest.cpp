#include "haptics/propagation/PressureField.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <cmath>
#include <complex>
#include <limits>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

// Activations all over the unit disc.
Eigen::VectorXcf activations(int m)
{
    Eigen::VectorXcf q(m);
    for (int i = 0; i < m; ++i)
        q[i] = std::polar(0.5f + 0.5f * std::sin(1.7f * i), 2.4f * i);
    return q;
}

Eigen::Matrix3Xd points(int n)
{
    Eigen::Matrix3Xd r(3, n);
    for (int l = 0; l < n; ++l)
        r.col(l) << 0.1 * std::sin(1.0 * l), 0.1 * std::cos(2.3 * l), 0.1 * std::sin(4.1 * l + 1);
    return r;
}

// The error that is allowed, 1e-5 of what all transducers in phase would give.
void expectField(const Eigen::Matrix3Xd& r,
                 const TransducerArray& array,
                 const Medium& medium,
                 const Eigen::VectorXcf& q,
                 int threads)
{
    const Eigen::VectorXcf p = pressureAt(r, array, medium, q, threads);
    ASSERT_EQ(p.size(), r.cols());
    if (r.cols() == 0) return;
    const Eigen::MatrixXcd G = referencePropagationMatrix(r, array, medium);
    const Eigen::VectorXcd expected = G * q.cast<std::complex<double>>();
    const Eigen::VectorXd inPhase = G.cwiseAbs() * q.cast<std::complex<double>>().cwiseAbs();
    for (Eigen::Index l = 0; l < r.cols(); ++l)
        EXPECT_LE(std::abs(std::complex<double>(p[l]) - expected[l]), 1e-5 * inPhase[l])
            << "point " << l;
}

} // namespace

TEST(PressureField, AgreesWithTheReferenceForEveryModel)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    const Medium medium{24.0, 0.3, 99e3};
    for (const Directivity model :
         {Directivity::T4010A1_HARMONICS, Directivity::T4010A1_TABLE, Directivity::POINT})
    {
        array.directivity = model;
        expectField(points(37), array, medium, activations(array.size()), 1);
    }
}

TEST(PressureField, OffsetsAndGainsCountAndSilentTransducersDoNot)
{
    TransducerArray array = TransducerArray::octagonalPrism();
    array.phaseOffset_rad = Eigen::VectorXd::LinSpaced(array.size(), -9.0, 9.0);
    array.gain = Eigen::VectorXd::LinSpaced(array.size(), 0.1, 1.3);
    Eigen::VectorXcf q = activations(array.size());
    for (int i = 0; i < array.size(); ++i)
        if (i % 7 != 3) q[i] = 0.0f;
    expectField(points(20), array, Medium(), q, 1);
    q.setZero();
    EXPECT_TRUE(pressureAt(points(20), array, Medium(), q).isZero(0.0f));
}

TEST(PressureField, ThreadsChangeNothing)
{
    const TransducerArray array = TransducerArray::singleBoard();
    Eigen::Matrix3Xd r = points(1000);
    r.row(2).array() += 0.2;
    const Eigen::VectorXcf q = activations(array.size());
    const Eigen::VectorXcf one = pressureAt(r, array, Medium(), q, 1);
    for (const int threads : {0, 2, 3, 200})
        EXPECT_TRUE(pressureAt(r, array, Medium(), q, threads) == one) << threads;
}

TEST(PressureField, TheMeanSquareOfFieldsIsThatOfEach)
{
    const TransducerArray array = TransducerArray::singleBoard();
    Eigen::Matrix3Xd r = points(50);
    r.row(2).array() += 0.15;
    std::vector<Eigen::VectorXcf> fields(4, activations(array.size()));
    fields[1].head(100).setZero(); // what is silent in one field is not so in another
    fields[2].setZero();
    fields[3] = -2.0f * fields[1];
    Eigen::VectorXd square = Eigen::VectorXd::Zero(50);
    for (const Eigen::VectorXcf& q : fields)
        square += pressureAt(r, array, Medium(), q).cwiseAbs2().cast<double>() / 4.0;
    for (const int threads : {1, 3})
        EXPECT_TRUE(meanSquarePressure(r, array, Medium(), fields, threads).isApprox(square, 1e-4));
    EXPECT_THROW(meanSquarePressure(r, array, Medium(), {}), midair::base::InputError);
    fields[3].resize(7);
    EXPECT_THROW(meanSquarePressure(r, array, Medium(), fields), midair::base::InputError);
}

TEST(PressureField, AnyNumberOfPoints)
{
    const TransducerArray array = TransducerArray::singleBoard();
    for (const int n : {0, 1, 7, 16, 17, 33})
    {
        Eigen::Matrix3Xd r = points(n);
        if (n > 0) r.row(2).array() += 0.15;
        expectField(r, array, Medium(), activations(array.size()), 2);
    }
    expectField(Eigen::Vector3d(0, 0, 0), array, Medium(), activations(array.size()), 1);
    // On a transducer, behind the board and far off.
    Eigen::Matrix3Xd r(3, 3);
    r << array.positions.col(5), Eigen::Vector3d(0.01, 0.02, -0.1), Eigen::Vector3d(1, 2, 3);
    expectField(r, array, Medium(), activations(array.size()), 1);
}

TEST(PressureField, WrongNumberOfActivationsIsRefused)
{
    try
    {
        pressureAt(
            points(1), TransducerArray::singleBoard(), Medium(), Eigen::VectorXcf::Ones(248));
        FAIL();
    }
    catch (const midair::base::InputError& error)
    {
        EXPECT_STREQ(
            error.what(),
            "activations are 248; there must be one for each of the array's 249 transducers");
    }
}

TEST(FieldGrid, GoesRowByRowFromCornerToCorner)
{
    FieldGrid grid;
    grid.corner = Eigen::Vector3d(-1, 0, 2);
    grid.u = Eigen::Vector3d(2, 0, 0);
    grid.v = Eigen::Vector3d(0, 3, 0);
    grid.columns = 5;
    grid.rows = 4;
    const Eigen::Matrix3Xd r = grid.points();
    ASSERT_EQ(r.cols(), 20);
    EXPECT_EQ(r.col(0), grid.corner);
    EXPECT_EQ(r.col(1), Eigen::Vector3d(-0.5, 0, 2));
    EXPECT_EQ(r.col(4), Eigen::Vector3d(1, 0, 2));
    EXPECT_EQ(r.col(5), Eigen::Vector3d(-1, 1, 2));
    EXPECT_EQ(r.col(19), Eigen::Vector3d(1, 3, 2));
    grid.columns = grid.rows = 1;
    EXPECT_EQ(grid.points(), grid.corner);
    grid.rows = 0;
    EXPECT_EQ(grid.points().cols(), 0);
}

TEST(RadiationPressure, IsThePapersHundredGrams)
{
    // 27.7 kPa rms, alpha = 2, 1 cm^2: about 1.1 N, the paper's "100 gw".
    const double peak_Pa = 27.7e3 * std::sqrt(2.0);
    EXPECT_NEAR(radiationForce(peak_Pa, 1e-4, Medium()), 1.1, 0.05);
    // Twice the energy density p_rms^2 / (rho c^2).
    const Medium medium{20.0, 0.5, 101325.0};
    const double expected = 2.0 * 27.7e3 * 27.7e3 / (1.2041 * 343.21 * 343.21);
    EXPECT_NEAR(radiationPressure(peak_Pa, medium), expected, 1e-3 * expected);
    EXPECT_NEAR(radiationPressure(peak_Pa, medium, 1.0), 0.5 * expected, 1e-3 * expected);
    // With the square of the pressure.
    EXPECT_NEAR(radiationPressure(2000.0, medium) / radiationPressure(1000.0, medium), 4.0, 1e-12);
}
