#include "haptics/propagation/FieldLattice.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <Eigen/Geometry>

#include <random>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

Eigen::VectorXcf randomDrive(int count)
{
    std::mt19937 random(11);
    std::uniform_real_distribution<float> angle(0.0F, 6.2831853F);
    std::uniform_real_distribution<float> amplitude(0.2F, 1.0F);
    Eigen::VectorXcf q(count);
    for (auto& value : q)
    {
        // Two statements: compilers evaluate the arguments of one call in different orders.
        const float magnitude = amplitude(random);
        value = std::polar(magnitude, angle(random));
    }
    return q;
}

/// Turned against every axis; \a counts samples, \a pitch_m apart, about \a middle.
FieldLattice tilted(const Eigen::Array3i& counts, double pitch_m, const Eigen::Vector3d& middle)
{
    FieldLattice lattice;
    lattice.count = counts;
    lattice.step =
        pitch_m *
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, -0.5, 0.3).normalized()).toRotationMatrix();
    lattice.origin = middle - lattice.step * (0.5 * (counts - 1).cast<double>().matrix());
    return lattice;
}

/// Largest difference from the formula in double precision, over what all waves in phase would
/// give.
double worst(const FieldLattice& lattice,
             const TransducerArray& array,
             const Medium& medium,
             const Eigen::VectorXcf& q,
             const Eigen::VectorXcf& pressure)
{
    double most = 0.0;
    for (int c = 0; c < lattice.count[2]; ++c)
        for (int b = 0; b < lattice.count[1]; ++b)
            for (int a = 0; a < lattice.count[0]; ++a)
            {
                const Eigen::RowVectorXcd g =
                    referencePropagationMatrix(lattice.at(a, b, c), array, medium).row(0);
                const std::complex<double> exact = g * q.cast<std::complex<double>>();
                const std::complex<double> fast =
                    pressure[a + lattice.count[0] * (b + lattice.count[1] * c)];
                most = std::max(most, std::abs(fast - exact) / g.cwiseAbs().sum());
            }
    return most;
}

/// The same for the worst of all drives up to 1: the transducers' own differences added up. Each is
/// driven alone, but for a trace of the others that keeps the tiles as they are when all play.
double
worstOfAllDrives(const FieldLattice& lattice, const TransducerArray& array, const Medium& medium)
{
    Eigen::MatrixXcd g(lattice.size(), array.size());
    for (int i = 0; i < lattice.size(); ++i)
    {
        const int a = i % lattice.count[0], b = i / lattice.count[0];
        g.row(i) = referencePropagationMatrix(lattice.at(a, b, 0), array, medium).row(0);
    }
    LatticeField field(array, medium);
    Eigen::VectorXd difference = Eigen::VectorXd::Zero(lattice.size());
    for (int t = 0; t < array.size(); ++t)
    {
        Eigen::VectorXcf q = Eigen::VectorXcf::Constant(array.size(), 1e-12F);
        q[t] = 1.0F;
        Eigen::VectorXcf pressure;
        field.evaluate(lattice, q, pressure);
        difference += (pressure.cast<std::complex<double>>() - g.col(t)).cwiseAbs();
    }
    return (difference.array() / g.cwiseAbs().rowwise().sum().array()).maxCoeff();
}

} // namespace

TEST(FieldLattice, SliceThroughTheOctagonIsTheFormulas)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Eigen::VectorXcf q = randomDrive(array.size());
    const FieldLattice lattice = tilted({37, 29, 1}, 3.2e-3, {0.02, -0.01, 0.015});
    LatticeField field(array, Medium());
    Eigen::VectorXcf pressure;
    field.evaluate(lattice, q, pressure);
    EXPECT_EQ(field.tiled(), lattice.size());
    EXPECT_LT(worst(lattice, array, Medium(), q, pressure), 2e-4);
}

TEST(FieldLattice, FocusInTheOctagonIsTheFormulas)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Eigen::Vector3d focus(0.03, 0.01, -0.04);
    const Eigen::VectorXcd g = referencePropagationMatrix(focus, array, Medium()).row(0).adjoint();
    const Eigen::VectorXcf q = (g.array() / g.array().abs()).cast<std::complex<float>>();
    const FieldLattice lattice = tilted({23, 23, 1}, 3.0e-3, focus);
    LatticeField field(array, Medium());
    Eigen::VectorXcf pressure;
    field.evaluate(lattice, q, pressure);
    EXPECT_LT(worst(lattice, array, Medium(), q, pressure), 2e-3);
    EXPECT_NEAR(std::abs(pressure[11 + 23 * 11]), g.cwiseAbs().sum(), 2e-3 * g.cwiseAbs().sum());
}

