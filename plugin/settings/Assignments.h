#pragma once

#include <osg/Matrixd>

#include <string>
#include <vector>

namespace osgMidair
{

/// An assignment: name, value, and the line of the text in which it begins, from 1.
struct Assignment
{
    std::string name;
    std::string value;
    int line = 1;
};

/// Returns the assignments in "a=1 b=two words; c=\"x y\"".
/// Assignments are separated by semicolons, commas or line ends, or by blanks if a new "name="
/// follows. A comma between two digits separates nothing. Quotes keep a value together. A word
/// without "=" comes with an empty name. # begins a comment up to the end of the line.
std::vector<Assignment> assignmentsIn(const std::string& text);

/// Message for a repeated \a name, because it is unclear which one was meant. \a isSafety: it
/// silences.
inline std::string givenTwice(const std::string& name, bool isSafety)
{
    return name + " is given twice" + (isSafety ? "; nothing is played" : "; the first counts");
}

/// Reads \a count finite numbers in \a unit, separated by blanks, into \a values, with a decimal
/// point in every locale. A unit at the end, "0 5 12 cm", applies to all of them, "5cm" to one. For
/// any other text it returns false and leaves \a values unchanged.
bool parseNumbers(const std::string& text,
                  double* values,
                  int count,
                  const std::string& unit = std::string());

/// Reads "1 0 0 0  0 1 0 0  0 0 1 0  x y z 1": 16 numbers, row by row as OSG writes them. Returns
/// false for any other text.
bool parseMatrix(const std::string& text, osg::Matrixd& matrix);

} // namespace osgMidair
