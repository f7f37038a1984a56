// midair-solve with all of its options, in the workspace, half out of it and far away: no crash, no
// figure that was not computed.

#include "tests/LongTests.h"
#include "tests/samples/Shell.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace
{

namespace fs = std::filesystem;

using Rows = std::vector<std::vector<double>>;

const std::string kProgram = MIDAIR_BIN "/midair-solve";
const std::string kStar = std::string(MIDAIR_ROOT "/samples/models/star.obj") + " --size 0.04";
const std::vector<std::string> kTurns{"",
                                      " --cycle 2",
                                      " --cycle 3 --cycle-steps 2",
                                      " --subsets 2",
                                      " --cycle 2 --subsets 3",
                                      " --cycle 2 --even 1",
                                      " --outline"};
const std::vector<std::string> kSolvers{
    "gauss-newton", "gs", "sdp-bcd", "gs-pat", "wgs", "greedy", "lbfgs"};

std::string read(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

Rows readRows(const std::string& path)
{
    std::istringstream file(read(path));
    std::string line;
    std::getline(file, line);
    Rows rows;
    while (std::getline(file, line))
    {
        std::stringstream cells(line);
        auto& row = rows.emplace_back();
        for (std::string cell; std::getline(cells, cell, ',');)
            row.push_back(std::stod(cell));
    }
    return rows;
}

/// A solve with a small array of 64 in a folder of its own.
class SolveFigures : public testing::Test
{
protected:
    SolveFigures() : _folder(testing::TempDir() + "midair-figures-" + std::to_string(::getpid()))
    {
        fs::create_directories(_folder);
        std::ofstream(path("array.json"))
            << R"({"frequency_Hz": 40000, "sourceAmplitude_Pa_m": 5, "directivity": "point", "boards": [
{"position_m": [0, -0.1, 0], "normal": [0, 1, 0], "columns": 8, "rows": 8, "pitch_m": 0.0105}]})";
    }
    ~SolveFigures() override { fs::remove_all(_folder); }

    std::string path(const std::string& name) const { return _folder + "/" + name; }
    std::string out() const { return path("out"); }

    std::string command(const std::string& what, const std::string& to) const
    {
        return kProgram + " " + what + " --array " + path("array.json") + " --out " + to;
    }

    /// Solves and looks at every figure; \a code is what it is to end with, -1: 0 or 1.
    void solve(const std::string& what, int code)
    {
        SCOPED_TRACE(what);
        fs::remove_all(out());
        const Outcome outcome = shell(command(what, out()));
        if (code >= 0)
            ASSERT_EQ(outcome.code, code) << outcome.output;
        else
            ASSERT_TRUE(outcome.code == 0 || outcome.code == 1) << outcome.output;
        EXPECT_EQ(outcome.output.find("nan"), std::string::npos) << outcome.output;
        EXPECT_EQ(outcome.output.find("inf "), std::string::npos) << outcome.output;
        expectFigures();
    }

    std::vector<Rows> drives() const
    {
        std::vector<Rows> all;
        for (const auto& entry : fs::directory_iterator(out()))
            if (entry.path().filename().string().rfind("drive", 0) == 0)
                all.push_back(readRows(entry.path()));
        return all;
    }

    nlohmann::json summary() const { return nlohmann::json::parse(read(out() + "/summary.json")); }

    /// |p| by the formula of points that radiate evenly, apart from the product's.
    static double recomputed_Pa(const std::vector<double>& point,
                                const Rows& drive,
                                const nlohmann::json& summary)
    {
        const double k = 2 * M_PI * summary.at("frequency_Hz").get<double>() /
                         summary.at("soundSpeed_m_s").get<double>();
        const double beta = summary.at("attenuation_Np_m");
        const double P0 = summary.at("sourceAmplitude_Pa_m");
        std::complex<double> p = 0.0;
        for (const auto& t : drive)
        {
            const double R = std::hypot(point[0] - t[0], point[1] - t[1], point[2] - t[2]);
            p += P0 / R * std::exp(-beta * R) * std::sin(M_PI * t[7] / 510.0) *
                 std::polar(1.0, -k * R + 2 * M_PI * t[6] / 256.0);
        }
        return std::abs(p);
    }

    void expectFigures() const
    {
        const nlohmann::json all = summary();
        EXPECT_EQ(all.dump().find("null"), std::string::npos) << all.dump(1); // what isn't finite
        const Rows points = readRows(out() + "/control_points.csv");
        ASSERT_EQ(points.size(), all.at("report").at("points").get<std::size_t>());
        const std::vector<Rows> fields = drives();
        ASSERT_EQ(fields.size(), all.at("fields").get<std::size_t>());
        for (const Rows& drive : fields)
            ASSERT_EQ(drive.size(), 64U);
        double squares = 0.0;
        int wanted = 0;
        for (const auto& point : points)
        {
            ASSERT_EQ(point.size(), 8U);
            for (const double figure : point)
                ASSERT_TRUE(std::isfinite(figure));
            // One of the fields is the one for this point; or all are, evened out.
            double nearest_Pa = std::numeric_limits<double>::max(), square = 0.0;
            for (const Rows& drive : fields)
            {
                const double p_Pa = recomputed_Pa(point, drive, all);
                nearest_Pa = std::min(nearest_Pa, std::abs(p_Pa - point[7]));
                square += p_Pa * p_Pa / static_cast<double>(fields.size());
            }
            if (all.contains("evened")) nearest_Pa = std::abs(std::sqrt(square) - point[7]);
            EXPECT_LE(nearest_Pa, 1e-3 * point[7] + 0.01);
            if (!(point[6] > 0.0)) continue;
            squares += std::pow(point[7] / point[6] - 1.0, 2);
            ++wanted;
        }
        const nlohmann::json& report = all.at("report");
        if (wanted > 0 && report.at("level_Pa").get<double>() > 0.0)
        {
            EXPECT_NEAR(std::sqrt(squares / wanted), report.at("rms").get<double>(), 1e-3);
        }
        EXPECT_GT(fs::file_size(out() + "/field.png"), 1000U);
    }

    /// All files but the times in the summary, the picture byte for byte.
    std::string content(const std::string& folder) const
    {
        std::string text;
        std::vector<fs::path> files(fs::directory_iterator(folder), fs::directory_iterator{});
        std::sort(files.begin(), files.end());
        for (const fs::path& file : files)
        {
            if (file.filename() != "summary.json")
            {
                text += file.filename().string() + read(file);
                continue;
            }
            nlohmann::json all = nlohmann::json::parse(read(file));
            all["report"].erase("matrix_ms");
            all["report"].erase("solve_ms");
            if (all.contains("certificate")) all["certificate"].erase("total_ms");
            text += all.dump();
        }
        return text;
    }

    std::string points(const std::string& rows, const std::string& target = "target") const
    {
        std::ofstream(path("points.csv")) << "x_m,y_m,z_m,nx,ny,nz," << target << "\n" << rows;
        return "--points-file " + path("points.csv");
    }

