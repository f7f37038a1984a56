#include "samples/tools/solve/SolveFiles.h"

#include "engine-bridge/solving/ArrayLevels.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <vector>

#include <nlohmann/json.hpp>

namespace midair::samples
{
namespace
{

using base::InputError;

constexpr std::size_t kMostBytes = std::size_t(64) << 20;
constexpr std::size_t kMostPoints = 100000;

/// Splits a line at commas; a blank line has no cells.
std::vector<std::string> splitLine(const std::string& line)
{
    std::vector<std::string> cells;
    std::istringstream stream(base::trimmed(line));
    for (std::string cell; std::getline(stream, cell, ',');)
        cells.push_back(base::trimmed(cell));
    return cells;
}

/// Describes a table of numbers: its columns and the words for messages.
struct NumberTable
{
    std::vector<std::string> columns;
    const char* header;      ///< "x_m,y_m,z_m": required columns
    const char* rows;        ///< "places"
    bool hasNormals = false; ///< columns 3 to 5 are a normal, which must not be 0
};

/// Reads the columns of \a table from a CSV file, at most kMostPoints rows; each row becomes a
/// column of the result. \a split splits a line into cells.
Eigen::MatrixXd readTable(const std::string& path,
                          const std::string& text,
                          const NumberTable& table,
                          std::vector<std::string> (*split)(const std::string&))
{
    std::istringstream file(text);
    std::string line;
    std::getline(file, line);
    const std::vector<std::string> names = split(line);
    std::vector<std::size_t> cells;
    for (const std::string& column : table.columns)
    {
        const auto found = std::find(names.begin(), names.end(), column);
        if (found == names.end())
            throw InputError(fmt::format("{}:1: there is no column {}; the header must have {}",
                                         path,
                                         column,
                                         table.header));
        cells.push_back(static_cast<std::size_t>(found - names.begin()));
    }
    std::vector<double> values;
    const auto width = static_cast<Eigen::Index>(cells.size());
    for (int number = 2; std::getline(file, line); ++number)
    {
        const std::vector<std::string> row = split(line);
        if (row.empty()) continue;
        for (std::size_t i = 0; i < cells.size(); ++i)
        {
            const std::string cell = cells[i] < row.size() ? row[cells[i]] : "";
            if (!base::parseNumber(cell, values.emplace_back()))
                throw InputError(fmt::format("{}:{}: {} is '{}', it must be a finite number",
                                             path,
                                             number,
                                             table.columns[i],
                                             cell));
        }
        const double* const last = &values[values.size() - cells.size()];
        if (table.hasNormals && std::hypot(last[3], last[4], last[5]) == 0.0)
            throw InputError(fmt::format("{}:{}: the normal nx,ny,nz is zero", path, number));
        if (values.size() > kMostPoints * cells.size())
            throw InputError(fmt::format(
                "{}:{}: there are more than {} {}", path, number, kMostPoints, table.rows));
    }
    if (values.empty())
        throw InputError(fmt::format("{}: there are no {} below the header", path, table.rows));
    return Eigen::Map<const Eigen::MatrixXd>(
        values.data(), width, static_cast<Eigen::Index>(values.size()) / width);
}

/// Returns what reflectors do to the drives, for summary.json.
nlohmann::ordered_json jsonOf(const SolvedReflectors& some)
{
    nlohmann::ordered_json json = {{"count", some.count},
                                   {"corrected", some.isCorrected},
                                   {"rms", some.played.rms},
                                   {"worst", some.played.worst},
                                   {"level_Pa", some.played.level_Pa},
                                   {"expectedRms", some.played.expectedRms},
                                   {"freeRms", some.played.freeRms},
                                   {"freeLevel_Pa", some.played.freeLevel_Pa},
                                   {"hiddenTransducers", some.hidden},
                                   {"freeEars_dB", some.freeEars_dB}};
    if (some.other.level_Pa > 0.0)
        json[some.isCorrected ? "uncorrected" : "ifCorrected"] = {
            {"rms", some.other.rms}, {"expectedRms", some.other.expectedRms}};
    return json;
}

/// Returns what a thing in the field does to the drives.
nlohmann::ordered_json jsonOf(const SolvedScatterer& some)
{
    return {{"corrected", some.whyUncorrected.empty()},
            {"rms", some.rms},
            {"level_Pa", some.level_Pa},
            {"uncorrectedRms", some.uncorrectedRms},
            {"uncorrectedLevel_Pa", some.uncorrectedLevel_Pa},
            {"change", some.change.rms},
            {"largestChange", some.change.worst},
            {"levelChange", some.change.level},
            {"elements", some.change.elements}};
}

nlohmann::ordered_json jsonOf(const haptics::Certificate& certificate)
{
    return {{"bound", certificate.bound},
            {"best", certificate.best},
            {"phases", certificate.givenPhases},
            {"field", certificate.givenField},
            {"tight", certificate.tight},
            {"total_ms", certificate.total_ms}};
}

} // namespace

std::string textOf(const std::string& path)
{
    return base::readRegularFile(path, kMostBytes, path + ": ");
}

TextFile::TextFile(std::string path) : _path(std::move(path)), _file(_path)
{
    if (!_file) throw InputError("cannot write " + _path);
    _file.imbue(std::locale::classic());
    _file.precision(9);
}

void TextFile::finish()
{
    _file.close();
    if (!_file) throw InputError("could not write " + _path + " to its end: is the disk full?");
}

Eigen::Matrix3Xd readEars(const std::string& path)
{
    return readTable(
        path, textOf(path), {{"x_m", "y_m", "z_m"}, "x_m,y_m,z_m", "places"}, base::splitColumns);
}

haptics::ControlPoints readControlPoints(const std::string& path)
{
    const std::string text = textOf(path);
    const std::vector<std::string> names = splitLine(text.substr(0, text.find('\n')));
    haptics::ControlPoints points;
    points.absolute = std::count(names.begin(), names.end(), "target_Pa") > 0;
    const std::string target = points.absolute ? "target_Pa"
                               : std::count(names.begin(), names.end(), "target") > 0
                                   ? "target"
                                   : "target_Pa or target";
    const Eigen::MatrixXd rows = readTable(path,
                                           text,
                                           {{"x_m", "y_m", "z_m", "nx", "ny", "nz", target},
                                            "x_m,y_m,z_m,nx,ny,nz and target_Pa or target",
                                            "control points",
                                            true},
                                           splitLine);
    points.positions = rows.topRows(3);
    points.normals = rows.middleRows(3, 3);
    for (auto normal : points.normals.colwise())
        normal.stableNormalize();
    points.targets = rows.row(6);
    return points;
}

void writeControlPoints(const std::string& path,
                        const haptics::ControlPoints& points,
                        const Eigen::VectorXd& target_Pa,
                        const Eigen::VectorXd& achieved_Pa)
{
    TextFile file(path);
    file.line("x_m,y_m,z_m,nx,ny,nz,target_Pa,achieved_Pa");
    for (int l = 0; l < points.size(); ++l)
        file.line("{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}",
                  points.positions(0, l),
                  points.positions(1, l),
                  points.positions(2, l),
                  points.normals(0, l),
                  points.normals(1, l),
                  points.normals(2, l),
                  target_Pa[l],
                  achieved_Pa[l]);
    file.finish();
}

void writeDrive(const std::string& path,
                const haptics::TransducerArray& array,
                const device::DriveSignal& signal)
{
    TextFile file(path);
    bridge::writeDrive(file.stream(), array, signal);
    file.finish();
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
    json["fingertipForce_N"] = parts.fingertip.force_N;
    json["feeling"] = parts.fingertip.feeling();
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
    if (parts.reflectors) json["reflectors"] = jsonOf(*parts.reflectors);
    if (parts.scatterer) json["scatterer"] = jsonOf(*parts.scatterer);
    if (parts.certificate) json["certificate"] = jsonOf(*parts.certificate);
    TextFile file(path);
    file.line("{}", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    file.finish();
}

} // namespace midair::samples
