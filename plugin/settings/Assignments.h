#pragma once

#include <osg/Matrixd>

#include <functional>
#include <string>

namespace osgMidair
{

/// Calls \a take with name and value of each assignment in "a=1 b=two words; c=\"x y\"".
/// Assignments are parted by semicolons, commas or line ends, or by blanks where a new "name="
/// follows; quotes keep a value together; a word without "=" comes with an empty name; what follows
/// a # up to the line's end is a comment.
void forEachAssignment(const std::string& text,
                       const std::function<void(const std::string&, const std::string&)>& take);

/// One of them.
struct Assignment
{
    std::string name;
    std::string value;
};

/// Reads \a count finite numbers, parted by blanks, into \a values, with a point whatever the
/// locale; false, and \a values as they were, where it is anything else.
bool parseNumbers(const std::string& text, double* values, int count);

/// Reads "1 0 0 0  0 1 0 0  0 0 1 0  x y z 1": 16 numbers, row by row as OSG writes them; false
/// where it is anything else.
bool parseMatrix(const std::string& text, osg::Matrixd& matrix);

} // namespace osgMidair
