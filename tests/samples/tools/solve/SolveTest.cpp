// midair-solve run as a user runs it, and its files recomputed by a model written here, apart from
// the product's.

#include "tests/samples/Shell.h"
#include "tests/samples/tools/solve/PublishedDirectivity.h"
#include "tests/samples/tools/solve/SolveOutput.h"

#include <algorithm>
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
const std::string kStar = MIDAIR_ROOT "/samples/models/star.obj";

std::string folder(const std::string& name)
{
    std::string path = testing::TempDir() + "midair-solve-" + name;
    fs::remove_all(path);
    return path;
}

/// |p| at one row of control_points.csv from all rows of drive.csv and the constants of
/// summary.json.
double recomputed_Pa(const std::vector<double>& point,
                     const std::vector<std::vector<double>>& drive,
                     const nlohmann::json& summary)
{
    const double k = 2 * M_PI * summary.at("frequency_Hz").get<double>() /
                     summary.at("soundSpeed_m_s").get<double>();
    const double beta = summary.at("attenuation_Np_m").get<double>();
    const double P0 = summary.at("sourceAmplitude_Pa_m").get<double>();
    std::complex<double> p = 0.0;
    for (const auto& t : drive)
    {
        const double d[3] = {point[0] - t[0], point[1] - t[1], point[2] - t[2]};
        const double R = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        const double cosTheta = (d[0] * t[3] + d[1] * t[4] + d[2] * t[5]) / R;
        p += P0 * publishedDirectivity(cosTheta) / R * std::exp(-beta * R) *
             std::sin(M_PI * t[7] / 510.0) * std::polar(1.0, -k * R + 2 * M_PI * t[6] / 256.0);
    }
    return std::abs(p);
}

/// Every file is there, and the pressures that it states are those that its drive makes.
void expectFilesAgree(const std::string& out)
{
    std::string header;
    const auto points = readCsv(out + "/control_points.csv", &header);
    EXPECT_EQ(header, "x_m,y_m,z_m,nx,ny,nz,target_Pa,achieved_Pa");
    const auto drive = readCsv(out + "/drive.csv", &header);
    EXPECT_EQ(header, "x_m,y_m,z_m,nx,ny,nz,phase_level,duty_level");
    ASSERT_EQ(drive.size(), 3984u);
    const nlohmann::json summary = readSummary(out);
    EXPECT_EQ(summary.at("directivity"), "t4010a1-harmonics");
    ASSERT_EQ(points.size(), summary.at("report").at("points").get<std::size_t>());
    ASSERT_FALSE(points.empty());

    double sum = 0.0;
    for (const auto& point : points)
    {
        const double expected = recomputed_Pa(point, drive, summary);
        EXPECT_NEAR(point[7], expected, 1e-3 * expected);
        const double error = point[7] / point[6] - 1.0;
        sum += error * error;
    }
    // The report is computed in float, with the drive as it is rounded: 0.01 % absolute.
    EXPECT_NEAR(std::sqrt(sum / double(points.size())), summary.at("report").at("rms"), 1e-4);
    EXPECT_GT(fs::file_size(out + "/field.png"), 10000u);
}

TEST(Solve, StarFilesAgreeWithARecomputation)
{
    const std::string out = folder("star");
    const Outcome outcome = shell(kProgram + " " + kStar + " --size 0.08 --out " + out);
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    expectFilesAgree(out);
}

TEST(Solve, CertifiesTheFieldOnRequest)
{
    const std::string out = folder("certify");
    const Outcome outcome = shell(kProgram + " " + kStar + " --size 0.08 --certify --out " + out);
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("\ncertificate "), std::string::npos);
    const nlohmann::json certificate = readSummary(out).at("certificate");
    const double bound = certificate.at("bound"), best = certificate.at("best");
    EXPECT_GT(bound, 0.0);
    EXPECT_LE(bound, best);
    EXPECT_LE(best, certificate.at("phases").get<double>());
    EXPECT_LE(bound, certificate.at("field").get<double>());
}

