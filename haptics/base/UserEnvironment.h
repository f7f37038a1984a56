#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace midair::base
{

/// Returns an environment variable as it was when the program began, or none. Files that libraries
/// read (OSG's .p3d) can set variables, so later values do not come from the user. Where /proc is
/// not readable there are none.
std::optional<std::string> userVariable(const std::string& name);

/// Returns the current value of the variable, whoever set it, or none.
std::optional<std::string> variableNow(const std::string& name);

/// Returns the names of all variables that are set now and begin with \a prefix, without it.
std::vector<std::string> variablesNow(const std::string& prefix);

/// Returns the folder of the program or shared library that this function is linked into, with
/// symbolic links resolved; empty if it isn't known. What is installed beside it (arrays, OSG's
/// plugins, models) is found from there, so that an installed prefix can be moved.
std::filesystem::path ownFolder();

} // namespace midair::base
