#pragma once

#include <string>
#include <vector>

namespace midair::base
{

/// Splits a line at commas, semicolons, tabs and blanks. Returns no fields for a blank line or a #
/// comment.
std::vector<std::string> splitColumns(const std::string& line);

} // namespace midair::base
