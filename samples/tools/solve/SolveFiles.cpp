#include "samples/tools/solve/SolveFiles.h"

#include "engine-bridge/solving/ArrayLevels.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <array>
#include <cmath>
#include <fstream>
#include <locale>
#include <sstream>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace midair::samples
{
namespace
{

using base::InputError;

constexpr std::size_t kMostBytes = std::size_t(64) << 20;
constexpr std::size_t kMostPoints = 100000;

std::vector<std::string> splitLine(std::string line)
{
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');)
    {
        cells.push_back(base::trimmed(cell));
    }
    return cells;
}

double
parseCell(const std::string& path, int line, const std::string& column, const std::string& text)
{
    double value = 0.0;
    if (!base::parseNumber(text, value))
        throw base::InputError(
            fmt::format("{}:{}: {} is '{}', it must be a finite number", path, line, column, text));
    return value;
}

/// Cells of a row that hold x_m, y_m, z_m, nx, ny, nz and the target, in this order.
struct Columns
{
    std::array<std::size_t, 7> cell{};
    std::array<std::string, 7> name{"x_m", "y_m", "z_m", "nx", "ny", "nz", "target_Pa"};
    bool absolute = true;
};

Columns readHeader(const std::string& path, const std::string& line)
{
    const std::vector<std::string> names = splitLine(line);
    const auto find = [&](const std::string& name)
    {
        for (std::size_t cell = 0; cell < names.size(); ++cell)
            if (names[cell] == name) return cell;
        return names.size();
    };
    Columns columns;
    if (find("target_Pa") == names.size())
    {
        columns.absolute = false;
        columns.name[6] = "target";
    }
    for (std::size_t i = 0; i < columns.name.size(); ++i)
    {
        columns.cell[i] = find(columns.name[i]);
        if (columns.cell[i] == names.size())
            throw base::InputError(
                path + ":1: there is no column " +
                (i == 6 ? "target_Pa or target" : columns.name[i]) +
                "; the header must hold x_m,y_m,z_m,nx,ny,nz and target_Pa or target");
    }
    return columns;
}

std::ofstream openForWriting(const std::string& path)
{
    std::ofstream file(path);
    if (!file) throw base::InputError("cannot write " + path);
    file.imbue(std::locale::classic());
    file.precision(9);
    return file;
}

void finish(std::ofstream& file, const std::string& path)
{
    file.close();
    if (!file) throw base::InputError("could not write " + path + " to its end: is the disk full?");
}

} // namespace

std::string textOf(const std::string& path)
{
    return base::readRegularFile(path, kMostBytes, path + ": ");
}

haptics::ControlPoints readControlPoints(const std::string& path)
{
    std::istringstream file(textOf(path));
    std::string line;
    std::getline(file, line);
    const Columns columns = readHeader(path, line);

    std::vector<std::array<double, 7>> rows;
    for (int number = 2; std::getline(file, line); ++number)
    {
        if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
        const std::vector<std::string> cells = splitLine(line);
        std::array<double, 7> row{};
        for (std::size_t i = 0; i < row.size(); ++i)
            row[i] = parseCell(path,
                               number,
                               columns.name[i],
                               columns.cell[i] < cells.size() ? cells[columns.cell[i]] : "");
        if (std::hypot(row[3], row[4], row[5]) == 0.0)
            throw base::InputError(fmt::format("{}:{}: the normal nx,ny,nz is zero", path, number));
        if (rows.size() == kMostPoints)
            throw base::InputError(fmt::format(
                "{}:{}: there are more than {} control points, which is the most possible",
                path,
                number,
                kMostPoints));
        rows.push_back(row);
    }
    if (rows.empty())
        throw base::InputError(path + ": there are no control points below the header");

    const auto n = static_cast<Eigen::Index>(rows.size());
    haptics::ControlPoints points;
    points.absolute = columns.absolute;
    points.positions.resize(3, n);
    points.normals.resize(3, n);
    points.targets.resize(n);
    for (Eigen::Index l = 0; l < n; ++l)
    {
        const auto& row = rows[static_cast<std::size_t>(l)];
        points.positions.col(l) << row[0], row[1], row[2];
        points.normals.col(l) = Eigen::Vector3d(row[3], row[4], row[5]).stableNormalized();
        points.targets[l] = row[6];
    }
    return points;
}

void writeControlPoints(const std::string& path,
                        const haptics::ControlPoints& points,
                        const Eigen::VectorXd& target_Pa,
                        const Eigen::VectorXd& achieved_Pa)
{
    std::ofstream file = openForWriting(path);
    file << "x_m,y_m,z_m,nx,ny,nz,target_Pa,achieved_Pa\n";
    for (int l = 0; l < points.size(); ++l)
    {
        for (int axis = 0; axis < 3; ++axis)
            file << points.positions(axis, l) << ',';
        for (int axis = 0; axis < 3; ++axis)
            file << points.normals(axis, l) << ',';
        file << target_Pa[l] << ',' << achieved_Pa[l] << '\n';
    }
    finish(file, path);
}

void writeDrive(const std::string& path,
                const haptics::TransducerArray& array,
                const device::DriveSignal& signal)
{
    std::ofstream file = openForWriting(path);
    bridge::writeDrive(file, array, signal);
    finish(file, path);
}

void writeSummary(const std::string& path,
                  const haptics::TransducerArray& array,
                  const haptics::Medium& medium,
                  const haptics::SolveReport& report,
                  const SummaryParts& parts)
{
    nlohmann::ordered_json json;
    json["array"] = array.name;
    json["transducers"] = array.size();
    json["frequency_Hz"] = array.frequency_Hz;
    json["soundSpeed_m_s"] = medium.soundSpeed();
    json["attenuation_Np_m"] = medium.attenuation(array.frequency_Hz);
    json["sourceAmplitude_Pa_m"] = array.sourceAmplitude_Pa_m;
    json["exposureAmplitude_Pa_m"] = array.heardAmplitude_Pa_m();
    json["directivity"] = haptics::directivityName(array.directivity);
    json["ringing_s"] = array.ringing_s;
    json["phaseLevels"] = array.drive.phaseLevels;
    if (!bridge::hasDuties(array.drive)) json["amplitudeLevels"] = array.drive.amplitudeLevels;
    json["temperature_C"] = medium.temperature_C;
    json["relativeHumidity"] = medium.relativeHumidity;
    json["pressure_Pa"] = medium.pressure_Pa;
    json["report"] = haptics::toJson(report);
    json["fields"] = parts.fields;
    if (parts.fields > 1) json["fieldRate_Hz"] = parts.fieldRate_Hz;
    if (parts.evened) json["evened"] = true;
    if (parts.ringing)
        json["ringing"] = {{"rms", parts.ringing->rms},
                           {"max", parts.ringing->max},
                           {"loudness", parts.ringing->loudness},
                           {"level_Pa", parts.ringing->level_Pa},
                           {"shortPoints", parts.ringing->shortPoints},
                           {"worstShortfall", parts.ringing->worstShortfall}};
    if (report.surface.samples > 0)
    {
        json["surface"] = json["report"]["surface"];
        json["report"].erase("surface");
    }
    json["exposure"]["what"] = haptics::kExposureMeaning;
    for (const haptics::ExposureRow& row : haptics::kExposureFigures)
        std::visit([&](auto member) { json["exposure"][row.name] = parts.exposure.*member; },
                   row.value);
    // Fields that are played without end have no averaging time.
    json["exposure"].erase("time_s");
    if (parts.certificate)
        json["certificate"] = {{"bound", parts.certificate->bound},
                               {"best", parts.certificate->best},
                               {"phases", parts.certificate->givenPhases},
                               {"field", parts.certificate->givenField},
                               {"tight", parts.certificate->tight},
                               {"total_ms", parts.certificate->total_ms}};
    std::ofstream file = openForWriting(path);
    file << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
    finish(file, path);
}

} // namespace midair::samples
