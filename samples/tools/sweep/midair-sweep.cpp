// Solves for every row of a table of parameters, on one core or on many machines, and writes one
// table of results.
#include "haptics/array/TransducerArray.h"
#include "haptics/base/Bytes.h"
#include "haptics/base/InputError.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/simd/InstructionSet.h"
#include "haptics/base/text/Words.h"
#include "haptics/sequence/FieldSettings.h"
#include "samples/shared/SettingOptions.h"
#include "samples/shared/ToolOptions.h"
#include "samples/shared/shards/Shards.h"
#include "samples/tools/solve/Solution.h"
#include "samples/tools/solve/SolveFiles.h"
#include "samples/tools/solve/SolveOptions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace
{

using namespace midair;
using namespace midair::samples;

using base::InputError;
using Json = nlohmann::ordered_json;

constexpr std::uint64_t kMostRows = 10000000;

// Options of midair-solve that write files or produce no figure.
const std::set<std::string> kNoParameter = {
    "--out", "--help", "--probe", "--probe-points", "--probe-patch", "--duration", "--probe-rate"};

/// Parses a CSV file with optionally quoted cells (RFC 4180).
std::vector<std::vector<std::string>> cellsOf(const std::string& text)
{
    std::vector<std::vector<std::string>> lines(1);
    std::string cell;
    bool isQuoted = false;
    const auto endCell = [&] { lines.back().push_back(std::exchange(cell, {})); };
    for (std::size_t i = 0; i < text.size(); ++i)
    {
        const char c = text[i];
        if (isQuoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"')
            cell += text[++i];
        else if (c == '"')
            isQuoted = !isQuoted;
        else if (isQuoted || (c != ',' && c != '\n' && c != '\r'))
            cell += c;
        else if (c == ',')
            endCell();
        else if (c == '\n')
        {
            endCell();
            lines.emplace_back();
        }
    }
    endCell();
    const auto isBlank = [](const std::vector<std::string>& line)
    {
        return std::all_of(line.begin(),
                           line.end(),
                           [](const std::string& one)
                           { return one.find_first_not_of(" \t") == std::string::npos; });
    };
    lines.erase(std::remove_if(lines.begin(), lines.end(), isBlank), lines.end());
    return lines;
}

std::string textOfValue(const Json& value)
{
    if (value.is_null()) return {};
    if (value.is_string()) return value.get<std::string>();
    if (!value.is_array()) return value.dump();
    std::string all;
    for (const Json& one : value)
        all += (all.empty() ? "" : " ") + textOfValue(one);
    return all;
}

std::vector<std::string> parametersOf(const CLI::App& app)
{
    std::vector<std::string> names = {"model"};
    for (const CLI::Option* option : app.get_options())
        if (!option->get_lnames().empty() &&
            kNoParameter.count("--" + option->get_lnames().front()) == 0)
            names.push_back(option->get_lnames().front());
    return names;
}

/// File names in a row are relative to the table's folder.
std::string beside(const std::string& table, const std::string& name)
{
    const std::filesystem::path path =
        std::filesystem::path(table).parent_path() / std::filesystem::path(name);
    return std::filesystem::exists(path) ? path.string() : name;
}

/// Adds the command-line words of a value: a flag, or a name and its values.
void addWords(const CLI::Option& option, const std::string& text, std::vector<std::string>& words)
{
    const std::string name = "--" + option.get_lnames().front();
    if (option.get_expected_max() == 0) return words.push_back(name + "=" + text);
    words.push_back(name);
    if (option.get_items_expected_max() <= 1) return words.push_back(text);
    std::istringstream parts(text);
    for (std::string part; parts >> part;)
        words.push_back(part);
}

/// A table of parameters: the options of midair-solve for each row.
class SweepTable
{
public:
    /// Reads a CSV file with names in its first line, or a JSON file: an array of objects, or an
    /// object with any of "rows" (an array of objects), "common" (an object that is merged into
    /// each row) and "cross" (an object of arrays: each row with each combination, the last name
    /// fastest). Parses all rows. Throws base::InputError with the row and the column.
    explicit SweepTable(const std::string& file) : _file(file)
    {
        const std::string text = textOf(file);
        const std::size_t begin = text.find_first_not_of(" \t\r\n");
        const bool isJson =
            begin != std::string::npos && (text[begin] == '[' || text[begin] == '{');
        if (isJson)
            readJson(text);
        else
            readCsv(text);
        if (_rows.empty()) throw InputError(file + ": there are no rows");
        for (std::uint64_t row = 0; row < size(); ++row)
            arguments(row);
    }

    std::uint64_t size() const { return _rows.size(); }
    /// Returns the names of the parameters in order of appearance.
    const std::vector<std::string>& columns() const { return _columns; }
    /// Returns the value of a parameter as text, or an empty text if the row has none.
    std::string text(std::uint64_t row, const std::string& column) const
    {
        const Row& one = _rows[row];
        return one.contains(column) ? textOfValue(one[column]) : std::string();
    }

    /// Returns the options of a row. Throws base::InputError.
    SolveArguments arguments(std::uint64_t row) const
    {
        SolveArguments arguments;
        arguments.settings.threads = 1; // run one process per core instead
        CLI::App app;
        addOptions(app, arguments);
        std::vector<std::string> words;
        for (const auto& [name, value] : _rows[row].items())
        {
            const std::string text = textOfValue(value);
            if (text.empty()) continue;
            if (name == "model")
            {
                words.push_back(text);
                continue;
            }
            const std::string option = optionName(name).substr(0, optionName(name).find(','));
            const CLI::Option* found = app.get_option_no_throw(option);
            if (!found || kNoParameter.count(option) > 0)
                fail(row,
                     "there is no parameter \"" + name + "\"" +
                         base::didYouMean(option.substr(2), parametersOf(app)));
            addWords(*found, text, words);
        }
        try
        {
            std::reverse(words.begin(), words.end()); // CLI11 expects reverse order
            app.parse(words);
        }
        catch (const CLI::ParseError& error)
        {
            fail(row, error.what());
        }
        for (std::string* file : {&arguments.model, &arguments.pointsFile, &arguments.earsFile})
            if (!file->empty()) *file = beside(_file, *file);
        if (arguments.array.find(".json") != std::string::npos)
            arguments.array = beside(_file, arguments.array);
        if (arguments.model.empty() && arguments.pointsFile.empty())
            fail(row, "has no model and no points-file");
        return arguments;
    }

    /// Returns everything that the results depend on: the number of rows, their CRC-32C, and those
    /// of the files and arrays that they use.
    nlohmann::json describe() const
    {
        const auto crcOf = [](const std::string& text, std::uint32_t crc = 0) {
            return base::crc32c(
                reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), crc);
        };
        std::uint32_t rows = 0;
        std::map<std::string, std::uint32_t> files;
        std::map<std::string, std::uint32_t> arrays;
        for (std::uint64_t row = 0; row < size(); ++row)
        {
            rows = crcOf(_rows[row].dump(), rows);
            const SolveArguments asked = arguments(row);
            for (const std::string& file : {asked.model, asked.pointsFile, asked.earsFile})
                if (const auto name = std::filesystem::path(file).filename().string();
                    !file.empty() && files.count(name) == 0)
                    files[name] = crcOf(textOf(file));
            if (arrays.count(asked.array) == 0)
                arrays[asked.array] = crcOf(haptics::TransducerArray::load(asked.array).toJson());
        }
        return {{"rows", size()},
                {"crc32c", rows},
                {"columns", _columns},
                {"files", files},
                {"arrays", arrays}};
    }

private:
    using Row = nlohmann::ordered_json;

    void readCsv(const std::string& text)
    {
        const auto lines = cellsOf(text);
        for (std::size_t i = 1; i < lines.size(); ++i)
        {
            if (lines[i].size() != lines[0].size())
                fail(i - 1,
                     fmt::format("has {} cells, the header {}", lines[i].size(), lines[0].size()));
            Row row = Row::object();
            for (std::size_t k = 0; k < lines[0].size(); ++k)
                if (!lines[i][k].empty()) row[lines[0][k]] = lines[i][k];
            add(std::move(row));
        }
        if (!lines.empty()) // includes columns that no row fills, in the header's order
            _columns = lines[0];
    }

    void readJson(const std::string& text)
    {
        Json table;
        try
        {
            table = Json::parse(text);
        }
        catch (const Json::parse_error& error)
        {
            throw InputError(_file + ": " + error.what());
        }
        if (table.is_array()) table = Json{{"rows", table}};
        for (const auto& [name, value] : table.items())
            if (name != "rows" && name != "common" && name != "cross")
                throw InputError(_file + ": \"" + name +
                                 "\" is unknown, should be rows, common or cross" +
                                 base::didYouMean(name, {"rows", "common", "cross"}));
        const Json common = table.value("common", Json::object());
        const Json cross = table.value("cross", Json::object());
        const Json rows = table.value("rows", Json::array({Json::object()}));
        if (!common.is_object() || !cross.is_object() || !rows.is_array())
            throw InputError(_file + ": rows should be an array, common and cross objects");
        std::vector<Json> combinations = {Json::object()};
        for (const auto& [name, values] : cross.items())
        {
            if (!values.is_array() || values.empty())
                throw InputError(_file + ": cross." + name + " should be an array of values");
            std::vector<Json> more;
            for (const Json& before : combinations)
                for (const Json& value : values)
                {
                    more.push_back(before);
                    more.back()[name] = value;
                    if (more.size() > kMostRows)
                        throw InputError(
                            fmt::format("{}: cross has more than {} rows", _file, kMostRows));
                }
            combinations = std::move(more);
        }
        for (const Json& own : rows)
            for (const Json& combination : combinations)
            {
                Row row = common;
                if (!own.is_object()) fail(size(), "is not an object of names and values");
                row.update(own);
                row.update(combination);
                add(std::move(row));
            }
    }

    void add(Row row)
    {
        if (!row.is_object()) fail(size(), "is not an object of names and values");
        if (size() == kMostRows)
            throw InputError(fmt::format("{}: there are more than {} rows", _file, kMostRows));
        for (const auto& [name, value] : row.items())
        {
            if (value.is_object()) fail(size(), name + " is an object, should be a value");
            if (std::find(_columns.begin(), _columns.end(), name) == _columns.end())
                _columns.push_back(name);
        }
        _rows.push_back(std::move(row));
    }

    [[noreturn]] void fail(std::uint64_t row, const std::string& why) const
    {
        throw InputError(fmt::format("{}: row {}: {}", _file, row, why));
    }

    std::string _file;
    std::vector<Row> _rows;
    std::vector<std::string> _columns;
};

/// Options of midair-sweep.
struct SweepArguments
{
    std::string table;
    std::string out;
    std::string shard = "1/1";
    bool times = false;     ///< write solve times, which differ in each run
    bool overwrite = false; ///< replace any file
    bool quiet = false;
};

constexpr std::uint64_t kRows = 16; // per piece: a kill loses at most so many
const char* const kWhat = "midair-sweep 1";
const char* const kFirstColumn = "row";

std::string csvCell(const std::string& text)
{
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text)
        quoted += c == '"' ? "\"\"" : std::string(1, c);
    return quoted + "\"";
}

