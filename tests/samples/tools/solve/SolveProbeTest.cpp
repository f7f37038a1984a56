// midair-solve --probe as a user runs it; what its files say is recomputed by a model written here.

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

const std::string kProgram = MIDAIR_BIN "/midair-solve";
const std::string kStar = MIDAIR_ROOT "/samples/models/star.obj --size 0.08 --sampling vertices";

std::string folder(const std::string& name)
{
    std::string path = testing::TempDir() + "midair-solve-probe-" + name;
    fs::remove_all(path);
    return path;
}

std::vector<std::vector<double>> readTable(const std::string& path, const std::string& header)
{
    EXPECT_TRUE(fs::exists(path)) << path;
    std::string found;
    auto rows = readCsv(path, &found);
    EXPECT_EQ(found, header);
    return rows;
}

std::vector<std::vector<double>> readDrive(const std::string& path)
{
    return readTable(path, "x_m,y_m,z_m,nx,ny,nz,phase_level,duty_level");
}

// The envelope of each transducer from the drives alone, which are played in turn for ever.
std::complex<double> heard_Pa(const std::vector<double>& point,
                              double time_s,
                              const std::vector<std::vector<std::vector<double>>>& drives,
                              const nlohmann::json& summary)
{
    const double c = summary.at("soundSpeed_m_s");
    const double k = 2 * M_PI * summary.at("frequency_Hz").get<double>() / c;
    const double beta = summary.at("attenuation_Np_m");
    const double P0 = summary.at("sourceAmplitude_Pa_m");
    const double tau = summary.at("ringing_s");
    const double T = 1.0 / summary.at("fieldRate_Hz").get<double>();
    std::complex<double> p = 0.0;
    for (std::size_t i = 0; i < drives[0].size(); ++i)
    {
        const auto& t = drives[0][i];
        const double d[3] = {point[0] - t[0], point[1] - t[1], point[2] - t[2]};
        const double R = std::hypot(d[0], d[1], d[2]);
        const double cosTheta = (d[0] * t[3] + d[1] * t[4] + d[2] * t[5]) / R;
        const double heard_s = time_s - R / c;
        const int now = static_cast<int>(std::floor(heard_s / T));
        std::complex<double> a = 0.0;
        for (int step = now - 20; step <= now; ++step)
        {
            const int N = static_cast<int>(drives.size());
            const auto& row = drives[std::size_t(((step % N) + N) % N)][i];
            const auto q = std::polar(std::sin(M_PI * row[7] / 510.0), 2 * M_PI * row[6] / 256.0);
            const double for_s = step == now ? heard_s - now * T : T;
            a = q + (a - q) * std::exp(-for_s / tau);
        }
        p += P0 * publishedDirectivity(cosTheta) / R * std::exp(-beta * R) *
             std::polar(1.0, -k * R) * a;
    }
    return p;
}

TEST(SolveProbe, WritesWhatTheDrivesMakeOverTime)
{
    const std::string out = folder("cycle");
    const Outcome run = shell(kProgram + " " + kStar +
                              " --subsets 3 --probe 0 0 0 --probe 30mm 1cm 0 --duration 20ms "
                              "--ringing 250e-6 --out " +
                              out);
    ASSERT_EQ(run.code, 0) << run.output;
    EXPECT_NE(run.output.find("ringing     250 us: "), std::string::npos) << run.output;
    EXPECT_NE(run.output.find("probes      2 of 400 samples: "), std::string::npos) << run.output;
    const auto places =
        readTable(out + "/probe_points.csv", "point,x_m,y_m,z_m,mean_Pa,steadyMean_Pa");
    ASSERT_EQ(places.size(), 2u);
    EXPECT_EQ(std::vector<double>(places[1].begin(), places[1].begin() + 4),
              (std::vector<double>{1.0, 0.03, 0.01, 0.0}));
    const auto rows = readTable(out + "/probe.csv", "point,time_s,p_re_Pa,p_im_Pa,radiation_Pa");
    ASSERT_EQ(rows.size(), 800u);
    const nlohmann::json summary = readSummary(out);
    EXPECT_EQ(summary.at("ringing_s"), 250e-6);
    EXPECT_LT(summary.at("report").at("ringingShare"), 1.0);
    EXPECT_LE(summary.at("ringing").at("level_Pa"), summary.at("report").at("level_Pa"));
    std::vector<std::vector<std::vector<double>>> drives;
    for (int k = 1; k <= 3; ++k)
        drives.push_back(readDrive(out + "/drive_0" + std::to_string(k) + ".csv"));
    double largest_Pa = 0.0, off_Pa = 0.0;
    for (std::size_t l = 0; l < 2; ++l)
        for (std::size_t k = 0; k < 400; k += 37)
        {
            const auto& row = rows[400 * l + k];
            EXPECT_EQ(row[0], static_cast<double>(l));
            EXPECT_NEAR(row[1], static_cast<double>(k) / 20e3, 1e-12);
            const std::complex<double> heard =
                heard_Pa({places[l][1], places[l][2], places[l][3]}, row[1], drives, summary);
            largest_Pa = std::max(largest_Pa, std::abs(heard));
            off_Pa = std::max(off_Pa, std::abs(heard - std::complex<double>(row[2], row[3])));
        }
    EXPECT_GT(largest_Pa, 100.0);
    EXPECT_LT(off_Pa, 2e-4 * largest_Pa);
    const auto lines = readTable(out + "/spectrum.csv", "point,frequency_Hz,radiation_Pa");
    ASSERT_EQ(lines.size(), 2u * 201u);
    EXPECT_NEAR(lines[0][2], places[0][4], 1e-6 * places[0][4]) << "the mean";
    EXPECT_EQ(lines[1][1], 50.0);
}

