#pragma once

#include <Eigen/Core>

#include <iosfwd>
#include <string>

namespace midair::bridge
{

/// Physical points measured twice: by the tracker in the scene's world, and in the array frame.
struct PointPairs
{
    Eigen::Matrix3Xd world; ///< 3 x n, metres
    Eigen::Matrix3Xd array; ///< 3 x n, metres

    int size() const { return static_cast<int>(world.cols()); }
};

/// Reads lines of six columns: world x y z, array x y z, separated by commas, semicolons, tabs or
/// blanks. Skips blank lines, lines that begin with # and a first line of headings. \a name appears
/// in messages. Throws base::InputError, which names the line, for a wrong number of columns, for a
/// column that is not a finite number and for more than 10,000 pairs.
PointPairs readPointPairs(std::istream& in, const std::string& name);

/// Returns the metres per unit of "m", "cm", "mm", "um", "in", "ft" (or a full unit name), or a
/// positive number. Throws base::InputError for other texts.
double unitInMetres(const std::string& nameOrNumber);

/// Returns the name of the unit of \a metres, within a relative \a tolerance, such as "millimetres"
/// for 0.001; empty if no common unit is near.
std::string unitName(double metres, double tolerance = 0.05);

} // namespace midair::bridge