private:
    std::string _folder;
};

const std::string kTwo = "-0.01,0,0,0,1,0,1\n0.01,0,0,0,1,0,0.5\n";

/// Evening out moves sound from places that have much of it: pressures in Pa would not be kept.
bool asksForBoth(const std::string& options)
{
    return options.find(" --even ") != std::string::npos &&
           options.find(" --pressure ") != std::string::npos;
}

} // namespace

TEST_F(SolveFigures, OutsideTheWorkspaceEveryWayOfPlayingIsSilence)
{
    for (const std::string& turns : kTurns)
    {
        SCOPED_TRACE(turns);
        fs::remove_all(out());
        const Outcome outcome = shell(command(kStar + " --position 0 0 5" + turns, out()));
        EXPECT_EQ(outcome.code, 1) << outcome.output;
        EXPECT_NE(outcome.output.find("uses 0 of "), std::string::npos) << outcome.output;
        EXPECT_NE(outcome.output.find("note        there are no control points"), std::string::npos)
            << outcome.output;
        expectFigures();
        EXPECT_EQ(summary().at("report").at("stop"), "nothing to do");
        for (const Rows& drive : drives())
            for (const auto& row : drive)
                ASSERT_EQ(row[7], 0.0);
    }
}

TEST_F(SolveFigures, EveryWayOfPlayingWithEveryTarget)
{
    const std::vector<std::string> targets{"",
                                           " --pressure 300",
                                           " --max-pressure 200",
                                           " --pressure 100000 --max-pressure 150",
                                           " --loudness 1.5 --certify",
                                           " --max-pressure 0.01 --certify"};
    for (const std::string& turns : kTurns)
        for (const std::string& target : targets)
        {
            if (asksForBoth(turns + target))
            {
                const Outcome outcome = shell(command(kStar + turns + target, out()));
                EXPECT_EQ(outcome.code, 2) << outcome.output;
                EXPECT_NE(outcome.output.find("--even"), std::string::npos) << outcome.output;
                continue;
            }
            // One transducer at its lowest level is louder than that: silence, which is told.
            const bool silenced = target.rfind(" --max-pressure 0.01 ", 0) == 0;
            solve(kStar + turns + target, silenced ? 1 : 0);
        }
}

TEST_F(SolveFigures, EverySamplingInTurnAndHalfOutside)
{
    for (const std::string sampling : {"surface", "edges", "vertices"})
        for (const std::string& turns : kTurns)
        {
            const bool cycles = turns.find("--cycle") != std::string::npos;
            if (turns == " --outline" || (cycles && sampling == "vertices")) continue;
            const std::string star = kStar + turns + " --sampling " + sampling;
            solve(star + " --rotation-deg 10 20 30", 0);
            solve(star + " --position 0 -0.098 0", -1); // half of it behind the array
        }
    solve(kStar + " --outline --position 0 -0.098 0", -1);
    solve(kStar + " --cycle 4 --spacing 0.03 --position 0 -0.092 0 --even 1", -1);
    solve(kStar + " --spacing 0.001 --crowding drop", -1);
    solve(kStar + " --spacing 0.002 --crowding merge --cycle 2", -1);
}