// Misfit and lambda times power: the more the power counts, the higher is the least of both.
TEST(Solve, CertifiesWithTheRegularisationThatIsGiven)
{
    const auto boundOf = [](const std::string& lambda)
    {
        const std::string out = folder("certify");
        const Outcome outcome = shell(kProgram + " " + kStar + " --size 0.04 --max-points 20" +
                                      " --certify " + lambda + " --out " + out);
        EXPECT_EQ(outcome.code, 0) << outcome.output;
        return readSummary(out).at("certificate").at("bound").get<double>();
    };
    const double bound = boundOf("");
    EXPECT_EQ(boundOf("--lambda 0.1"), bound);
    EXPECT_GT(boundOf("--lambda 1"), 1.2 * bound);
    EXPECT_LT(boundOf("--lambda 0.01"), bound / 1.2);
    const Outcome none =
        shell(kProgram + " " + kStar + " --certify --lambda 0 --out " + folder("certify"));
    EXPECT_NE(none.code, 0);
    EXPECT_NE(none.output.find("lambdaRel is 0"), std::string::npos) << none.output;
}

TEST(Solve, RealMeshesAgreeWithARecomputation)
{
    const fs::path meshes = fs::path(MIDAIR_ROOT).parent_path() / "shared" / "meshes";
    if (!fs::exists(meshes)) GTEST_SKIP() << "no folder " << meshes;
    for (const auto& entry : fs::directory_iterator(meshes))
    {
        SCOPED_TRACE(entry.path().filename());
        const std::string out = folder(entry.path().stem());
        const Outcome outcome =
            shell(kProgram + " " + entry.path().string() + " --size 0.08 --out " + out);
        ASSERT_EQ(outcome.code, 0) << outcome.output;
        expectFilesAgree(out);
    }
}

TEST(Solve, EverySolverPlaysTheStar)
{
    const Outcome help = shell(kProgram + " --help");
    for (const std::string name : {"gs", "sdp-bcd"})
    {
        SCOPED_TRACE(name);
        EXPECT_NE(help.output.find(name), std::string::npos);
        const std::string out = folder(name);
        const Outcome outcome =
            shell(kProgram + " " + kStar + " --size 0.08 --sampling vertices --solver " + name +
                  " --out " + out);
        ASSERT_EQ(outcome.code, 0) << outcome.output;
        EXPECT_EQ(readSummary(out).at("report").at("solver"), name);
        expectFilesAgree(out);
    }
}

TEST(Solve, NoPointGetsMoreThanTheCap)
{
    const std::string out = folder("cap");
    const std::string star = kProgram + " " + kStar + " --size 0.08 --out " + out;
    for (const std::string options : {" --max-pressure 500", " --pressure 2000 --max-pressure 500"})
    {
        SCOPED_TRACE(options);
        const Outcome outcome = shell(star + options);
        ASSERT_EQ(outcome.code, 0) << outcome.output;
        expectFilesAgree(out);
        double loudest_Pa = 0.0;
        for (const auto& point : readCsv(out + "/control_points.csv"))
            loudest_Pa = std::max(loudest_Pa, point[7]);
        EXPECT_LE(loudest_Pa, 500.0);
        EXPECT_GT(loudest_Pa, 430.0); // a level of the drive is 8 % there
        const nlohmann::json report = readSummary(out).at("report");
        EXPECT_LT(report.at("capFactor").get<double>(), 0.3);
        EXPECT_LT(report.at("level_Pa").get<double>(), 500.0);
    }
}

