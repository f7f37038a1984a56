#include "haptics/base/InputError.h"
#include "tests/haptics/tuning/Rehearsal.h"

#include <string>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

std::string errorOf(const std::string& text)
{
    try
    {
        tuningPlanFromCsv(text, "p.csv");
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return "none";
}

const std::string kHead = "# midair-tune plan 1\n# array a\n# method single\n# transducers 3\n";
const std::string kNames = "index,x_m,y_m,z_m,element,phase_level,duty_level\n";

} // namespace

TEST(TuningPlan, comes_back_from_its_file)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.setDead({3, 40});
    for (const TuningMethod method :
         {TuningMethod::SINGLE, TuningMethod::HADAMARD, TuningMethod::LEVELS, TuningMethod::FOCUS})
    {
        const TuningPlan plan = planFor(array, method, placesBeforeBoard(3));
        const std::string text = toCsv(plan);
        const TuningPlan read = tuningPlanFromCsv(text, "p.csv");
        EXPECT_EQ(toCsv(read), text) << tuningMethodName(method);
        EXPECT_EQ(read.places, plan.places);
        EXPECT_EQ(read.off, (std::vector<int>{3, 40}));
        for (int row = 0; row < plan.size(); row += 37)
        {
            const TuningDrive drive =
                driveOf(read, read.rows[static_cast<std::size_t>(row)], &array);
            EXPECT_EQ(drive.duty[3], 0) << "a dead one is driven";
            EXPECT_EQ(drive.phase,
                      driveOf(plan, plan.rows[static_cast<std::size_t>(row)], &array).phase);
        }
    }
}

TEST(TuningPlan, of_single_drives_each_transducer_alone)
{
    const TransducerArray array = TransducerArray::singleBoard();
    const TuningPlan plan = planFor(array, TuningMethod::SINGLE, placesBeforeBoard(1));
    std::vector<int> driven(static_cast<std::size_t>(array.size()), 0);
    for (const TuningRow& row : plan.rows)
    {
        const TuningDrive drive = driveOf(plan, row, nullptr);
        int on = 0;
        for (std::size_t i = 0; i < drive.duty.size(); ++i)
            if (drive.duty[i] > 0)
            {
                ++on;
                ++driven[i];
            }
        EXPECT_LE(on, 1);
    }
    for (const int count : driven)
        EXPECT_EQ(count, 1);
}

// Rows of Hadamard's matrix are orthogonal, whatever their rule.
TEST(TuningPlan, of_hadamard_has_orthogonal_signs)
{
    const TransducerArray array = TransducerArray::singleBoard();
    const TuningPlan plan = planFor(array, TuningMethod::HADAMARD, placesBeforeBoard(1));
    ASSERT_EQ(plan.order(), 256);
    ASSERT_EQ(plan.size(), 256);
    Eigen::MatrixXd signs(256, array.size());
    for (int row = 0; row < 256; ++row)
    {
        const TuningDrive drive = driveOf(plan, plan.rows[static_cast<std::size_t>(row)], nullptr);
        for (int i = 0; i < array.size(); ++i)
            signs(row, i) = drive.phase[static_cast<std::size_t>(i)] == 128 ? -1.0 : 1.0;
    }
    const Eigen::MatrixXd products = signs.transpose() * signs;
    EXPECT_EQ((products - 256.0 * Eigen::MatrixXd::Identity(249, 249)).cwiseAbs().maxCoeff(), 0.0);
    EXPECT_EQ(signs.colwise().sum().cwiseAbs().maxCoeff(), 0.0) << "not apart from a leak";
}

