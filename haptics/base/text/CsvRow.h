#pragma once

#include <string>
#include <vector>

namespace midair::base
{

/// The fields of a line parted by commas, semicolons, tabs or blanks; empty for a blank line and
/// for a # comment.
std::vector<std::string> splitColumns(const std::string& line);

} // namespace midair::base
