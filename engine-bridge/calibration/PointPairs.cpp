#include "engine-bridge/calibration/PointPairs.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <array>
#include <cmath>
#include <istream>
#include <vector>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// A unit of length.
struct Unit
{
    const char* symbol;
    const char* name;
    double metres;
};

constexpr std::array<Unit, 6> kUnits = {{{"m", "metres", 1.0},
                                         {"cm", "centimetres", 1e-2},
                                         {"mm", "millimetres", 1e-3},
                                         {"um", "micrometres", 1e-6},
                                         {"in", "inches", 0.0254},
                                         {"ft", "feet", 0.3048}}};

constexpr std::size_t kMostPairs = 10000;

bool anyNumber(const std::vector<std::string>& fields)
{
    double value = 0.0;
    for (const std::string& field : fields)
        if (base::parseNumber(field, value)) return true;
    return false;
}

} // namespace

PointPairs readPointPairs(std::istream& in, const std::string& name)
{
    std::vector<std::array<double, 6>> rows;
    std::string line;
    bool first = true;
    for (int number = 1; std::getline(in, line); ++number)
    {
        const std::vector<std::string> fields = base::splitColumns(line);
        if (fields.empty()) continue;
        const bool headings = first && !anyNumber(fields);
        first = false;
        if (headings) continue;
        const std::string where = fmt::format("{}, line {}: ", name, number);
        if (fields.size() != 6)
            throw base::InputError(
                fmt::format("{}{} columns; a point pair has six: world x, y, z, array x, y, z",
                            where,
                            fields.size()));
        std::array<double, 6> row{};
        for (std::size_t i = 0; i < 6; ++i)
            if (!base::parseNumber(fields[i], row[i]))
                throw base::InputError(fmt::format(
                    "{}\"{}\" in column {} is not a finite number", where, fields[i], i + 1));
        if (rows.size() == kMostPairs)
            throw base::InputError(fmt::format(
                "{}more than {} point pairs, which are the most possible", where, kMostPairs));
        rows.push_back(row);
    }
    PointPairs pairs;
    pairs.world.resize(3, static_cast<Eigen::Index>(rows.size()));
    pairs.array.resize(3, static_cast<Eigen::Index>(rows.size()));
    for (Eigen::Index k = 0; k < pairs.world.cols(); ++k)
    {
        const std::array<double, 6>& row = rows[static_cast<std::size_t>(k)];
        pairs.world.col(k) = Eigen::Vector3d(row[0], row[1], row[2]);
        pairs.array.col(k) = Eigen::Vector3d(row[3], row[4], row[5]);
    }
    return pairs;
}

double unitInMetres(const std::string& nameOrNumber)
{
    for (const Unit& unit : kUnits)
        if (nameOrNumber == unit.symbol || nameOrNumber == unit.name) return unit.metres;
    double value = 0.0;
    if (base::parseNumber(nameOrNumber, value) && value > 0.0) return value;
    throw base::InputError("unit \"" + nameOrNumber +
                           "\" is not known; give m, cm, mm, um, in, ft, or the metres a unit has");
}

std::string unitName(double metres, double tolerance)
{
    for (const Unit& unit : kUnits)
        if (std::abs(metres / unit.metres - 1.0) <= tolerance) return unit.name;
    return {};
}

} // namespace midair::bridge
