#pragma once

#include <string>
#include <vector>

namespace osgMidair
{

/// The numbers of the objects around a place in a file, outermost first.
class NumbersAround
{
public:
    void open() { _numbers.emplace_back(); }
    void close()
    {
        if (!_numbers.empty()) _numbers.pop_back();
    }
    bool isEmpty() const { return _numbers.empty(); }
    /// Gives the innermost object its number, which stands in \a line. Returns what is wrong with
    /// it; empty: nothing.
    std::string give(const std::string& number, int line);

private:
    std::vector<std::string> _numbers; ///< "": an object without one
};

/// Returns what is wrong with the objects' numbers (UniqueID) in \a text, a scene in .osgt, with
/// its line; empty: nothing. Where a number stands again OSG takes the object that had it first, in
/// place of what is written there: a child with the number of an object around it becomes its own
/// parent, which no traversal survives.
std::string repeatedNumber(const std::string& text);

} // namespace osgMidair