bool isTime(const std::string& figure)
{
    return figure.size() > 3 && figure.compare(figure.size() - 3, 3, "_ms") == 0;
}

/// Returns the column of a figure: its name, with a prefix if a setting has the same name
/// (loudness).
std::string figureColumn(const std::string& figure)
{
    const auto& settings = haptics::fieldSettings().rows();
    const bool isSetting = std::any_of(
        settings.begin(), settings.end(), [&](const auto& row) { return row.name == figure; });
    return (isSetting ? "reached_" : "") + figure;
}

/// Returns the names of the result columns.
std::vector<std::string> resultColumns(bool times)
{
    std::vector<std::string> names = {"solvedBy", "stop", "message", "error", "fields"};
    for (const auto& row : haptics::kFigures)
        if (times || !isTime(row.name)) names.push_back(figureColumn(row.name));
    for (const auto& row : haptics::kSurfaceFigures)
        names.push_back(std::string("surface_") + row.name);
    for (const char* name : {"certifiedGap", "ears_dB"})
        names.emplace_back(name);
    return names;
}

/// Formats a number for pandas, pyarrow and DuckDB; non-finite ones become empty.
std::string numberCell(double value)
{
    return std::isfinite(value) ? fmt::format("{}", value) : "";
}

/// Solves for \a asked and returns cells in the order of resultColumns().
std::vector<std::string> solvedCells(const SolveArguments& asked, bool times)
{
    const Solution solution = solveAll(asked);
    const haptics::SolveReport& report = solution.sequence.report;
    std::vector<std::string> cells = {report.solver,
                                      haptics::stopReasonName(report.stop),
                                      csvCell(report.message),
                                      "",
                                      std::to_string(solution.parts.fields)};
    const auto add = [&cells](const auto& row, const auto& of)
    {
        std::visit([&](auto member)
                   { cells.push_back(numberCell(static_cast<double>(of.*member))); },
                   row.value);
    };
    for (const auto& row : haptics::kFigures)
        if (times || !isTime(row.name)) add(row, report);
    for (const auto& row : haptics::kSurfaceFigures)
        if (report.surface.samples > 0)
            add(row, report.surface);
        else
            cells.emplace_back();
    cells.push_back(
        solution.parts.certificate ? numberCell(solution.parts.certificate->gapOfPhases()) : "");
    const bool sounds = report.level_Pa > 0.0;
    cells.push_back(sounds ? numberCell(solution.parts.exposure.level_dB) : "");
    return cells;
}