TEST_F(SolveFigures, EverySolverInTurn)
{
    const std::string help = shell(kProgram + " --help").output;
    int known = 0;
    for (const std::string& solver : kSolvers)
    {
        if (help.find(solver) == std::string::npos) continue;
        ++known;
        for (const std::string turns : {"", " --cycle 2 --cycle-steps 1", " --subsets 2"})
            solve(kStar + " --sampling edges --solver " + solver + turns, 0);
    }
    EXPECT_EQ(known, 7);
}

TEST_F(SolveFigures, PointsFromAFileAreThereOnceAndAchieveWhatIsPlayed)
{
    solve(points(kTwo) + " --subsets 2", 0);
    EXPECT_EQ(readRows(out() + "/control_points.csv").size(), 2U);
    EXPECT_EQ(summary().at("report").at("points"), 2);
    EXPECT_LT(summary().at("report").at("rms").get<double>(), 0.05);
    for (const std::string turns : {"", " --subsets 2", " --subsets 5 --certify"})
        for (const std::string more : {"", " --max-pressure 50", " --loudness 0.5"})
        {
            solve(points(kTwo) + turns + more, 0);
            solve(points("0,0,0,0,1,0,400\n0.02,0,0,0,1,0,300\n", "target_Pa") + turns + more, 0);
            solve(points("0,0,0,0,1,0,1\n") + turns + more, 0);
        }
}

TEST_F(SolveFigures, PointsThatNothingIsWantedOfOrThatCantBeReached)
{
    for (const std::string turns : {"", " --subsets 2"})
        for (const std::string target : {"target", "target_Pa"})
        {
            solve(points("0,0,0,0,1,0,0\n0.01,0,0,0,1,0,0\n", target) + turns, 1);
            solve(points("0,0,5,0,1,0,100\n0.01,0,6,0,1,0,100\n", target) + turns, 1);
            solve(points("0,0,0,0,1,0,100\n0.01,0,6,0,1,0,100\n", target) + turns, 0);
            solve(points("0,0,0,0,1,0,100\n0.01,0,0,0,1,0,0\n", target) + turns, 0);
            solve(points("0,0,0,0,1,0,100\n0.01,0,0,0,1,0,-1\n", target) + turns, 0);
        }
}

/// malloc fills what it gives with another byte each time: what differs was never set.
TEST_F(SolveFigures, NothingComesFromMemoryThatWasNotSet)
{
    if (!std::string(MIDAIR_SANITIZER_RUNTIME).empty())
        GTEST_SKIP() << "a sanitizer's malloc knows no MALLOC_PERTURB_";
    std::vector<std::string> commands;
    for (const std::string& turns : kTurns)
    {
        commands.push_back(kStar + turns + " --certify");
        commands.push_back(kStar + turns + " --position 0 -0.098 0");
        if (!asksForBoth(turns + " --pressure 300"))
            commands.push_back(kStar + turns + " --pressure 300 --max-pressure 200");
    }
    for (const std::string& solver : kSolvers)
        if (shell(kProgram + " --help").output.find(solver) != std::string::npos)
            commands.push_back(kStar + " --sampling vertices --solver " + solver);
    commands.push_back(points(kTwo) + " --subsets 2");
    for (const std::string& what : commands)
    {
        SCOPED_TRACE(what);
        for (const std::string fill : {"1", "254"})
        {
            fs::remove_all(path(fill));
            const Outcome outcome =
                shell("MALLOC_PERTURB_=" + fill + " " + command(what, path(fill)));
            ASSERT_LE(outcome.code, 1) << outcome.output;
        }
        EXPECT_TRUE(content(path("1")) == content(path("254"))) << "memory that was not set";
    }
}

/// The same in all that it computes, not only in what it writes; slow. valgrind names the first
/// place that hangs on memory that was not set, or reads outside of what was asked for.
TEST_F(SolveFigures, ValgrindFindsNothing)
{
    if (!longTestsAsked()) GTEST_SKIP() << "minutes: tests/run.sh --long";
    if (shell("valgrind --version").code != 0) GTEST_SKIP() << "no valgrind";
    std::vector<std::string> commands;
    for (const std::string& turns : kTurns)
        commands.push_back(kStar + turns + " --certify --pressure 300 --max-pressure 200");
    commands.push_back(kStar + " --cycle 2 --position 0 -0.098 0");
    commands.push_back(kStar + " --cycle 2 --position 0 0 5");
    for (const std::string& solver : kSolvers)
        commands.push_back(kStar + " --sampling vertices --subsets 2 --solver " + solver);
    commands.push_back(points(kTwo) + " --subsets 2");
    for (const std::string& what : commands)
    {
        const Outcome outcome = shell("valgrind -q --error-exitcode=99 --suppressions=" MIDAIR_ROOT
                                      "/tests/sanitizers/valgrind.txt " +
                                      command(what, out()));
        EXPECT_LE(outcome.code, 1) << what << "\n" << outcome.output;
    }
}
