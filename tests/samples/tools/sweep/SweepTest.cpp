// Runs the built midair-sweep as a user would.

#include "tests/samples/Shell.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace
{

class Sweep : public testing::Test
{
protected:
    Sweep()
    {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder = testing::TempDir() + "midair-sweep-" + test->name();
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
        write("points.csv",
              "x_m,y_m,z_m,nx,ny,nz,target\n0,0,0.15,0,0,1,1\n0.02,0,0.15,0,0,1,1\n"
              "0,0.02,0.15,0,0,1,0.5\n");
        // 40 rows: three pieces.
        write("table.json",
              R"({"common": {"points-file": "points.csv", "array": "board"},
                  "cross": {"solver": ["gauss-newton", "gs"], "temperature": [10, 20],
                            "rmsTolerance": [1e-3, 1e-2], "loudness": [1, 0.9, 0.8, 0.7, 0.6]}})");
    }
    ~Sweep() override { std::filesystem::remove_all(folder); }

    void write(const std::string& name, const std::string& text) const
    {
        std::ofstream(folder + "/" + name, std::ios::binary) << text;
    }
    std::string read(const std::string& name) const
    {
        std::ostringstream all;
        all << std::ifstream(folder + "/" + name, std::ios::binary).rdbuf();
        return all.str();
    }
    Outcome sweep(const std::string& arguments) const
    {
        return shell("cd " + folder + " && " MIDAIR_BIN "/midair-sweep " + arguments + " --quiet");
    }

    /// Rows by column; cells have no commas of their own here.
    std::vector<std::map<std::string, std::string>> rows(const std::string& name) const
    {
        std::istringstream lines(read(name));
        const auto cells = [](const std::string& line)
        {
            std::vector<std::string> all(1);
            for (const char c : line)
                if (c == ',')
                    all.emplace_back();
                else
                    all.back() += c;
            return all;
        };
        std::string line;
        std::getline(lines, line);
        const std::vector<std::string> names = cells(line);
        std::vector<std::map<std::string, std::string>> all;
        while (std::getline(lines, line))
        {
            const std::vector<std::string> values = cells(line);
            EXPECT_EQ(values.size(), names.size()) << line;
            auto& row = all.emplace_back();
            for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i)
                row[names[i]] = values[i];
        }
        return all;
    }

    std::string folder;
};

TEST_F(Sweep, ARowHasTheFiguresOfMidairSolve)
{
    const Outcome outcome = sweep("table.json --out a.csv");
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    const auto all = rows("a.csv");
    ASSERT_EQ(all.size(), 40u);
    for (const std::size_t k : {std::size_t(0), std::size_t(27), std::size_t(39)})
    {
        const auto& row = all[k];
        EXPECT_EQ(row.at("row"), std::to_string(k));
        const Outcome solved = shell(
            "cd " + folder +
            " && " MIDAIR_BIN "/midair-solve --points-file points.csv --array board --solver " +
            row.at("solver") + " --temperature " + row.at("temperature") + " --rms-tolerance " +
            row.at("rmsTolerance") + " --loudness " + row.at("loudness") + " --out solved");
        ASSERT_EQ(solved.code, 0) << solved.output;
        const nlohmann::json report = nlohmann::json::parse(read("solved/summary.json"))["report"];
        for (const char* figure : {"rms", "level_Pa", "max"})
            EXPECT_DOUBLE_EQ(std::stod(row.at(figure)), report[figure].get<double>())
                << k << " " << figure;
        EXPECT_DOUBLE_EQ(std::stod(row.at("reached_loudness")), report["loudness"].get<double>());
    }
    // The last name is the fastest.
    EXPECT_EQ(all[1].at("loudness"), "0.9");
    EXPECT_EQ(all[20].at("solver"), "gs");
}

TEST_F(Sweep, ShardsAndAKillGiveTheSameBytes)
{
    ASSERT_EQ(sweep("table.json --out one.csv").code, 0);
    ASSERT_EQ(sweep("table.json --shard 1/2 --out a.part").code, 0);
    ASSERT_EQ(sweep("table.json --shard 2/2 --out b.part").code, 0);
    const std::string part = read("a.part");
    write("a.part", part.substr(0, part.size() - 200)); // half of a piece
    const Outcome gap = sweep("--merge b.part a.part --out two.csv");
    EXPECT_EQ(gap.code, 2);
    EXPECT_NE(gap.output.find("1 of 3 pieces are missing, the first of them rows 32 to 39"),
              std::string::npos)
        << gap.output;
    ASSERT_EQ(sweep("table.json --shard 1/2 --out a.part").code, 0);
    ASSERT_EQ(sweep("--merge b.part a.part --out two.csv").code, 0);
    EXPECT_TRUE(read("one.csv") == read("two.csv"));
    EXPECT_NE(sweep("--merge b.part b.part a.part --out three.csv")
                  .output.find("rows 16 to 31 are "
                               "in"),
              std::string::npos);
    // The same rows as CSV.
    write("table.csv",
          "points-file,array,loudness\npoints.csv,board,1\n\"points.csv\",board,0.9\n");
    ASSERT_EQ(sweep("table.csv --out csv.csv").code, 0);
    EXPECT_EQ(rows("csv.csv")[1].at("level_Pa"), rows("one.csv")[11].at("level_Pa"));
}

TEST_F(Sweep, WrongTablesAreRefusedByRowAndColumn)
{
    const auto says = [&](const std::string& text, const std::string& what)
    {
        write("wrong", text);
        const Outcome outcome = sweep("wrong --out a.csv");
        EXPECT_EQ(outcome.code, 2) << text;
        EXPECT_NE(outcome.output.find(what), std::string::npos) << outcome.output;
        EXPECT_FALSE(std::filesystem::exists(folder + "/a.csv"));
    };
    says("", "there are no rows");
    says("model,temperature\na.obj,20,30\n", "row 0: has 3 cells, the header 2");
    says(R"([{"points-file": "points.csv", "temprature": 20}])",
         "row 0: there is no parameter \"temprature\" (did you mean temperature?)");
    says(R"([{"points-file": "points.csv"}, {"points-file": "points.csv", "temperature": 400}])",
         "row 1: ");
    says(R"([{"temperature": 20}])", "points-file");
    says(R"({"cros": {}})", "\"cros\" is unknown");
    says(R"([{"points-file": "points.csv", "out": "/tmp"}])", "there is no parameter \"out\"");
    says(R"([{"points-file": "points.csv", "array": "nonesuch"}])", "nonesuch");
    says("[1", "wrong: ");
}

TEST_F(Sweep, ARowThatCannotBeSolvedKeepsItsPlace)
{
    write("far.csv", "x_m,y_m,z_m,nx,ny,nz,target\n0,0,50,0,0,1,1\n");
    write("table.csv", "points-file,array,maxIterations\npoints.csv,board,5\nfar.csv,board,5\n");
    const Outcome outcome = sweep("table.csv --out a.csv");
    const auto all = rows("a.csv");
    ASSERT_EQ(all.size(), 2u) << outcome.output;
    EXPECT_NE(all[0].at("level_Pa"), "0");
    EXPECT_EQ(all[1].at("stop"), "nothing to do");
}

} // namespace
