// midair-calibrate --boards, from the plan to the array's file, as a user runs it.
#include "haptics/array/TransducerArray.h"
#include "tests/samples/Shell.h"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

namespace
{

const std::string kBoards = MIDAIR_BIN "/midair-calibrate --boards --array octagon ";

std::string temporary(const std::string& name)
{
    return testing::TempDir() + "midair-boards-" + name;
}

} // namespace

TEST(CalibrateBoards, ThePlanIsATemplateOfMeasurements)
{
    const std::string plan = temporary("plan.txt"), tape = temporary("tape.txt");
    const std::string array = temporary("array.json");
    const Outcome planned = shell(kBoards + "--plan " + plan);
    ASSERT_EQ(planned.code, 0) << planned.output;
    EXPECT_NE(planned.output.find("all boards are known to "), std::string::npos);
    // Filled in with what the plan expects.
    std::ifstream in(plan);
    std::ofstream out(tape);
    int lines = 0;
    for (std::string line; std::getline(in, line);)
    {
        std::istringstream words(line);
        std::string from, to;
        if (line.empty() || line[0] == '#' || !(words >> from >> to)) continue;
        const std::size_t about = line.find("about ");
        ASSERT_NE(about, std::string::npos) << line;
        out << from << " " << to << " " << std::stod(line.substr(about + 6)) << "mm\n";
        ++lines;
    }
    out.close();
    EXPECT_EQ(lines, 135);
    const Outcome found = shell(kBoards + "--measurements " + tape + " --array-out " + array);
    ASSERT_EQ(found.code, 0) << found.output;
    EXPECT_NE(found.output.find("board  15  moved   0.0"), std::string::npos) << found.output;
    const auto read = midair::haptics::TransducerArray::load(array);
    EXPECT_LT((read.positions - midair::haptics::TransducerArray::octagonalPrism().positions)
                  .cwiseAbs()
                  .maxCoeff(),
              2e-4);
}

TEST(CalibrateBoards, WhatIsNotEnoughWritesNothing)
{
    const std::string tape = temporary("few.txt"), array = temporary("none.json");
    std::ofstream(tape) << "0:a 1:a 151mm\n";
    const Outcome found = shell(kBoards + "--measurements " + tape + " --array-out " + array);
    EXPECT_EQ(found.code, 1);
    EXPECT_NE(found.output.find("not usable: board 2 has no measurement\n"), std::string::npos)
        << found.output;
    EXPECT_FALSE(std::ifstream(array).good());
    const Outcome wrong = shell("echo '0:a 99:a 1' | " + kBoards + "--measurements -");
    EXPECT_EQ(wrong.code, 2);
    EXPECT_NE(wrong.output.find("midair-calibrate: stdin: line 1: \"99:a\" names no board"),
              std::string::npos)
        << wrong.output;
}
