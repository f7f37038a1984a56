// midair-solve with listening places, its levels recomputed by the model as it is written here.
#include "tests/samples/Shell.h"
#include "tests/samples/tools/solve/PublishedDirectivity.h"
#include "tests/samples/tools/solve/SolveOutput.h"

#include <cmath>
#include <complex>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace
{

namespace fs = std::filesystem;

const std::string kSolve =
    MIDAIR_BIN "/midair-solve " MIDAIR_ROOT "/samples/models/star.obj --size 0.08 ";

std::string folder(const std::string& name)
{
    std::string path = testing::TempDir() + "midair-solve-ears-" + name;
    fs::remove_all(path);
    fs::create_directories(path);
    return path;
}

std::string written(const std::string& path, const std::string& text)
{
    std::ofstream(path) << text;
    return path;
}

/// The levels in dB re 20 uPa at \a place of what drive.csv says, with its phases and without; no
/// board is in between.
std::pair<double, double> recomputed(const std::vector<double>& place, const std::string& out)
{
    const nlohmann::json summary = readSummary(out);
    const double k = 2 * M_PI * 40e3 / summary.at("soundSpeed_m_s").get<double>();
    const double beta = summary.at("attenuation_Np_m").get<double>();
    const double P0 = summary.at("exposureAmplitude_Pa_m").get<double>();
    EXPECT_EQ(P0, 10.1) << "of one transducer, not of the octagon's focus";
    std::complex<double> p = 0.0;
    double squares = 0.0;
    std::string header;
    for (const auto& t : readCsv(out + "/drive.csv", &header))
    {
        const double d[3] = {place[0] - t[0], place[1] - t[1], place[2] - t[2]};
        const double R = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        const double cosTheta = (d[0] * t[3] + d[1] * t[4] + d[2] * t[5]) / R;
        const double amplitude = P0 * publishedDirectivity(cosTheta) / R * std::exp(-beta * R) *
                                 std::sin(M_PI * t[7] / 510.0);
        p += std::polar(amplitude, -k * R + 2 * M_PI * t[6] / 256.0);
        squares += amplitude * amplitude;
    }
    constexpr double kHead_dB = 6.0;
    const auto level = [](double square)
    { return kHead_dB + 10.0 * std::log10(square / 2 / 4e-10); };
    return {level(std::norm(p)), level(squares)};
}

} // namespace

TEST(SolveEars, LevelsAgreeWithARecomputation)
{
    const std::string out = folder("levels");
    const std::string places =
        written(out + "/ears.csv",
                "name,z_m,x_m,y_m\nfront,0,0,0.5\n\nup,0.02,0.05,0.4\naxis,-0.03,0,-0.6\n");
    const Outcome outcome = shell(kSolve + "--ears " + places + " --out " + out);
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("at ears     "), std::string::npos) << outcome.output;
    std::string header;
    const auto rows = readCsv(out + "/exposure.csv", &header);
    EXPECT_EQ(header, "x_m,y_m,z_m,L_dB,incoherent_dB");
    ASSERT_EQ(rows.size(), 3u);
    EXPECT_EQ(rows[1][0], 0.05);
    EXPECT_EQ(rows[1][1], 0.4);
    EXPECT_EQ(rows[1][2], 0.02);
    double loudest_dB = 0.0;
    for (const auto& row : rows)
    {
        const auto [level_dB, incoherent_dB] = recomputed(row, out);
        EXPECT_NEAR(row[3], level_dB, 0.02);
        EXPECT_NEAR(row[4], incoherent_dB, 0.01);
        loudest_dB = std::max({loudest_dB, row[3], row[4]});
    }
    const nlohmann::json exposure = readSummary(out).at("exposure");
    EXPECT_EQ(exposure.at("limit_dB"), 0.0);
    EXPECT_GE(exposure.at("level_dB").get<double>(), loudest_dB - 0.01);
    EXPECT_GT(exposure.at("places").get<int>(), 10);
    EXPECT_NE(exposure.at("what").get<std::string>().find("re 20 uPa"), std::string::npos);
    EXPECT_FALSE(exposure.contains("time_s"));
}

TEST(SolveEars, ALimitHoldsInWhatIsWritten)
{
    const std::string out = folder("limit");
    const std::string places =
        written(out + "/ears.csv", "x_m,y_m,z_m\n0,0.5,0\n0.05,0.4,0.02\n0,-0.6,-0.03\n");
    const Outcome outcome =
        shell(kSolve + "--ear-limit \"130 dB\" --ears " + places + " --out " + out);
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    std::string header;
    for (const auto& row : readCsv(out + "/exposure.csv", &header))
    {
        EXPECT_LE(recomputed(row, out).first, 130.0);
        EXPECT_LE(recomputed(row, out).second, 130.0 - 6.6);
    }
    const nlohmann::json summary = readSummary(out);
    EXPECT_LT(summary.at("report").at("capFactor"), 1.0);
    EXPECT_GT(summary.at("report").at("capFactor"), 0.0);
    EXPECT_EQ(summary.at("exposure").at("limit_dB"), 130.0);
    EXPECT_LE(summary.at("exposure").at("level_dB"), 130.0);
    // Fields in turn, each for itself.
    const std::string turns = folder("turns");
    const Outcome cycle = shell(kSolve + "--ear-limit 130 --subsets 3 --out " + turns);
    ASSERT_EQ(cycle.code, 0) << cycle.output;
    EXPECT_LE(readSummary(turns).at("exposure").at("level_dB"), 130.0);
}

TEST(SolveEars, WhatIsNotUnderstoodIsRefused)
{
    const std::string out = folder("wrong");
    for (const char* wrong : {"abc", "\"130 bananas\"", "nan", "-3", "5"})
    {
        const Outcome outcome =
            shell(kSolve + "--out " + out + "/none --ear-limit=" + std::string(wrong));
        EXPECT_NE(outcome.code, 0) << wrong;
        EXPECT_NE(outcome.output.find("0 or 20 .. 200"), std::string::npos) << outcome.output;
    }
    const std::pair<const char*, const char*> files[] = {
        {"x_m,y_m\n0,0\n", ":1: there is no column z_m"},
        {"x_m,y_m,z_m\n0,0,oops\n", ":2: z_m is 'oops', it must be a finite number"},
        {"x_m,y_m,z_m\n0,nan,0\n", ":2: y_m is 'nan', it must be a finite number"},
        {"x_m,y_m,z_m\n", ": there are no places below the header"}};
    for (const auto& [text, told] : files)
    {
        const std::string places = written(out + "/ears.csv", text);
        const Outcome outcome = shell(kSolve + "--out " + out + "/none --ears " + places);
        EXPECT_EQ(outcome.code, 2);
        EXPECT_NE(outcome.output.find(told), std::string::npos) << outcome.output;
    }
    EXPECT_FALSE(fs::exists(out + "/none"));
}
