#pragma once

#include "samples/tools/solve/SolveOptions.h"

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace midair::samples
{

/// A table of parameters: what midair-solve would be asked for, row by row.
class SweepTable
{
public:
    /// Reads a CSV file, whose first line has the names, or a JSON file: an array of objects, or an
    /// object with any of "rows" (an array of objects), "common" (an object that each row has) and
    /// "cross" (an object of arrays: each row with each combination, the last name fastest). All
    /// rows are parsed. Throws base::InputError, which names the row and the column.
    explicit SweepTable(const std::string& file);

    std::uint64_t size() const { return _rows.size(); }
    /// Names of the parameters, in the order in which they come.
    const std::vector<std::string>& columns() const { return _columns; }
    /// Value of a parameter as text; empty: the row hasn't got it.
    std::string text(std::uint64_t row, const std::string& column) const;
    /// What the row asks for. Throws base::InputError.
    SolveArguments arguments(std::uint64_t row) const;

    /// What the results depend on: number of rows, their CRC-32C, and those of the files and arrays
    /// that they name.
    nlohmann::json describe() const;

private:
    using Row = nlohmann::ordered_json;

    void readCsv(const std::string& text);
    void readJson(const std::string& text);
    void add(Row row);
    [[noreturn]] void fail(std::uint64_t row, const std::string& why) const;

    std::string _file;
    std::vector<Row> _rows;
    std::vector<std::string> _columns;
};

} // namespace midair::samples