TEST(Solve, NoPointGetsMoreThanTheCapFromFieldsInTurn)
{
    const std::string out = folder("capInTurn");
    // A level of the drive is 8 % there, and fields differ; of evened ones this is what is felt.
    for (const auto& [options, least_Pa] :
         std::vector<std::pair<std::string, double>>{{" --cycle 3 --even 0", 250.0},
                                                     {" --cycle 3", 180.0},
                                                     {" --subsets 2", 250.0},
                                                     {" --outline", 250.0}})
    {
        SCOPED_TRACE(options);
        const Outcome outcome = shell(kProgram + " " + kStar + " --size 0.06 --max-pressure 400" +
                                      options + " --out " + out);
        ASSERT_EQ(outcome.code, 0) << outcome.output;
        double loudest_Pa = 0.0;
        for (const auto& point : readCsv(out + "/control_points.csv"))
            loudest_Pa = std::max(loudest_Pa, point[7]);
        EXPECT_LE(loudest_Pa, 400.0);
        EXPECT_GT(loudest_Pa, least_Pa);
        EXPECT_LT(readSummary(out).at("report").at("capFactor").get<double>(), 1.0);
    }
}

TEST(Solve, OptionsThatWouldDoNothingAreRefused)
{
    for (const std::string options :
         {"--outline --solver gs", "--outline --even 3", "--cycle-steps 4", "--outline --cycle 2"})
    {
        const Outcome outcome = shell(kProgram + " " + kStar + " " + options);
        EXPECT_NE(outcome.code, 0) << options;
        EXPECT_NE(outcome.output.find(options.substr(0, options.find(' '))), std::string::npos)
            << outcome.output;
    }
}

TEST(Solve, ASingleFieldIsEvenedOutOnRequest)
{
    const std::string plain = folder("plain"), evened = folder("evened");
    ASSERT_EQ(shell(kProgram + " " + kStar + " --size 0.06 --out " + plain).code, 0);
    ASSERT_EQ(shell(kProgram + " " + kStar + " --size 0.06 --even 8 --out " + evened).code, 0);
    const nlohmann::json a = readSummary(plain), b = readSummary(evened);
    EXPECT_FALSE(a.contains("evened"));
    EXPECT_TRUE(b.contains("evened"));
    EXPECT_LT(b["surface"]["coefficientOfVariation"].get<double>(),
              0.7 * a["surface"]["coefficientOfVariation"].get<double>());
    EXPECT_GT(b["surface"]["mean_Pa"].get<double>(), 0.97 * a["surface"]["mean_Pa"].get<double>());
    // Its figures are of what is played, which no longer meets the points.
    EXPECT_GT(b["report"]["rms"].get<double>(), 10.0 * a["report"]["rms"].get<double>());
    const Outcome vertices = shell(kProgram + " " + kStar + " --sampling vertices --even 8");
    EXPECT_NE(vertices.code, 0);
    EXPECT_NE(vertices.output.find("--even"), std::string::npos) << vertices.output;
}

TEST(Solve, FieldsInTurnAreWrittenAndMeasured)
{
    const std::string one = folder("one"), many = folder("cycle"), subsets = folder("subsets");
    ASSERT_EQ(shell(kProgram + " " + kStar + " --size 0.06 --out " + one).code, 0);
    const Outcome cycle =
        shell(kProgram + " " + kStar + " --size 0.06 --cycle 4 --cycle-steps 1 --out " + many);
    ASSERT_EQ(cycle.code, 0) << cycle.output;
    EXPECT_NE(cycle.output.find("8 fields at 1000/s"), std::string::npos) << cycle.output;
    EXPECT_EQ(readCsv(many + "/drive_08.csv").size(), 3984u);
    EXPECT_FALSE(fs::exists(many + "/drive_09.csv"));
    EXPECT_FALSE(fs::exists(many + "/drive.csv"));
    const nlohmann::json a = readSummary(one), b = readSummary(many);
    EXPECT_EQ(b["fields"], 8);
    EXPECT_LT(b["surface"]["coefficientOfVariation"].get<double>(),
              0.75 * a["surface"]["coefficientOfVariation"].get<double>());
    EXPECT_GT(b["surface"]["contrast"].get<double>(), 1.0);
    EXPECT_GT(b["report"]["audibleChange"].get<double>(), 0.0);
    EXPECT_GT(readCsv(many + "/control_points.csv").size(),
              2 * readCsv(one + "/control_points.csv").size());

    ASSERT_EQ(shell(kProgram + " " + kStar + " --size 0.06 --subsets 3 --out " + subsets).code, 0);
    const nlohmann::json c = readSummary(subsets);
    EXPECT_EQ(c["fields"], 3);
    EXPECT_GT(c["report"]["level_Pa"].get<double>(), 1.3 * a["report"]["level_Pa"].get<double>());
}