/// Returns a line of the results; \a failed counts rows that can't be solved.
std::string lineOf(const SweepTable& table, std::uint64_t row, bool times, int& failed)
{
    std::string line = std::to_string(row);
    for (const std::string& column : table.columns())
        line += "," + csvCell(table.text(row, column));
    std::vector<std::string> cells;
    try
    {
        cells = solvedCells(table.arguments(row), times);
    }
    catch (...)
    {
        ++failed;
        const std::string why = base::whatWasThrown();
        std::fprintf(stderr,
                     "midair-sweep: row %llu: %s\n",
                     static_cast<unsigned long long>(row),
                     why.c_str());
        cells.assign(resultColumns(times).size(), "");
        cells[3] = csvCell(why);
    }
    for (const std::string& cell : cells)
        line += "," + cell;
    return line + "\n";
}

std::string rowsOf(const nlohmann::json& work, std::uint64_t piece)
{
    const std::uint64_t rows = work.contains("table") ? work["table"].value("rows", kRows) : kRows;
    return fmt::format("rows {} to {}", piece * kRows, std::min((piece + 1) * kRows, rows) - 1);
}

std::string header(const nlohmann::json& work)
{
    std::string line = kFirstColumn;
    for (const nlohmann::json& column : work["table"]["columns"])
        line += "," + csvCell(column.get<std::string>());
    for (const nlohmann::json& column : work["results"])
        line += "," + column.get<std::string>();
    return line + "\n";
}

