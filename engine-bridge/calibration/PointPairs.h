#pragma once

#include <Eigen/Core>

#include <iosfwd>
#include <string>

namespace midair::bridge
{

/// The same physical spots measured twice: by whatever tracks the scene's world, and in the array
/// frame.
struct PointPairs
{
    Eigen::Matrix3Xd world; ///< 3 x n, metres
    Eigen::Matrix3Xd array; ///< 3 x n, metres

    int size() const { return static_cast<int>(world.cols()); }
};

/// Reads six columns a line: world x y z, array x y z, parted by commas, semicolons, tabs or
/// blanks. Blank lines and lines that begin with # are passed over, and so is a first line of
/// headings. \a name stands in messages. Throws base::InputError naming the line for a wrong count,
/// for what is no number, for what is not finite and for more than 10,000 pairs.
PointPairs readPointPairs(std::istream& in, const std::string& name);

/// "m", "cm", "mm", "um", "in", "ft", or a positive number: metres a unit. Throws base::InputError
/// for anything else.
double unitInMetres(const std::string& nameOrNumber);

/// "millimetres" for 0.001 and the like, within \a tolerance (relative); empty where no common unit
/// is near.
std::string unitName(double metres, double tolerance = 0.05);

} // namespace midair::bridge
