#pragma once

#include <filesystem>

namespace midair::base
{

/// Returns the folder of the program or shared library that this function is linked into, with
/// symbolic links resolved; empty if it isn't known. What is installed beside it (arrays, OSG's
/// plugins, models) is found from there, so that an installed prefix can be moved.
std::filesystem::path ownFolder();

} // namespace midair::base