TEST(SolveProbe, PatchesAndControlPointsAreProbed)
{
    const std::string out = folder("points");
    Outcome run = shell(kProgram + " " + kStar +
                        " --probe-points --duration 2ms --modulation 200 --out " + out);
    ASSERT_EQ(run.code, 0) << run.output;
    EXPECT_NE(run.output.find(" of the modulation"), std::string::npos) << run.output;
    const auto points =
        readTable(out + "/control_points.csv", "x_m,y_m,z_m,nx,ny,nz,target_Pa,achieved_Pa");
    const auto places =
        readTable(out + "/probe_points.csv", "point,x_m,y_m,z_m,mean_Pa,steadyMean_Pa");
    ASSERT_EQ(places.size(), points.size());
    EXPECT_EQ(places[3][1], points[3][0]);
    const nlohmann::json report = readSummary(out).at("report");
    EXPECT_LT(report.at("ringingModulation"), 1.0);
    EXPECT_FALSE(readSummary(out).contains("ringing")) << "no fields in turn";

    run = shell(kProgram + " " +
                MIDAIR_ROOT "/samples/models/star.obj --size 0.08 --probe 0 0 0 "
                            "--probe-patch 15mm --duration 1ms --out " +
                out);
    ASSERT_EQ(run.code, 0) << run.output;
    const auto patch =
        readTable(out + "/probe_points.csv", "point,x_m,y_m,z_m,mean_Pa,steadyMean_Pa");
    EXPECT_GT(patch.size(), 20u);
    for (const auto& place : patch)
        EXPECT_LE(std::hypot(place[1], place[2], place[3]), 0.015 + 1e-9);
}

TEST(SolveProbe, WhatIsWrongIsNamed)
{
    const auto wrong = [](const std::string& options)
    {
        const Outcome run =
            shell(kProgram + " " + kStar + " --out " + folder("wrong") + " " + options);
        EXPECT_NE(run.code, 0) << options;
        return run.output;
    };
    EXPECT_NE(wrong("--probe 0 0").find("--probe"), std::string::npos);
    EXPECT_NE(wrong("--probe 0 0 nan --duration 1ms").find("--probe: is \"nan\""),
              std::string::npos);
    EXPECT_NE(wrong("--probe 0 0 0 --duration -1").find("--duration"), std::string::npos);
    EXPECT_NE(wrong("--ringing 1").find("--ringing"), std::string::npos);
    EXPECT_NE(wrong("--ringing nan").find("--ringing"), std::string::npos);
    EXPECT_NE(wrong("--probe-patch 1mm").find("--probe-patch requires --probe"), std::string::npos);
    EXPECT_NE(wrong("--probe 0 0 0.2 --probe-patch 1mm").find("0.001 m of a --probe"),
              std::string::npos);
    EXPECT_NE(wrong("--probe-points --duration 1000").find("limit of 1e+07 samples"),
              std::string::npos);
}

} // namespace
