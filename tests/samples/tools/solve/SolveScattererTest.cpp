// midair-solve --scatterer, from outside: what it prints is what it writes, and bodies that can't
// be computed are refused by name. The numbers themselves: tests/haptics/scattering.
#include "tests/samples/Shell.h"
#include "tests/samples/tools/solve/SolveOutput.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace
{

namespace fs = std::filesystem;

class SolveScatterer : public testing::Test
{
protected:
    SolveScatterer() : _folder(testing::TempDir() + "midair-solve-scatterer")
    {
        fs::create_directories(_folder);
        setenv("XDG_CACHE_HOME", cache().c_str(), 1); // not the user's
    }
    ~SolveScatterer() override
    {
        unsetenv("XDG_CACHE_HOME");
        fs::remove_all(_folder);
    }

    std::string out() const { return _folder + "/out"; }
    std::string cache() const { return _folder + "/cache"; }

    /// A box of \a size_m round (0, 0, \a z_m), without its last \a missing triangles.
    std::string box(double size_m, double z_m, int missing = 0) const
    {
        const std::string path = _folder + "/box.obj";
        std::ofstream file(path);
        for (int i = 0; i < 8; ++i)
            file << "v " << size_m * ((i & 1) - 0.5) << " " << size_m * (((i >> 1) & 1) - 0.5)
                 << " " << z_m + size_m * (((i >> 2) & 1) - 0.5) << "\n";
        const char* const faces[] = {"1 3 4",
                                     "1 4 2",
                                     "5 6 8",
                                     "5 8 7",
                                     "1 2 6",
                                     "1 6 5",
                                     "3 7 8",
                                     "3 8 4",
                                     "1 5 7",
                                     "1 7 3",
                                     "2 4 8",
                                     "2 8 6"};
        for (int face = 0; face < 12 - missing; ++face)
            file << "f " << faces[face] << "\n";
        return path;
    }

    Outcome solve(const std::string& body, const std::string& options = {}) const
    {
        const std::string points = _folder + "/points.csv";
        std::ofstream(points) << "x_m,y_m,z_m,nx,ny,nz,target\n0.01,0,0.15,0,0,-1,1\n"
                                 "-0.01,0,0.15,0,0,-1,0.5\n";
        return shell(MIDAIR_BIN "/midair-solve --array board --points-file " + points +
                     " --scatterer " + body + " --out " + out() + " " + options);
    }

    /// The pressures with the thing at the points, from what is written.
    std::vector<double> pressures() const
    {
        std::vector<double> all;
        for (const std::vector<double>& row : readCsv(out() + "/scatterer.csv"))
            all.push_back(std::hypot(row[4], row[5]));
        return all;
    }
    /// Their rms error, for the targets of solve().
    static double errorOf(const std::vector<double>& p)
    {
        const double s = (p[0] + 0.5 * p[1]) / 1.25;
        const double first = p[0] / s - 1.0, second = p[1] / (0.5 * s) - 1.0;
        return std::sqrt(0.5 * (first * first + second * second));
    }

private:
    std::string _folder;
};

} // namespace

TEST_F(SolveScatterer, PrintsWhatItWrites)
{
    const Outcome made = solve(box(0.01, 0.17), "--no-correction");
    ASSERT_EQ(made.code, 0) << made.output;
    EXPECT_NE(made.output.find("not solved for (--no-correction): rms "), std::string::npos);
    const std::size_t at = made.output.find("scatterer   the points change by ");
    ASSERT_NE(at, std::string::npos) << made.output;
    double rms = 0.0, worst = 0.0;
    ASSERT_EQ(std::sscanf(made.output.c_str() + at,
                          "scatterer   the points change by %lf %% rms, at most %lf %%",
                          &rms,
                          &worst),
              2);
    const auto with = readCsv(out() + "/scatterer.csv");
    ASSERT_EQ(with.size(), 2U);
    double square = 0.0, most = 0.0;
    for (std::size_t l = 0; l < 2; ++l)
    {
        const double off =
            std::hypot(with[l][4], with[l][5]) / std::hypot(with[l][6], with[l][7]) - 1.0;
        square += 0.5 * off * off;
        most = std::max(most, std::abs(off));
    }
    EXPECT_GT(rms, 0.5) << "a box behind the points does something";
    EXPECT_NEAR(rms, 100.0 * std::sqrt(square), 0.02);
    EXPECT_NEAR(worst, 100.0 * most, 0.02);
}

