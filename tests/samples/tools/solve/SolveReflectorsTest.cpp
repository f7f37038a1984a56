// midair-solve with reflectors: what it tells, corrects and refuses, recomputed by mirror images.
#include "tests/samples/Shell.h"
#include "tests/samples/tools/solve/PublishedDirectivity.h"
#include "tests/samples/tools/solve/SolveOutput.h"

#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace
{

namespace fs = std::filesystem;

const std::string kSolve =
    MIDAIR_BIN "/midair-solve " MIDAIR_ROOT "/samples/models/star.obj --size 0.04 --array board "
               "--position 0 0 0.15 --directivity t4010a1-harmonics ";

std::string folder(const std::string& name)
{
    std::string path = testing::TempDir() + "midair-solve-reflectors-" + name;
    fs::remove_all(path);
    fs::create_directories(path);
    return path;
}

/// A screen behind the points, as a file.
std::string screen(const std::string& folder, double z_m, double accuracy_mm)
{
    const std::string path = folder + "/reflectors.json";
    std::ofstream(path) << R"({"reflectors": [{"name": "screen", "position_m": [0, 0, )" << z_m
                        << R"(], "normal": [0, 0.1, -1], "accuracy_mm": )" << accuracy_mm << "}]}";
    return path;
}

/// The rms error of the points of control_points.csv for drive.csv before the screen, by images of
/// the transducers in a plane that is \a off_m farther along its normal.
double recomputed(const std::string& out, double z_m, double off_m)
{
    const nlohmann::json summary = readSummary(out);
    const double k = 2 * M_PI * 40e3 / summary.at("soundSpeed_m_s").get<double>();
    const double beta = summary.at("attenuation_Np_m").get<double>();
    const double length = std::hypot(0.1, 1.0);
    const double n[3] = {0.0, 0.1 / length, -1.0 / length};
    const auto drive = readCsv(out + "/drive.csv");
    std::vector<double> y, a;
    for (const auto& point : readCsv(out + "/control_points.csv"))
    {
        std::complex<double> p = 0.0;
        for (const auto& t : drive)
            for (const bool isImage : {false, true})
            {
                double at[3] = {t[0], t[1], t[2]}, facing[3] = {t[3], t[4], t[5]};
                const double height = n[1] * t[1] + n[2] * (t[2] - z_m) - off_m;
                const double turned = n[1] * t[4] + n[2] * t[5];
                for (int e = 0; e < 3 && isImage; ++e)
                {
                    at[e] -= 2.0 * height * n[e];
                    facing[e] -= 2.0 * turned * n[e];
                }
                double square = 0.0, along = 0.0;
                for (std::size_t e = 0; e < 3; ++e)
                {
                    square += (point[e] - at[e]) * (point[e] - at[e]);
                    along += (point[e] - at[e]) * facing[e];
                }
                const double R = std::sqrt(square);
                p += std::polar(publishedDirectivity(along / R) / R * std::exp(-beta * R) *
                                    std::sin(M_PI * t[7] / 510.0),
                                -k * R + 2 * M_PI * t[6] / 256.0);
            }
        y.push_back(std::abs(p));
        a.push_back(point[6]);
    }
    double ya = 0.0, aa = 0.0, sum = 0.0;
    for (std::size_t l = 0; l < y.size(); ++l)
    {
        ya += y[l] * a[l];
        aa += a[l] * a[l];
    }
    for (std::size_t l = 0; l < y.size(); ++l)
        sum += std::pow(y[l] / (ya / aa * a[l]) - 1.0, 2);
    return std::sqrt(sum / static_cast<double>(y.size()));
}

} // namespace

