#pragma once

#include <string>
#include <vector>

namespace midair::bridge
{

/// The fields of a line parted by commas, semicolons, tabs or blanks; empty for a blank line and for a # comment.
std::vector<std::string> splitColumns(const std::string& line);

/// Reads the whole of \a text as a finite number, whatever the locale; false otherwise.
bool parseNumber(const std::string& text, double& value);

} // namespace midair::bridge
