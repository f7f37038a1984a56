#pragma once

#include <osg/Matrixd>

#include <functional>
#include <string>

namespace osgMidair
{

/// One assignment: a name, its value, and the line of the text that it begins in, from 1.
struct Assignment
{
    std::string name;
    std::string value;
    int line = 1;
};

/// Calls \a take with each assignment in "a=1 b=two words; c=\"x y\"".
/// Assignments are separated by semicolons, commas or line ends, or by blanks if a new "name="
/// follows. A comma between two digits separates nothing. Quotes keep a value together. A word
/// without "=" comes with an empty name. # begins a comment up to the end of the line.
void forEachAssignment(const std::string& text, const std::function<void(const Assignment&)>& take);

/// Reads \a count finite numbers in \a unit, separated by blanks, into \a values, with a decimal
/// point in every locale; "0 5 12 cm", a unit behind them, counts for all of them, "5cm" for one.
/// For any other text it returns false and leaves \a values unchanged.
bool parseNumbers(const std::string& text,
                  double* values,
                  int count,
                  const std::string& unit = std::string());

/// Reads "1 0 0 0  0 1 0 0  0 0 1 0  x y z 1": 16 numbers, row by row as OSG writes them. Returns
/// false for any other text.
bool parseMatrix(const std::string& text, osg::Matrixd& matrix);

} // namespace osgMidair