TEST(SolveReflectors, AreCorrectedAndTheirUncertaintyIsTold)
{
    const std::string out = folder("corrected");
    const Outcome done = shell(kSolve + "--reflectors " + screen(out, 0.25, 0.5) + " --out " + out);
    ASSERT_EQ(done.code, 0) << done.output;
    EXPECT_NE(done.output.find("reflectors  1, solved for: rms "), std::string::npos)
        << done.output;
    const nlohmann::json told = readSummary(out).at("reflectors");
    EXPECT_EQ(told.at("corrected"), true);
    EXPECT_LT(recomputed(out, 0.25, 0.0), 1e-3) << "true rms after 8 bits";
    EXPECT_NEAR(told.at("rms").get<double>(), recomputed(out, 0.25, 0.0), 3e-4);
    // A screen that is off by its accuracy, to either side.
    for (const double off_m : {-0.5e-3, 0.5e-3})
    {
        const double truth = recomputed(out, 0.25, off_m);
        EXPECT_GT(told.at("expectedRms").get<double>(), truth / 1.5) << off_m;
        EXPECT_LT(told.at("expectedRms").get<double>(), truth * 1.5) << off_m;
    }
    EXPECT_GT(told.at("uncorrected").at("rms").get<double>(), 0.02);
    // The screen sends the board's sound back to where people are.
    EXPECT_GT(readSummary(out).at("exposure").at("level_dB").get<double>(),
              told.at("freeEars_dB").get<double>());
}

TEST(SolveReflectors, AreOnlyToldWithoutACorrection)
{
    const std::string out = folder("told");
    const std::string file = screen(out, 0.25, 0.5);
    ASSERT_EQ(shell(kSolve + "--out " + out).code, 0);
    const auto free = readCsv(out + "/drive.csv");
    const Outcome done = shell(kSolve + "--reflectors " + file + " --no-correction --out " + out);
    ASSERT_EQ(done.code, 0) << done.output;
    EXPECT_NE(done.output.find("reflectors  1, not solved for: rms "), std::string::npos)
        << done.output;
    EXPECT_EQ(readCsv(out + "/drive.csv"), free) << "the drive of free air";
    const nlohmann::json told = readSummary(out).at("reflectors");
    EXPECT_EQ(told.at("corrected"), false);
    EXPECT_NEAR(told.at("rms").get<double>(), recomputed(out, 0.25, 0.0), 3e-4);
    EXPECT_NEAR(
        readSummary(out).at("report").at("rms").get<double>(), told.at("rms").get<double>(), 1e-3)
        << "the report is of the drive as played, too";
    EXPECT_LT(told.at("freeRms").get<double>(), 2e-3);
}

TEST(SolveReflectors, AreRefusedByName)
{
    const std::string out = folder("refused");
    const auto refuses = [&](const std::string& file, const std::string& text)
    {
        const Outcome done = shell(kSolve + "--reflectors " + file + " --out " + out);
        EXPECT_EQ(done.code, 2) << done.output;
        EXPECT_NE(done.output.find(text), std::string::npos) << done.output;
    };
    refuses(screen(out, 0.25, 2.0), "the accuracy of reflector 'screen' is 2 mm");
    // Points that are too near are left out.
    const Outcome near =
        shell(kSolve + "--reflectors " + screen(out, 0.155, 0.2) + " --out " + out);
    EXPECT_EQ(near.code, 0) << near.output;
    EXPECT_NE(near.output.find("nearer than a wavelength to a reflector"), std::string::npos)
        << near.output;
    refuses(out + "/none.json", "none.json");
    std::ofstream(out + "/wrong.json") << R"({"reflectors": [{"normal": [0, 0, 1]}]})";
    refuses(out + "/wrong.json", "reflectors[0] lacks 'position_m'");
    // Without a correction it tells, and how far that can be trusted.
    const Outcome done =
        shell(kSolve + "--reflectors " + screen(out, 0.25, 2.0) + " --no-correction --out " + out);
    EXPECT_EQ(done.code, 0) << done.output;
    EXPECT_NE(done.output.find("figures with reflectors are rough"), std::string::npos)
        << done.output;
}

TEST(SolveReflectors, OfReflectionZeroChangeNothing)
{
    const std::string out = folder("zero");
    ASSERT_EQ(shell(kSolve + "--out " + out).code, 0);
    const auto free = readCsv(out + "/drive.csv");
    std::ofstream(out + "/zero.json")
        << R"({"reflectors": [{"position_m": [0, 0, 0.25], "normal": [0, 0, 1], "reflection": 0,
               "accuracy_mm": 0.2}]})";
    ASSERT_EQ(shell(kSolve + "--reflectors " + out + "/zero.json --out " + out).code, 0);
    EXPECT_EQ(readCsv(out + "/drive.csv"), free);
}