TEST_F(SolveScatterer, CorrectsTheField)
{
    const Outcome made = solve(box(0.01, 0.17));
    ASSERT_EQ(made.code, 0) << made.output;
    const std::size_t at = made.output.find("solved for: rms ");
    ASSERT_NE(at, std::string::npos) << made.output;
    double rms = 0.0, level_Pa = 0.0, without = 0.0, before_Pa = 0.0;
    ASSERT_EQ(std::sscanf(made.output.c_str() + at,
                          "solved for: rms %lf %%, level %lf Pa; rms %lf %%, level %lf Pa without",
                          &rms,
                          &level_Pa,
                          &without,
                          &before_Pa),
              4);
    EXPECT_GT(level_Pa, 0.9 * before_Pa);
    const std::vector<double> with = pressures();
    EXPECT_NEAR(rms, 100.0 * errorOf(with), 0.005);
    EXPECT_LT(rms, 0.2);
    EXPECT_GT(without, 3.0 * rms);
    const auto points = readCsv(out() + "/control_points.csv");
    for (std::size_t l = 0; l < 2; ++l)
        EXPECT_NEAR(points[l][7], with[l], 1e-4 * with[l]) << "files agree on what is felt";
    const nlohmann::json summary = readSummary(out());
    EXPECT_TRUE(summary.at("scatterer").at("corrected").get<bool>());
    EXPECT_NEAR(100.0 * summary.at("scatterer").at("uncorrectedRms").get<double>(), without, 0.001);
    EXPECT_NEAR(100.0 * summary.at("report").at("rms").get<double>(), rms, 0.001);
}

TEST_F(SolveScatterer, CertifiesWithTheBody)
{
    const auto gap = [&](const std::string& options)
    {
        const Outcome made = solve(box(0.01, 0.17), "--certify " + options);
        EXPECT_EQ(made.code, 0) << made.output;
        const nlohmann::json certificate = readSummary(out()).at("certificate");
        EXPECT_GE(certificate.at("field").get<double>(), certificate.at("bound").get<double>());
        return certificate.at("phases").get<double>() / certificate.at("bound").get<double>() - 1.0;
    };
    const double corrected = gap("");
    EXPECT_GE(corrected, 0.0);
    EXPECT_GT(gap("--no-correction"), corrected)
        << "its phases aren't those for the pressures with the body";
    const Outcome refused = solve(box(0.01, 0.17), "--tolerance");
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.output.find("--tolerance doesn't know what scatters"), std::string::npos);
}

TEST_F(SolveScatterer, KeepsTheCapWithTheBody)
{
    ASSERT_EQ(solve(box(0.01, 0.17), "--no-correction").code, 0);
    const std::vector<double> loud = pressures();
    const double cap = 0.6 * std::max(loud[0], loud[1]);
    for (const char* how : {"", " --no-correction"})
    {
        const Outcome made = solve(box(0.01, 0.17), "--max-pressure " + std::to_string(cap) + how);
        ASSERT_EQ(made.code, 0) << made.output;
        const std::vector<double> with = pressures();
        EXPECT_LE(std::max(with[0], with[1]), 1.0001 * cap) << how;
        EXPECT_GE(std::max(with[0], with[1]), 0.95 * cap) << how;
    }
}

TEST_F(SolveScatterer, TakesPlatesByTheirFullWaves)
{
    const auto file = [&](const std::string& more)
    {
        std::ofstream(out() + ".json")
            << R"({"reflectors": [{"position_m": [0, 0, 0.19], "normal": [0, 0, -1],)"
            << R"("along": [1, 0, 0], "size_m": [0.05, 0.04], "accuracy_mm": 0.01)" << more
            << "}]}";
        return "--reflectors " + out() + ".json";
    };
    const Outcome images = solve("reflectors", file("") + " --no-correction");
    ASSERT_EQ(images.code, 0) << images.output;
    const double before = errorOf(pressures());
    const Outcome made = solve("reflectors", file(""));
    ASSERT_EQ(made.code, 0) << made.output;
    EXPECT_NE(made.output.find("            solved for: rms "), std::string::npos) << made.output;
    EXPECT_LT(errorOf(pressures()), 0.002);
    EXPECT_GT(before, 0.01);
    const Outcome soft = solve("reflectors", file(R"(, "reflection": 0.5)"));
    EXPECT_EQ(soft.code, 2);
    EXPECT_NE(soft.output.find("--scatterer reflectors: no reflector has ends"), std::string::npos)
        << soft.output;
}

