// midair-solve --scatterer, from outside: what it prints is what it writes, and bodies that can't
// be computed are refused by name. The numbers themselves: tests/haptics/scattering.
#include "tests/samples/Shell.h"
#include "tests/samples/tools/solve/SolveOutput.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

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
    }
    ~SolveScatterer() override { fs::remove_all(_folder); }

    std::string out() const { return _folder + "/out"; }

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

    Outcome solve(const std::string& body) const
    {
        const std::string points = _folder + "/points.csv";
        std::ofstream(points) << "x_m,y_m,z_m,nx,ny,nz,target\n0.01,0,0.15,0,0,-1,1\n"
                                 "-0.01,0,0.15,0,0,-1,0.5\n";
        return shell(MIDAIR_BIN "/midair-solve --array board --points-file " + points +
                     " --scatterer " + body + " --out " + out());
    }

private:
    std::string _folder;
};

} // namespace

TEST_F(SolveScatterer, PrintsWhatItWrites)
{
    const Outcome made = solve(box(0.01, 0.17));
    ASSERT_EQ(made.code, 0) << made.output;
    const std::size_t at = made.output.find("scatterer   the points change by ");
    ASSERT_NE(at, std::string::npos) << made.output;
    double rms = 0.0, worst = 0.0;
    ASSERT_EQ(std::sscanf(made.output.c_str() + at,
                          "scatterer   the points change by %lf %% rms, at most %lf %%",
                          &rms,
                          &worst),
              2);
    const auto with = readCsv(out() + "/scatterer.csv"),
               alone = readCsv(out() + "/control_points.csv");
    ASSERT_EQ(with.size(), 2U);
    double square = 0.0, most = 0.0;
    for (std::size_t l = 0; l < 2; ++l)
    {
        const double off = std::hypot(with[l][4], with[l][5]) / alone[l][7] - 1.0;
        square += 0.5 * off * off;
        most = std::max(most, std::abs(off));
    }
    EXPECT_GT(rms, 0.5) << "a box behind the points does something";
    EXPECT_NEAR(rms, 100.0 * std::sqrt(square), 0.02);
    EXPECT_NEAR(worst, 100.0 * most, 0.02);
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
}
