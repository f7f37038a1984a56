#include "haptics/base/InputError.h"
#include "tests/haptics/tuning/Rehearsal.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::haptics;

namespace
{

/// A plan of twenty rows.
TuningPlan twenty(TuningMethod method = TuningMethod::SINGLE)
{
    TuningPlan plan;
    plan.method = method;
    plan.transducers = 20;
    plan.places = Eigen::Matrix3Xd::Zero(3, 1);
    plan.rows.resize(20);
    return plan;
}

std::string refusalOf(const std::string& text, TuningMethod method = TuningMethod::SINGLE)
{
    try
    {
        readingsFromCsv(text, "r.csv", twenty(method));
    }
    catch (const base::InputError& error)
    {
        return error.what();
    }
    return "none";
}

} // namespace

TEST(TuningReadings, are_told_by_index_where_they_are_not_as_they_should_be)
{
    std::string text = "# plan 0123abcd\nindex,re,im\n";
    for (int row = 0; row < 12; ++row)
        text += std::to_string(row) + "," + std::to_string(row) + ",1\n";
    text += "3,5,3\n12,nan,nan\n13,1,inf\n15,1,2\n99,1,1\n-4,1,1\n15,nan,0\n16,1,1";
    const TuningReadings readings = readingsFromCsv(text, "r.csv", twenty());
    EXPECT_EQ(readings.planSum, "0123abcd");
    EXPECT_EQ(readings.values[3], std::complex<double>(4, 2)) << "the mean of both";
    EXPECT_EQ(readings.values[15], std::complex<double>(1, 2));
    EXPECT_TRUE(std::isnan(readings.values[12].real()));
    EXPECT_TRUE(std::isnan(readings.values[16].real())) << "a line without end may be cut";
    const std::vector<std::string> notes = readings.notes();
    ASSERT_EQ(notes.size(), 5U);
    const std::vector<std::string> numbers = {"14, 16-19", "12, 13", "3", "-4, 99"};
    for (std::size_t k = 0; k < numbers.size(); ++k)
        EXPECT_EQ(notes[k].substr(notes[k].rfind(": ") + 2), numbers[k]) << notes[k];
}

TEST(TuningReadings, of_another_kind_are_refused)
{
    EXPECT_EQ(refusalOf("0,1,2\n1,3\n"),
              "r.csv:2: is a level, those before it are re,im; all should be of one kind");
    EXPECT_EQ(refusalOf("0,1,2\n1,3;4;5\n"),
              "r.csv:2: \"1,3;4;5\" is no reading; it should be index,re,im or index,level");
    EXPECT_EQ(refusalOf("0,one\n"),
              "r.csv:1: \"0,one\" is no reading; it should be index,re,im or index,level");
    EXPECT_EQ(refusalOf("0,1\n1,3\n"),
              "r.csv has levels; a plan of the method single needs re,im, against the clock of the "
              "drive (the method levels does without)");
    EXPECT_EQ(refusalOf("0,1\n1,3\n", TuningMethod::LEVELS), "none");
}

TEST(TuningReadings, name_many_rows_by_ranges)
{
    EXPECT_EQ(rangesText({}), "");
    EXPECT_EQ(rangesText({1, 2, 3, 7, 9, 10}), "1-3, 7, 9, 10");
    EXPECT_EQ(rangesText({1, 3, 5, 7}, 2), "1, 3 and 2 more");
}

TEST(TuningReadings, come_as_instruments_write_them)
{
    std::complex<double> value;
    bool isLevel = false;
    EXPECT_TRUE(parseReading(" 1.5e-3, -2 ", value, isLevel));
    EXPECT_EQ(value, std::complex<double>(1.5e-3, -2));
    EXPECT_FALSE(isLevel);
    EXPECT_TRUE(parseReading("0.25", value, isLevel));
    EXPECT_TRUE(isLevel);
    EXPECT_TRUE(parseReading("NaN,1", value, isLevel));
    EXPECT_TRUE(std::isnan(value.real()));
    EXPECT_FALSE(parseReading("", value, isLevel));
    EXPECT_FALSE(parseReading("1,2,3", value, isLevel));
    EXPECT_FALSE(parseReading("volt", value, isLevel));
}