// Coarse, so that it is quick: above the topmost point, where the array faces.
TEST_F(SolveScatterer, PointsWithAHand)
{
    const Outcome made = solve("hand", "--scatterer-elements 2000");
    ASSERT_EQ(made.code, 0) << made.output;
    EXPECT_NE(made.output.find("            a right hand, its index fingertip at 10.0, 0.0, 151.0 "
                               "mm; 1.2 elements a wavelength: too few to be right\n"),
              std::string::npos)
        << made.output;
    EXPECT_NE(made.output.find("midair-solve: body: "), std::string::npos);
    const std::size_t at = made.output.find("solved for: rms ");
    ASSERT_NE(at, std::string::npos) << made.output;
    double rms = 0.0, without = 0.0;
    ASSERT_EQ(std::sscanf(made.output.c_str() + at,
                          "solved for: rms %lf %%, level %*f Pa; rms %lf %%",
                          &rms,
                          &without),
              2);
    EXPECT_GT(without, 1.0) << "a hand at the points is felt";
    EXPECT_LT(rms, 0.3);
    EXPECT_NEAR(rms, 100.0 * errorOf(pressures()), 0.005);
    const Outcome placed =
        solve("hand", "--scatterer-elements 2000 --no-correction --scatterer-at 0 0 16cm");
    ASSERT_EQ(placed.code, 0) << placed.output;
    EXPECT_NE(placed.output.find("fingertip at 0.0, 0.0, 160.0 mm"), std::string::npos)
        << placed.output;
    const Outcome inside = solve("hand", "--scatterer-elements 2000 --scatterer-at 0.01 0 0.146");
    EXPECT_EQ(inside.code, 2);
    EXPECT_NE(
        inside.output.find("--scatterer hand: point 0 at (0.0100, 0.0000, 0.1500) m is inside"),
        std::string::npos)
        << inside.output;
}

TEST_F(SolveScatterer, KeepsTheMatrixOfAHandForAllPlaces)
{
    const auto files = [&]
    {
        std::vector<fs::path> all;
        std::error_code none;
        for (const auto& entry : fs::directory_iterator(cache() + "/osgMidair", none))
            all.push_back(entry.path());
        return all;
    };
    const auto hand = [&](const std::string& place)
    {
        const Outcome made =
            // What takes under two seconds isn't kept.
            solve("hand",
                  "--no-correction --threads 1 --scatterer-elements 6000 --scatterer-at " + place);
        EXPECT_EQ(made.code, 0) << made.output;
        return made.output;
    };
    const std::string made = hand("0 0 0.16");
    const std::regex progress("midair-solve: body: [1-9]0+ %");
    EXPECT_TRUE(std::regex_search(made, progress)) << made;
    EXPECT_NE(made.find("midair-solve: body: kept as \"" + cache() + "/osgMidair/"),
              std::string::npos)
        << made;
    EXPECT_EQ(files().size(), 1U);
    const std::string other = hand("0.02 0.01 0.17");
    EXPECT_NE(other.find("midair-solve: body: read from \""), std::string::npos) << other;
    EXPECT_FALSE(std::regex_search(other, progress)) << other;
}

TEST_F(SolveScatterer, RefusesByName)
{
    const auto refusal = [&](const std::string& body)
    {
        const Outcome made = solve(body);
        EXPECT_EQ(made.code, 2) << made.output;
        EXPECT_NE(made.output.find("--scatterer " + body + ": "), std::string::npos) << made.output;
        return made.output;
    };
    EXPECT_NE(refusal(box(0.01, 0.17, 1)).find("a hole"), std::string::npos);
    EXPECT_NE(refusal(box(0.0215, 0.15)).find("point 0 at (0.0100, 0.0000, 0.1500) m is inside"),
              std::string::npos);
    EXPECT_NE(refusal(box(0.0215, 0.0)).find("transducer "), std::string::npos);
    EXPECT_NE(refusal(box(1.0, 0.7)).find("more than 10000 triangles"), std::string::npos);
    refusal("/nonexistent.obj");
    const auto misuse = [&](const std::string& body, const std::string& options)
    {
        const Outcome made = solve(body, options);
        EXPECT_EQ(made.code, 2) << made.output;
        return made.output;
    };
    EXPECT_NE(
        misuse(box(0.01, 0.17), "--scatterer-at 0 0 0.2").find("--scatterer-at places a hand"),
        std::string::npos);
    EXPECT_NE(misuse("hand", "--scatterer-elements 50").find("--scatterer-elements"),
              std::string::npos);
    EXPECT_NE(
        misuse("hand", "--scatterer-elements 2000 --scatterer-at 0 0 -1cm").find("transducer "),
        std::string::npos);
}