TEST(FieldLattice, VolumeIsTheFormulas)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const Eigen::VectorXcf q = randomDrive(array.size());
    const FieldLattice lattice = tilted({13, 6, 11}, 3.6e-3, {-0.03, 0.0, 0.02});
    LatticeField field(array, Medium());
    Eigen::VectorXcf pressure;
    field.evaluate(lattice, q, pressure);
    EXPECT_EQ(field.tiled(), lattice.size());
    EXPECT_LT(worst(lattice, array, Medium(), q, pressure), 2e-4);
}

TEST(FieldLattice, NearTheTransducersTilesShrinkAndGiveWay)
{
    // From one board's face on: all sizes of tiles, and entries one by one.
    TransducerArray array = TransducerArray::singleBoard();
    FieldLattice lattice = tilted({3, 41, 1}, 3.0e-3, {0.0, 0.0, 0.06});
    lattice.step.col(0) = Eigen::Vector3d(2e-3, 0.0, 0.0);
    lattice.step.col(1) = Eigen::Vector3d(0.0, 0.0, 3e-3);
    lattice.origin = Eigen::Vector3d(0.01, 0.02, 1e-3);
    for (const Directivity model :
         {Directivity::T4010A1_HARMONICS, Directivity::T4010A1_TABLE, Directivity::POINT})
    {
        array.directivity = model;
        LatticeField field(array, Medium());
        Eigen::VectorXcf pressure;
        field.evaluate(lattice, randomDrive(array.size()), pressure);
        EXPECT_GT(field.tiled(), 30);
        EXPECT_GT(field.exact(), 0);
        EXPECT_EQ(field.tiled() + field.exact(), lattice.size());
        EXPECT_LT(worstOfAllDrives(lattice, array, Medium()), LatticeField::kPhaseError)
            << directivityName(model);
    }
}

TEST(FieldLattice, GainAndPhaseOffsetCount)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.gain = Eigen::VectorXd::LinSpaced(array.size(), 0.2, 1.0);
    array.phaseOffset_rad = Eigen::VectorXd::LinSpaced(array.size(), -3.0, 3.0);
    Eigen::VectorXcf q = randomDrive(array.size());
    q.head(100).setZero(); // what is silent is left out
    const FieldLattice lattice = tilted({17, 1, 1}, 3.0e-3, {0.0, 0.01, 0.15});
    LatticeField field(array, Medium{35.0, 0.2, 101325.0});
    Eigen::VectorXcf pressure;
    field.evaluate(lattice, q, pressure);
    EXPECT_EQ(field.tiled(), lattice.size());
    EXPECT_LT(worst(lattice, array, Medium{35.0, 0.2, 101325.0}, q, pressure), 2e-3);
}

TEST(FieldLattice, UnwantedTilesStaySilent)
{
    const TransducerArray array = TransducerArray::singleBoard();
    const FieldLattice lattice = tilted({32, 32, 1}, 3.0e-3, {0.0, 0.0, 0.2});
    LatticeField field(array, Medium());
    Eigen::VectorXcf pressure;
    const Eigen::Vector3d middle = lattice.at(16, 16, 0);
    field.evaluate(lattice,
                   randomDrive(array.size()),
                   pressure,
                   [&](const Eigen::Vector3d& tile, double radius_m)
                   { return (tile - middle).norm() < 0.02 + radius_m; });
    EXPECT_EQ(pressure[0], std::complex<float>());
    EXPECT_NE(pressure[16 + 32 * 16], std::complex<float>());
    EXPECT_EQ((pressure.array() != std::complex<float>()).count(), field.tiled());
}

TEST(FieldLattice, SilenceAndWrongActivations)
{
    const TransducerArray array = TransducerArray::singleBoard();
    const FieldLattice lattice = tilted({4, 4, 4}, 3.0e-3, {0.0, 0.0, 0.2});
    LatticeField field(array, Medium());
    Eigen::VectorXcf pressure;
    field.evaluate(lattice, Eigen::VectorXcf::Zero(array.size()), pressure);
    EXPECT_EQ(pressure, Eigen::VectorXcf::Zero(64));
    EXPECT_THROW(field.evaluate(lattice, Eigen::VectorXcf::Ones(5), pressure),
                 midair::base::InputError);
}

TEST(FieldLattice, HasTheWavesOfReflectors)
{
    TransducerArray array = TransducerArray::singleBoard();
    Reflector screen;
    screen.position = {0.0, 0.0, 0.25};
    screen.size_m = {0.2, 0.1};
    screen.accuracy_mm = 0.2;
    array.reflectors = {screen};
    const FieldLattice lattice = tilted({9, 9, 1}, 2e-3, {0.0, 0.0, 0.15});
    const Eigen::VectorXcf q = Eigen::VectorXcf::Ones(array.size());
    Eigen::VectorXcf pressure;
    LatticeField(array, Medium()).evaluate(lattice, q, pressure);
    EXPECT_LT(worst(lattice, array, Medium(), q, pressure), 1e-4);
    array.reflectors.clear();
    EXPECT_GT(worst(lattice, array, Medium(), q, pressure), 1e-3) << "nor those of free air";
}
