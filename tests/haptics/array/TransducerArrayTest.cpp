#include "haptics/array/TransducerArray.h"

#include "haptics/array/Medium.h"
#include "haptics/base/Units.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <Eigen/Geometry>

#include <cmath>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

double focusAtCentre_rms_Pa(const TransducerArray& array, double drive)
{
    // Focused: all arrivals in phase, so the moduli add.
    const Eigen::MatrixXcd G = referencePropagationMatrix(Eigen::Vector3d::Zero(), array, Medium());
    return drive * G.cwiseAbs().sum() / std::sqrt(2.0);
}

} // namespace

TEST(TransducerArray, OctagonalPrismHasThePapersShape)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    ASSERT_EQ(array.size(), 3984);
    ASSERT_EQ(array.board.size(), 3984u);
    const double apothem_m = 0.192 * (1.0 + std::sqrt(2.0)) / 2.0;
    EXPECT_NEAR(apothem_m, 0.2318, 5e-5);
    for (int i = 0; i < array.size(); ++i)
    {
        const Eigen::Vector3d position = array.positions.col(i);
        const Eigen::Vector3d normal = array.normals.col(i);
        EXPECT_EQ(array.board[static_cast<std::size_t>(i)], i / 249);
        EXPECT_NEAR(normal.norm(), 1.0, 1e-12);
        EXPECT_EQ(normal.y(), 0.0);
        EXPECT_NEAR(-position.dot(normal), apothem_m, 1e-12) << "transducer " << i;
        // Half a board's edge, less half of what the grid leaves at its rim.
        EXPECT_LE(std::abs(position.dot(normal.cross(Eigen::Vector3d::UnitY()))), 0.096);
        EXPECT_LE(std::abs(position.y()), 0.1514);
    }
    // The grid leaves three places of 18 x 14 free; neighbours are 10.16 mm apart.
    EXPECT_NEAR((array.positions.col(1) - array.positions.col(0)).norm(), 10.16e-3, 1e-12);
}

TEST(TransducerArray, NoTwoTransducersOfThePrismOverlap)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    double nearest = 1.0;
    for (int i = 0; i < array.size(); ++i)
        for (int k = 0; k < i; ++k)
            nearest =
                std::min(nearest, (array.positions.col(i) - array.positions.col(k)).squaredNorm());
    EXPECT_NEAR(std::sqrt(nearest), 10.16e-3, 1e-9);
}

TEST(TransducerArray, SingleBoardFacesAlongZ)
{
    const TransducerArray array = TransducerArray::singleBoard();
    ASSERT_EQ(array.size(), 249);
    EXPECT_EQ(array.positions.row(2).cwiseAbs().maxCoeff(), 0.0);
    EXPECT_TRUE((array.normals.colwise() - Eigen::Vector3d::UnitZ()).isZero(0.0));
    // Counted from 0, row 0 is full, and row 1 lacks columns 1, 2 and 16.
    const auto expectPlace = [&array](int index, int column, int row)
    {
        EXPECT_NEAR(array.positions(0, index), (column - 8.5) * 10.16e-3, 1e-15) << index;
        EXPECT_NEAR(array.positions(1, index), (row - 6.5) * 10.16e-3, 1e-15) << index;
    };
    expectPlace(0, 0, 0);
    expectPlace(17, 17, 0);
    expectPlace(18, 0, 1);
    expectPlace(19, 3, 1);
    expectPlace(31, 15, 1);
    expectPlace(32, 17, 1);
    expectPlace(33, 0, 2);
    EXPECT_EQ(array.sourceAmplitude_Pa_m, 10.1);
}

TEST(TransducerArray, PrismReproducesThePapersMeasuredFocus)
{
    // 5.53 kPa rms (169 dB SPL) at the centre, all 3984 at level 32 of 255. P0 is given to three
    // figures.
    TransducerArray array = TransducerArray::octagonalPrism();
    const double level32 = std::sin(midair::base::kPi * 32.0 / 510.0);
    const double measured_Pa = focusAtCentre_rms_Pa(array, level32);
    EXPECT_NEAR(measured_Pa, 5530.0, 30.0);
    EXPECT_NEAR(20.0 * std::log10(measured_Pa / 20e-6), 169.0, 0.3);

    array.sourceAmplitude_Pa_m = 10.1; // the data sheet's
    const double datasheet_Pa = focusAtCentre_rms_Pa(array, level32);
    EXPECT_NEAR(datasheet_Pa, 20.4e3, 100.0);
    EXPECT_NEAR(datasheet_Pa / measured_Pa, 20.4 / 5.53, 0.03);
}

TEST(TransducerArray, PaperDriveHasLevelsOfDuty)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    EXPECT_EQ(array.drive.phaseLevels, 256);
    ASSERT_EQ(array.drive.amplitudeLevels.size(), 256u);
    EXPECT_EQ(array.drive.amplitudeLevels.front(), 0.0f);
    EXPECT_EQ(array.drive.amplitudeLevels.back(), 1.0f);
    EXPECT_NEAR(array.drive.amplitudeLevels[32], 0.196f, 5e-4f); // the paper's 20 %
}
