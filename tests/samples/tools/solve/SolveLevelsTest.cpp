// midair-solve with arrays of any number of levels: the figures that it writes are those of the
// levels that it writes, recomputed here in double and apart from the product's code; and what it
// says of caps and of crowds is what it does.

#include "tests/samples/Shell.h"
#include "tests/samples/tools/solve/PublishedDirectivity.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace
{

namespace fs = std::filesystem;
using Json = nlohmann::json;

const std::string kProgram = MIDAIR_BIN "/midair-solve";
const std::string kStar = MIDAIR_ROOT "/samples/models/star.obj";

/// The columns of a CSV file by name.
struct Table
{
    std::vector<std::string> names;
    std::vector<std::vector<double>> rows;

    /// Column of \a name, or of the one that begins with it; -1: none.
    int column(const std::string& name) const
    {
        for (std::size_t i = 0; i < names.size(); ++i)
            if (names[i].rfind(name, 0) == 0) return static_cast<int>(i);
        return -1;
    }
};

Table readTable(const std::string& path)
{
    std::ifstream file(path);
    Table table;
    std::string line;
    std::getline(file, line);
    std::stringstream header(line);
    for (std::string name; std::getline(header, name, ',');)
        table.names.push_back(name);
    while (std::getline(file, line))
    {
        std::stringstream cells(line);
        auto& row = table.rows.emplace_back();
        for (std::string cell; std::getline(cells, cell, ',');)
            row.push_back(std::stod(cell));
    }
    return table;
}

/// The activation of a row of drive.csv by the documented meaning of its columns.
std::complex<double> activation(const Table& drive, const std::vector<double>& row, const Json& all)
{
    const double phases = all.at("phaseLevels");
    const double level = row[static_cast<std::size_t>(drive.column("phase_level"))];
    EXPECT_GE(level, 0.0);
    EXPECT_LT(level, phases);
    double amplitude = 0.0;
    if (const int duty = drive.column("duty_level"); duty >= 0)
        amplitude = std::sin(M_PI * row[static_cast<std::size_t>(duty)] / 510.0);
    else
    {
        const auto index =
            static_cast<int>(row[static_cast<std::size_t>(drive.column("amplitude_level_of"))]);
        amplitude = index < 0 ? 0.0 : all.at("amplitudeLevels").at(index).get<double>();
    }
    return std::polar(amplitude, 2 * M_PI * level / phases);
}

double
pressure_Pa(const std::vector<double>& point, const Table& drive, const Json& all, double& inPhase)
{
    const double k =
        2 * M_PI * all.at("frequency_Hz").get<double>() / all.at("soundSpeed_m_s").get<double>();
    std::complex<double> p = 0.0;
    inPhase = 0.0;
    for (const auto& t : drive.rows)
    {
        const double d[3] = {point[0] - t[0], point[1] - t[1], point[2] - t[2]};
        const double R = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        const double cosine = (d[0] * t[3] + d[1] * t[4] + d[2] * t[5]) / R;
        const double directed = directivity(all.at("directivity"), cosine);
        const double reached = all.at("sourceAmplitude_Pa_m").get<double>() / R * directed *
                               std::exp(-all.at("attenuation_Np_m").get<double>() * R);
        p += reached * activation(drive, t, all) * std::polar(1.0, -k * R);
        inPhase += reached;
    }
    return std::abs(p);
}

class SolveLevels : public testing::Test
{
protected:
    SolveLevels() : _folder(testing::TempDir() + "midair-levels-" + std::to_string(::getpid()))
    {
        fs::create_directories(_folder);
    }
    ~SolveLevels() override { fs::remove_all(_folder); }

    std::string out() const { return _folder + "/out"; }

    /// A square array of 256 below the middle, with \a more keys.
    std::string array(const std::string& more, const std::string& source = "5")
    {
        const std::string path = _folder + "/array" + std::to_string(_arrays++) + ".json";
        std::ofstream(path) << R"({"frequency_Hz": 40000, "directivity": "point", )"
                            << R"("sourceAmplitude_Pa_m": )" << source << ", " << more
                            << R"("boards": [{"position_m": [0, -0.1, 0], "normal": [0, 1, 0], )"
                            << R"("columns": 16, "rows": 16, "pitch_m": 0.0105}]})";
        return " --array " + path;
    }

    std::string points(const std::string& rows) const
    {
        const std::string path = _folder + "/points.csv";
        std::ofstream(path) << "x_m,y_m,z_m,nx,ny,nz,target\n" << rows;
        return " --points-file " + path;
    }

    Outcome solve(const std::string& what) const
    {
        fs::remove_all(out());
        return shell(kProgram + " " + what + " --out " + out());
    }

    Json summary() const { return Json::parse(std::ifstream(out() + "/summary.json")); }
    Json report() const { return summary().at("report"); }

    /// Compares every figure of a single field of equal relative targets with its drive.
    void expectFiguresOfTheDrive() const
    {
        const Json all = summary();
        const Table drive = readTable(out() + "/drive.csv");
        const Table table = readTable(out() + "/control_points.csv");
        ASSERT_EQ(drive.rows.size(), all.at("transducers").get<std::size_t>());
        const auto n = static_cast<double>(table.rows.size());
        ASSERT_GT(n, 3.0);
        std::vector<double> y;
        double level = 0.0, rowSums = 0.0;
        for (const auto& point : table.rows)
        {
            double inPhase = 0.0;
            y.push_back(pressure_Pa(point, drive, all, inPhase));
            rowSums += inPhase / n;
            level += y.back() / n;
            EXPECT_NEAR(point[7], y.back(), 1e-5 * y.back());
        }
        double squares = 0.0, largest = 0.0;
        for (const double one : y)
        {
            squares += std::pow(one / level - 1.0, 2);
            largest = std::max(largest, std::abs(one / level - 1.0));
        }
        const double rms = std::sqrt(squares / n);
        const Json& report = all.at("report");
        EXPECT_NEAR(report.at("rms").get<double>(), rms, 1e-3 * rms + 1e-7);
        EXPECT_NEAR(report.at("max").get<double>(), largest, 1e-3 * largest + 1e-7);
        EXPECT_NEAR(report.at("level_Pa").get<double>(), level, 1e-5 * level);
        EXPECT_NEAR(report.at("loudness").get<double>(),
                    level * std::sqrt(n) / rowSums,
                    1e-3 * report.at("loudness").get<double>());
    }

private:
    std::string _folder;
    int _arrays = 0;
};

} // namespace