nlohmann::json workOf(const SweepTable& table, const SweepArguments& arguments)
{
    nlohmann::json work = {{"what", kWhat},
                           {"table", table.describe()},
                           {"results", resultColumns(arguments.times)},
                           {"instructions", base::instructionSetName(base::instructionSet())}};
    const std::vector<std::string> results = resultColumns(arguments.times);
    for (const std::string& column : table.columns())
        if (column == kFirstColumn ||
            std::find(results.begin(), results.end(), column) != results.end())
            throw InputError(fmt::format(
                "{}: \"{}\" is a column of the results, not a parameter", arguments.table, column));
    return work;
}

/// Merges \a parts into a table of results. Throws base::InputError.
void mergeSwept(const std::vector<std::string>& parts, const std::string& out, bool overwrite)
{
    const JoinedParts joined(parts, rowsOf);
    const nlohmann::json& work = joined.work();
    if (work.value("what", "") != kWhat)
        throw InputError(fmt::format("\"{}\" is not a part of midair-sweep, but of {}",
                                     parts.front(),
                                     work.value("what", "something else")));
    WholeFile file(out, kFirstColumn, overwrite);
    const auto put = [&file](const std::string& text) { file.write(text.data(), text.size()); };
    put(header(work));
    for (std::uint64_t piece = 0; piece < joined.pieces(); ++piece)
        put(joined.read(piece));
    file.commit();
    std::printf("%s: %llu rows\n",
                out.c_str(),
                static_cast<unsigned long long>(work["table"].value("rows", std::uint64_t(0))));
}