TEST(Solve, EdgesAreOneSmoothField)
{
    const std::string points = folder("edge-points"), dense = folder("outline");
    const std::string square = " --size 0.05 ";
    ASSERT_EQ(shell(kProgram + " " + kStar + square + "--sampling edges --out " + points).code, 0);
    const Outcome outline = shell(kProgram + " " + kStar + square + "--outline --out " + dense);
    ASSERT_EQ(outline.code, 0) << outline.output;
    EXPECT_LT(readSummary(dense)["surface"]["coefficientOfVariation"].get<double>(),
              readSummary(points)["surface"]["coefficientOfVariation"].get<double>());
    EXPECT_EQ(readSummary(dense)["report"]["solver"], "outline");
}

TEST(Solve, LoudnessBeyondOneIsLouderAndLessAccurate)
{
    const std::string one = folder("loud-1"), more = folder("loud-2");
    ASSERT_EQ(shell(kProgram + " " + kStar + " --size 0.08 --out " + one).code, 0);
    ASSERT_EQ(shell(kProgram + " " + kStar + " --size 0.08 --loudness 1.5 --out " + more).code, 0);
    const nlohmann::json a = readSummary(one)["report"], b = readSummary(more)["report"];
    EXPECT_GT(b["loudness"].get<double>(), a["loudness"].get<double>());
    EXPECT_GT(b["rms"].get<double>(), 5.0 * a["rms"].get<double>());
}

TEST(Solve, APressureIsPlayedOrTheReachableOneNamed)
{
    const std::string out = folder("pressure");
    const std::string star = kProgram + " " + kStar + " --size 0.08 --out " + out;
    ASSERT_EQ(shell(star + " --pressure 2000").code, 0);
    expectFilesAgree(out);
    for (const auto& point : readCsv(out + "/control_points.csv"))
        EXPECT_EQ(point[6], 2000.0);
    EXPECT_NEAR(readSummary(out).at("report").at("level_Pa"), 2000.0, 20.0);

    const Outcome tooMuch = shell(star + " --pressure 50000");
    EXPECT_EQ(tooMuch.code, 0);
    EXPECT_NE(tooMuch.output.find("note"), std::string::npos) << tooMuch.output;
    EXPECT_LT(readSummary(out).at("report").at("level_Pa").get<double>(), 20000.0);
}

TEST(Solve, PointsFromAFile)
{
    const std::string csv = testing::TempDir() + "midair-points.csv";
    std::ofstream(csv) << "x_m,y_m,z_m,nx,ny,nz,target\n-0.01,0,0,0,0,2,1\n\n0.01,0,0,0,0,1,0.5\n";
    const std::string out = folder("points");
    ASSERT_EQ(shell(kProgram + " --points-file " + csv + " --out " + out).code, 0);
    expectFilesAgree(out);
    const auto points = readCsv(out + "/control_points.csv");
    ASSERT_EQ(points.size(), 2u);
    EXPECT_NEAR(points[1][6] / points[0][6], 0.5, 1e-6);
    EXPECT_EQ(points[0][5], 1.0); // made a unit vector

    std::ofstream(csv) << "x_m,y_m,z_m,nx,ny,nz,target_Pa\n0,0,0,0,1,0,1500\n";
    ASSERT_EQ(shell(kProgram + " --points-file " + csv + " --out " + out).code, 0);
    EXPECT_EQ(readCsv(out + "/control_points.csv")[0][6], 1500.0);
    EXPECT_NEAR(readCsv(out + "/control_points.csv")[0][7], 1500.0, 15.0);
}