TEST_F(SolveLevels, FiguresAreThoseOfTheWrittenDrive)
{
    const std::string model = kStar + " --size 0.04";
    const std::string duties = "x_m,y_m,z_m,nx,ny,nz,phase_level,duty_level";
    const std::string of = "x_m,y_m,z_m,nx,ny,nz,phase_level_of_";
    const std::string coarse = R"("phaseLevels": 100, "amplitudeLevels": [0.1, 0.5, 1], )";
    const std::string above = " --position 0 0 0.1 --rotation-deg 90 0 0 --array ";
    struct Case
    {
        std::string options, header;
    };
    for (const Case& one : {Case{array(""), duties},
                            Case{array(R"("phaseLevels": 256, )"), duties},
                            Case{array(R"("phaseLevels": 100, )"), of + "100,duty_level"},
                            Case{array(R"("phaseLevels": 65536, )"), duties},
                            Case{array(R"("phaseLevels": 0, )"), duties},
                            Case{array(coarse), of + "100,amplitude_level_of_3"},
                            Case{above + "ultraino64", of + "10,amplitude_level_of_6"},
                            Case{above + "sonicsurface", of + "32,amplitude_level_of_2"},
                            Case{above + "openmpd", of + "128,amplitude_level_of_65"}})
        for (const std::string more : {"", " --loudness 0.4", " --no-phase-only"})
        {
            // An emitter that is on or off can't play 0.4 of what it can.
            if (more == " --loudness 0.4" && one.header == of + "32,amplitude_level_of_2") continue;
            SCOPED_TRACE(one.header + one.options + more);
            const Outcome outcome = solve(model + one.options + more);
            ASSERT_EQ(outcome.code, 0) << outcome.output;
            std::string header;
            std::ifstream drive(out() + "/drive.csv");
            std::getline(drive, header);
            EXPECT_EQ(header, one.header);
            expectFiguresOfTheDrive();
        }
}