/// Solves a shard's rows. A single shard writes the table of results to \a arguments.out, otherwise
/// its part. Continues an existing part. Returns 0, or 1 if a row couldn't be solved. Throws
/// base::InputError.
int sweep(const SweepArguments& arguments)
{
    const Shard shard = parseShard(arguments.shard);
    const bool isWhole = shard.count == 1;
    const SweepTable table(arguments.table);
    const PartHeader part{
        workOf(table, arguments), shard.number, shard.count, (table.size() + kRows - 1) / kRows};
    if (isWhole)
        WholeFile(arguments.out, kFirstColumn, arguments.overwrite); // fail now rather than at the
                                                                     // end
    const std::string file = isWhole ? arguments.out + ".part" : arguments.out;
    int failed = 0;
    {
        PartFile done = PartFile::openToGoOn(file, part);
        if (!done.damage().empty())
            std::fprintf(stderr,
                         "midair-sweep: \"%s\": %s; solving it again\n",
                         file.c_str(),
                         done.damage().c_str());
        Progress progress("rows",
                          std::min(done.pieces() * kRows, table.size()),
                          std::min(part.share() * kRows, table.size()),
                          arguments.quiet);
        for (std::uint64_t piece = 0; piece < part.pieces; ++piece)
        {
            if (!part.has(piece) || done.has(piece)) continue;
            std::string lines;
            const std::uint64_t end = std::min((piece + 1) * kRows, table.size());
            for (std::uint64_t row = piece * kRows; row < end; ++row)
            {
                lines += lineOf(table, row, arguments.times, failed);
                progress.add(1);
            }
            done.add(piece, lines);
        }
        done.sync();
    }
    if (isWhole)
    {
        mergeSwept({file}, arguments.out, arguments.overwrite);
        ::unlink(file.c_str());
    }
    if (failed > 0)
        std::fprintf(stderr, "midair-sweep: %d rows can't be solved, see \"error\"\n", failed);
    return failed > 0 ? EXIT_PROBLEM : EXIT_DONE;
}

int run(int argc, char** argv)
{
    using namespace midair::samples;
    using midair::base::InputError;
    SweepArguments arguments;
    std::vector<std::string> parts;
    CLI::App app(
        "Solves for every row of a table of parameters, which are options and settings of "
        "midair-solve, and writes a CSV file with the figures of each row.\n"
        "Example: midair-sweep table.csv --out results.csv\n"
        "If interrupted, the same command continues.\n"
        "Exit code: 0 done, 1 done except for rows that can't be solved, 2 a wrong option or file.",
        "midair-sweep");
    app.add_option("table", arguments.table, "TABLE.csv or TABLE.json");
    app.add_option("--out", arguments.out, "Table of results to write; with --shard, the part")
        ->required();
    app.add_option("--shard",
                   arguments.shard,
                   "i/K: solve every K-th piece of 16 rows, starting with the i-th; the result is "
                   "the same for any K")
        ->capture_default_str();
    app.add_option("--merge", parts, "Merge the parts of all shards into the table of results");
    app.add_flag(
        "--times", arguments.times, "Add columns with solve times, which differ in each run");
    app.add_flag(
        "--overwrite", arguments.overwrite, "Replace --out even if it isn't a table of results");
    app.add_flag("--quiet", arguments.quiet, "Don't print progress");
    useToolHelp(app);
    try
    {
        app.parse(argc, argv);
        if (parts.empty() && arguments.table.empty())
            throw InputError("a table or --merge PARTS is missing");
        if (parts.empty()) return sweep(arguments);
        if (!arguments.table.empty()) throw InputError("--merge takes only parts, no table");
        mergeSwept(parts, arguments.out, arguments.overwrite);
        return 0;
    }
    catch (const CLI::ParseError& error)
    {
        return exitOf(app, error);
    }
}

} // namespace

int main(int argc, char** argv)
{
    try
    {
        return run(argc, argv);
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-sweep: %s\n", error.what());
        return midair::samples::EXIT_WRONG;
    }
}
