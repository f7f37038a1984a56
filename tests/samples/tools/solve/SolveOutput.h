#pragma once

// Reads what midair-solve has written.
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

/// The rows of a table of numbers, and its first line in \a header.
inline std::vector<std::vector<double>> readCsv(const std::string& path,
                                                std::string* header = nullptr)
{
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    if (header) *header = line;
    std::vector<std::vector<double>> rows;
    while (std::getline(file, line))
    {
        std::stringstream cells(line);
        auto& row = rows.emplace_back();
        for (std::string cell; std::getline(cells, cell, ',');)
            row.push_back(std::strtod(cell.c_str(), nullptr));
    }
    return rows;
}

inline nlohmann::json readSummary(const std::string& out)
{
    std::ifstream file(out + "/summary.json");
    return nlohmann::json::parse(file);
}