TEST_F(SolveLevels, FinerPhasesThanADriveHasAreTold)
{
    const std::string model = kStar + " --size 0.04";
    const std::string told = "using 256";
    EXPECT_NE(solve(model + array(R"("phaseLevels": 65536, )")).output.find(told),
              std::string::npos);
    EXPECT_EQ(summary().at("phaseLevels"), 256);
    EXPECT_EQ(solve(model + array(R"("phaseLevels": 100, )")).output.find(told), std::string::npos);
}

TEST_F(SolveLevels, ACapThatSilencesIsToldWithTheFiguresOfSilence)
{
    const std::string star = kStar + " --size 0.04" + array("");
    for (const std::string turns : {"", " --cycle 2", " --outline"})
    {
        SCOPED_TRACE(turns);
        const Outcome outcome = solve(star + turns + " --max-pressure 0.01");
        EXPECT_EQ(outcome.code, 1) << outcome.output;
        EXPECT_NE(outcome.output.find("silenced"), std::string::npos) << outcome.output;
        EXPECT_EQ(outcome.output.find("converged"), std::string::npos) << outcome.output;
        const Json silent = report();
        EXPECT_EQ(silent.at("stop"), "silenced");
        EXPECT_EQ(silent.at("capFactor"), 0.0);
        for (const char* name : {"level_Pa", "loudness"})
            EXPECT_EQ(silent.at(name), 0.0) << name;
        for (const char* name : {"rms", "max"})
            EXPECT_EQ(silent.at(name), 1.0) << name;
        for (const auto& row : readTable(out() + "/control_points.csv").rows)
            EXPECT_EQ(row[7], 0.0);
        // The pressure that the message names is enough, and no lower one would do.
        const std::string message = silent.at("message");
        const std::size_t at = message.find("gives up to ");
        ASSERT_NE(at, std::string::npos) << message;
        const double least_Pa = std::stod(message.substr(at + 12));
        for (const double share : {0.9, 1.1})
            EXPECT_EQ(
                solve(star + turns + " --max-pressure " + std::to_string(share * least_Pa)).code,
                share < 1.0 ? 1 : 0);
    }
}

TEST_F(SolveLevels, TargetsBelowTheLowestLevelAreSilenceThatIsTold)
{
    for (const std::string turns : {"", " --cycle 2", " --outline"})
    {
        SCOPED_TRACE(turns);
        const Outcome outcome = solve(kStar + " --size 0.04 --pressure 0.001" + turns + array(""));
        EXPECT_EQ(outcome.code, 1) << outcome.output;
        const Json silent = report();
        EXPECT_EQ(silent.at("level_Pa"), 0.0);
        EXPECT_EQ(silent.at("rms"), 1.0);
        EXPECT_EQ(silent.at("worstShortfall"), 1.0);
        EXPECT_NE(silent.at("message"), "");
        EXPECT_NE(outcome.output.find("note"), std::string::npos) << outcome.output;
    }
}