TEST(TuningPlan, of_foci_is_a_focus_where_it_says)
{
    TransducerArray array = TransducerArray::singleBoard();
    array.phaseOffset_rad = Eigen::VectorXd::LinSpaced(array.size(), 0.0, 40.0);
    const TuningPlan plan = planFor(array, TuningMethod::FOCUS, placesBeforeBoard(1));
    const double k = 2.0 * 3.14159265358979 * array.frequency_Hz / plan.soundSpeed_m_s;
    const TuningRow& row = plan.rows.back();
    const TuningDrive drive = driveOf(plan, row, &array);
    std::complex<double> sum = 0.0;
    for (int i = 0; i < array.size(); ++i)
        sum += std::polar(1.0,
                          2.0 * 3.14159265358979 * drive.phase[static_cast<std::size_t>(i)] / 256 +
                              array.phaseOffset_rad[i] -
                              k * (row.focus - array.positions.col(i)).norm());
    EXPECT_GT(std::abs(sum), 0.999 * array.size());
    EXPECT_THROW(driveOf(plan, row, nullptr), base::InputError);
}

TEST(TuningPlan, says_what_is_wrong_with_a_file)
{
    EXPECT_EQ(errorOf(kHead + kNames + "0,0,0,0.1,0,0,255\n"), "none");
    EXPECT_EQ(errorOf("hello\n"),
              "p.csv:1: a plan begins with the lines \"# midair-tune plan 1\", \"# method ..\" and "
              "\"# transducers ..\"");
    EXPECT_EQ(errorOf("# midair-tune plan 1\n# method singel\n"),
              "p.csv:2: method is \"singel\"; known are single, hadamard, levels, focus (did you "
              "mean single?)");
    EXPECT_EQ(errorOf(kHead + "index,x\n"),
              "p.csv:5: the columns are \"index,x\"; they should be "
              "\"index,x_m,y_m,z_m,element,phase_level,duty_level\"");
    EXPECT_EQ(errorOf(kHead + kNames), "p.csv:5: the plan has no rows");
    EXPECT_EQ(errorOf(kHead + kNames + "1,0,0,0.1,0,0,255\n"),
              "p.csv:6: index is 1; it should be 0");
    EXPECT_EQ(errorOf(kHead + kNames + "0,0,0,0.1,3,0,255\n"),
              "p.csv:6: element is 3; it should be a whole number from 0 to 2");
    EXPECT_EQ(errorOf(kHead + kNames + "0,0,nan,0.1,2,0,255\n"),
              "p.csv:6: y_m is nan; it should be a number from -100 to 100");
    EXPECT_EQ(errorOf(kHead + kNames + "0,0,0,0.1,2,0\n"),
              "p.csv:6: the row has 6 columns; it should have 7");
    EXPECT_EQ(errorOf(kHead + kNames + "0,0,0,1,2,0,9\n1,0,0,2,2,0,9\n2,0,0,1,2,0,9\n"),
              "p.csv:8: the microphone is back at an earlier place; all rows of a place should "
              "stand together");
}

TEST(TuningPlan, wants_a_place_and_something_to_drive)
{
    TransducerArray array = TransducerArray::singleBoard();
    const auto errorWith = [&](const Eigen::Matrix3Xd& places)
    {
        try
        {
            planFor(array, TuningMethod::SINGLE, places);
        }
        catch (const base::InputError& error)
        {
            return std::string(error.what());
        }
        return std::string("none");
    };
    EXPECT_EQ(errorWith(Eigen::Matrix3Xd(3, 0)), "there is no place of a microphone");
    EXPECT_EQ(errorWith(array.positions.col(0) + Eigen::Vector3d(0, 0, 2e-3)),
              "place 0 of the microphone is 2.0 mm from a transducer; it must be 5 or more");
    std::vector<int> all;
    for (int i = 0; i < array.size(); ++i)
        all.push_back(i);
    array.setDead(all);
    EXPECT_EQ(errorWith(placesBeforeBoard(1)), "all transducers of array 'board' are dead");
}

TEST(TuningPlan, reads_places)
{
    const Eigen::Matrix3Xd places =
        placesFromCsv("# where\nx_m,y_m,z_m\n0,0,0.1\n0.05 0 0.1\n", "q");
    ASSERT_EQ(places.cols(), 2);
    EXPECT_EQ(places(0, 1), 0.05);
    EXPECT_THROW(placesFromCsv("0,0\n", "q"), base::InputError);
    EXPECT_THROW(placesFromCsv("", "q"), base::InputError);
}