TEST(Solve, WhatIsWrongIsNamed)
{
    const std::string csv = testing::TempDir() + "midair-broken.csv";
    const std::string solve = kProgram + " --points-file " + csv;
    std::ofstream(csv) << "x_m,y_m,nx,ny,nz,target\n";
    EXPECT_NE(shell(solve).output.find(csv + ":1: there is no column z_m"), std::string::npos);
    std::ofstream(csv) << "x_m,y_m,z_m,nx,ny,nz,target\n0,0,0,0,1,0,1\n0,nan,0,0,1,0,1\n";
    EXPECT_EQ(shell(solve).output,
              "midair-solve: " + csv + ":3: y_m is 'nan', it must be a finite number\n");
    std::ofstream(csv) << "x_m,y_m,z_m,nx,ny,nz,target\n0,0,0,0,0,0,1\n";
    EXPECT_EQ(shell(solve).output, "midair-solve: " + csv + ":2: the normal nx,ny,nz is zero\n");
    std::ofstream(csv) << "x_m,y_m,z_m,nx,ny,nz,target\n";
    EXPECT_EQ(shell(solve).output,
              "midair-solve: " + csv + ": there are no control points below the header\n");

    EXPECT_EQ(shell(kProgram).code, 2);
    EXPECT_EQ(shell(kProgram + " /no/such.obj").code, 2);
    EXPECT_NE(shell(kProgram + " /no/such.obj").output.find("/no/such.obj"), std::string::npos);
    EXPECT_NE(shell(kProgram + " " + kStar + " --solver best").output.find("best"),
              std::string::npos);
    EXPECT_NE(shell(kProgram + " " + kStar + " --temperature 100").output.find("100"),
              std::string::npos);
    EXPECT_NE(shell(kProgram + " " + kStar + " --size -1").code, 0);
}

TEST(Solve, SaysThatItReadsObjAlone)
{
    for (const std::string file : {MIDAIR_ROOT "/samples/models/panel.gltf", "nowhere.STL"})
    {
        const Outcome other = shell(kProgram + " " + file);
        EXPECT_EQ(other.code, 2) << other.output;
        for (const char* said : {".obj", "midair-check", "midair-demo"})
            EXPECT_NE(other.output.find(said), std::string::npos) << other.output;
    }
    EXPECT_NE(shell(kProgram + " --help").output.find(".obj"), std::string::npos);
}

TEST(Solve, NeedsNoSceneGraphButForItsPicture)
{
    const Outcome needed = shell("ldd " + kProgram);
    ASSERT_EQ(needed.code, 0) << needed.output;
    ASSERT_NE(needed.output.find("libstdc++"), std::string::npos);
    for (const std::string library : {"libosg", "libOpenThreads", "Bullet", "openxr", "libGL"})
        EXPECT_EQ(needed.output.find(library), std::string::npos) << needed.output;
    // By itself it does all but draw, and says so.
    const std::string out = folder("alone");
    fs::create_directories(out);
    fs::copy_file(kProgram, out + "/midair-solve");
    EXPECT_EQ(shell(out + "/midair-solve --help").code, 0);
    const Outcome alone =
        shell(out + "/midair-solve " + kStar + " --size 0.05 --probe-points --duration 0.1 --out " +
              out + "/result");
    EXPECT_EQ(alone.code, 0) << alone.output;
    EXPECT_NE(alone.output.find("no picture is drawn: midair-picture.so isn't there"),
              std::string::npos)
        << alone.output;
    EXPECT_TRUE(fs::exists(out + "/result/drive.csv"));
    EXPECT_FALSE(fs::exists(out + "/result/field.png"));
    EXPECT_TRUE(fs::exists(out + "/result/probe.png"));
}

TEST(Solve, AnObjectOutsideTheArrayIsSilence)
{
    const std::string out = folder("outside");
    const Outcome outcome =
        shell(kProgram + " " + kStar + " --size 0.08 --position 3 0 0 --out " + out);
    EXPECT_EQ(outcome.code, 1);
    EXPECT_NE(outcome.output.find("0 of "), std::string::npos) << outcome.output;
    EXPECT_EQ(readSummary(out).at("report").at("points"), 0);
    for (const auto& row : readCsv(out + "/drive.csv"))
        ASSERT_EQ(row[7], 0.0);
}

} // namespace
