#pragma once

#include <string>

namespace midair::samples
{

/// Returns the path of \a name ("models/star.obj") below the samples' folder: that of the installed
/// samples where the program is installed, else that of the sources.
std::string sampleFile(const std::string& name);

} // namespace midair::samples
