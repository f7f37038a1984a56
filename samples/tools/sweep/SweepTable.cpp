#include "samples/tools/sweep/SweepTable.h"

#include "haptics/array/TransducerArray.h"
#include "haptics/base/Bytes.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Words.h"
#include "samples/shared/SettingOptions.h"
#include "samples/tools/solve/SolveFiles.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using base::InputError;
using Json = nlohmann::ordered_json;

constexpr std::uint64_t kMostRows = 10000000;

// Options of midair-solve that write files of their own, or make no figure.
const std::set<std::string> kNoParameter = {
    "--out", "--help", "--probe", "--probe-points", "--probe-patch", "--duration", "--probe-rate"};

/// Lines of a CSV file with cells in quotes where they need them (RFC 4180).
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

/// Files of a row lie beside its table, unless they are named from the root.
std::string beside(const std::string& table, const std::string& name)
{
    const std::filesystem::path path =
        std::filesystem::path(table).parent_path() / std::filesystem::path(name);
    return std::filesystem::exists(path) ? path.string() : name;
}

/// The words that a command line would have for a value: a flag, or a name and its values.
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

} // namespace

SweepTable::SweepTable(const std::string& file) : _file(file)
{
    const std::string text = textOf(file);
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    const bool isJson = begin != std::string::npos && (text[begin] == '[' || text[begin] == '{');
    if (isJson)
        readJson(text);
    else
        readCsv(text);
    if (_rows.empty()) throw InputError(file + ": there are no rows");
    for (std::uint64_t row = 0; row < size(); ++row)
        arguments(row);
}

void SweepTable::fail(std::uint64_t row, const std::string& why) const
{
    throw InputError(fmt::format("{}: row {}: {}", _file, row, why));
}

void SweepTable::add(Row row)
{
    if (!row.is_object()) fail(size(), "is no object of names and values");
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

void SweepTable::readCsv(const std::string& text)
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
    if (!lines.empty()) // those that no row fills, too, in the order of the header
        _columns = lines[0];
}

void SweepTable::readJson(const std::string& text)
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
            if (!own.is_object()) fail(size(), "is no object of names and values");
            row.update(own);
            row.update(combination);
            add(std::move(row));
        }
}

std::string SweepTable::text(std::uint64_t row, const std::string& column) const
{
    const Row& one = _rows[row];
    return one.contains(column) ? textOfValue(one[column]) : std::string();
}

SolveArguments SweepTable::arguments(std::uint64_t row) const
{
    SolveArguments arguments;
    arguments.settings.threads = 1; // a process for each core
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
        std::reverse(words.begin(), words.end()); // CLI11 takes them from the back
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
        fail(row, "has neither a model nor a points-file");
    return arguments;
}

nlohmann::json SweepTable::describe() const
{
    const auto crcOf = [](const std::string& text, std::uint32_t crc = 0)
    { return base::crc32c(reinterpret_cast<const std::uint8_t*>(text.data()), text.size(), crc); };
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

} // namespace midair::samples