TEST_F(SolveLevels, ACapThatLeavesCoarseAmplitudesIsToldAndRated)
{
    // Weak and strong transducers fall to the same few levels.
    const std::string star =
        kStar + " --size 0.04 --no-phase-only" + array(R"("amplitudeLevels": [0, 0.1, 0.3, 1], )");
    ASSERT_EQ(solve(star).code, 0);
    const Json whole = report();
    const Outcome outcome = solve(star + " --max-pressure 600");
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    const Json capped = report();
    EXPECT_LT(capped.at("capFactor").get<double>(), 1.0);
    EXPECT_LT(capped.at("level_Pa").get<double>(), 600.0);
    EXPECT_GT(capped.at("rms").get<double>(), 1.5 * whole.at("rms").get<double>());
    EXPECT_NE(capped.at("message").get<std::string>().find("coarse"), std::string::npos);
    EXPECT_NE(capped.at("stop"), "converged");
    expectFiguresOfTheDrive();
}

TEST_F(SolveLevels, TargetsThatTheCapDoesNotLetBeReachedAreTold)
{
    const Outcome outcome =
        solve(kStar + " --size 0.04 --pressure 1000 --max-pressure 300" + array(""));
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    const Json capped = report();
    EXPECT_EQ(capped.at("shortPoints"), capped.at("points"));
    EXPECT_GT(capped.at("worstShortfall").get<double>(), 0.69);
    EXPECT_NE(capped.at("stop"), "converged");
    EXPECT_NE(outcome.output.find("the cap of 300 Pa leaves "), std::string::npos)
        << outcome.output;
}

TEST_F(SolveLevels, AnOutlineIsAsLoudAsItsDrive)
{
    ASSERT_EQ(solve(kStar + " --size 0.04 --outline" + array("")).code, 0);
    EXPECT_GT(report().at("loudness").get<double>(), 0.1);
    expectFiguresOfTheDrive();
}

TEST_F(SolveLevels, CrowdedPointsOfAFileAreTreatedAsAsked)
{
    // Two 1 mm apart, one alone.
    const std::string file =
        points("0,0,0,0,1,0,1\n0.001,0,0,0,1,0,1\n0.03,0,0,0,1,0,1\n") + array("");
    const auto left = [&](const std::string& crowding)
    {
        EXPECT_EQ(solve(file + crowding).code, 0);
        return report().at("points").get<int>();
    };
    EXPECT_EQ(left(""), 3);
    EXPECT_EQ(left(" --crowding thin"), 2);
    EXPECT_EQ(left(" --crowding merge"), 2);
    const Table merged = readTable(out() + "/control_points.csv");
    EXPECT_NEAR(merged.rows[0][0], 0.0005, 1e-9);
    EXPECT_EQ(left(" --crowding drop"), 1);
    for (const std::string option : {"--size 0.1", "--spacing 0.01", "--pressure 200"})
    {
        const Outcome outcome = solve(file + " " + option);
        EXPECT_EQ(outcome.code, 2) << outcome.output;
        EXPECT_NE(outcome.output.find(option.substr(0, option.find(' '))), std::string::npos);
    }
    EXPECT_EQ(solve(kStar + " --outline --crowding drop").code, 2);
}

TEST_F(SolveLevels, AFaintArrayIsCertifiedLikeALoudOne)
{
    const std::string star = kStar + " --size 0.04 --certify";
    ASSERT_EQ(solve(star + array("")).code, 0);
    const Json loud = summary().at("certificate");
    const Json loudReport = report();
    const Outcome outcome = solve(star + array("", "1e-30"));
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    const Json faint = summary().at("certificate");
    for (const char* name : {"bound", "best"})
        EXPECT_NEAR(faint.at(name).get<double>() / loud.at(name).get<double>(), 1.0, 1e-6) << name;
    EXPECT_GE(faint.at("field").get<double>(), faint.at("bound").get<double>());
    // And solved for like it; its other figures are these in units of its own.
    for (const char* name : {"rms", "max", "loudness"})
        EXPECT_NEAR(report().at(name).get<double>(), loudReport.at(name).get<double>(), 1e-3)
            << name;
    const double level_Pa = loudReport.at("level_Pa");
    EXPECT_NEAR(report().at("level_Pa").get<double>() / 1e-30 * 5.0, level_Pa, 1e-3 * level_Pa);
}
