#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace midair::base
{

/// Returns an environment variable as it was at program start, or none. Libraries can set variables
/// from files (OSG's .p3d), so later values don't come from the user. Returns none if /proc is not
/// readable.
std::optional<std::string> userVariable(const std::string& name);

/// Returns the variable's present value, whoever set it, or none.
std::optional<std::string> variableNow(const std::string& name);

/// Returns the names of all present variables that begin with \a prefix, without the prefix.
std::vector<std::string> variablesNow(const std::string& prefix);

/// Returns the folder of the program or shared library that contains this function, with symbolic
/// links resolved; empty if unknown. Installed files (arrays, OSG's plugins, models) are found
/// relative to it, so an installed prefix can be moved.
std::filesystem::path ownFolder();

} // namespace midair::base
