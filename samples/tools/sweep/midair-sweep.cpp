// Solves for every row of a table of parameters, on one core or on many machines, and writes one
// table of results.
#include "haptics/base/InputError.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/simd/InstructionSet.h"
#include "haptics/sequence/FieldSettings.h"
#include "samples/shared/shards/Shards.h"
#include "samples/tools/solve/Solution.h"
#include "samples/tools/sweep/SweepTable.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <unistd.h>

namespace
{

using namespace midair;
using namespace midair::samples;

/// What midair-sweep was asked for.
struct SweepArguments
{
    std::string table;
    std::string out;
    std::string shard = "1/1";
    bool times = false;     ///< times that solves took, too: other bytes each time
    bool overwrite = false; ///< whatever is there
    bool quiet = false;
};

using base::InputError;

constexpr std::uint64_t kRows = 16; // of a piece: a kill loses so many at most
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

/// The column of a figure: its name, but for one that a setting has, too (loudness).
std::string figureColumn(const std::string& figure)
{
    const auto& settings = haptics::fieldSettings().rows();
    const bool isSetting = std::any_of(
        settings.begin(), settings.end(), [&](const auto& row) { return row.name == figure; });
    return (isSetting ? "reached_" : "") + figure;
}

/// Names of the results, which each row has.
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

/// A number as pandas, pyarrow and DuckDB read it; one that isn't finite is left out.
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

/// One line of the results; \a failed counts rows that can't be solved.
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
            throw InputError(fmt::format("{}: \"{}\" is a column of the results, and no parameter",
                                         arguments.table,
                                         column));
    return work;
}

/// Joins \a parts to a table of results. Throws base::InputError.
void mergeSwept(const std::vector<std::string>& parts, const std::string& out, bool overwrite)
{
    const JoinedParts joined(parts, rowsOf);
    const nlohmann::json& work = joined.work();
    if (work.value("what", "") != kWhat)
        throw InputError(fmt::format("\"{}\" is no part of midair-sweep, but of {}",
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

/// Solves a shard's rows. With a single shard \a arguments.out becomes the table of results, else
/// the part. Goes on with a part that is there. Returns 0, or 1 if a row couldn't be solved. Throws
/// base::InputError.
int sweep(const SweepArguments& arguments)
{
    const Shard shard = parseShard(arguments.shard);
    const bool isWhole = shard.count == 1;
    const SweepTable table(arguments.table);
    const PartHeader part{
        workOf(table, arguments), shard.number, shard.count, (table.size() + kRows - 1) / kRows};
    if (isWhole) WholeFile(arguments.out, kFirstColumn, arguments.overwrite); // told now
    const std::string file = isWhole ? arguments.out + ".part" : arguments.out;
    int failed = 0;
    {
        PartFile done = PartFile::openToGoOn(file, part);
        if (!done.damage().empty())
            std::fprintf(stderr,
                         "midair-sweep: \"%s\": %s; solved again\n",
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
    return failed > 0 ? 1 : 0;
}

} // namespace

int main(int argc, char** argv)
{
    using namespace midair::samples;
    using midair::base::InputError;
    constexpr int kWrong = 2;
    SweepArguments arguments;
    std::vector<std::string> parts;
    CLI::App app("midair-sweep: solves for every row of a table of parameters, which are "
                 "midair-solve's options and settings by their names, and writes a CSV with the "
                 "figures of each. What is finished is kept when it is ended: the same command "
                 "goes on.\n"
                 "Exit code: 0 done, 1 done but for rows that can't be solved, 2 something is "
                 "wrong.",
                 "midair-sweep");
    app.add_option("table", arguments.table, "TABLE.csv or TABLE.json");
    app.add_option("--out", arguments.out, "Table of results; with --shard the part")->required();
    app.add_option("--shard",
                   arguments.shard,
                   "i/K: every K-th piece of 16 rows from the i-th on; the same bytes for any K")
        ->capture_default_str();
    app.add_option("--merge", parts, "Parts of all shards, which become the table of results");
    app.add_flag("--times",
                 arguments.times,
                 "Columns of the times that solves took, too, which differ each time");
    app.add_flag("--overwrite", arguments.overwrite, "Replace --out even if it is something else");
    app.add_flag("--quiet", arguments.quiet, "No progress");
    try
    {
        app.parse(argc, argv);
        if (parts.empty() && arguments.table.empty())
            throw InputError("name a table, or --merge PARTS");
        if (parts.empty()) return sweep(arguments);
        if (!arguments.table.empty()) throw InputError("--merge takes parts, and no table");
        mergeSwept(parts, arguments.out, arguments.overwrite);
        return 0;
    }
    catch (const CLI::ParseError& error)
    {
        return app.exit(error) == 0 ? 0 : kWrong;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "midair-sweep: %s\n", error.what());
        return kWrong;
    }
}
