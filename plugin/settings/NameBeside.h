#pragma once

#include <osgMidair/HapticSettings>

#include <string>

namespace osgMidair
{

/// Returns the path of the file \a name in \a folder, that of the file which names it; \a name
/// itself if it is absolute, or if there is no such file.
std::string nameBeside(const std::string& folder, const std::string& name);

/// Looks up the array, the thermometer and the recording of hands in \a settings beside the user's
/// own file that they are from, as nameBeside() does.
void lookBeside(const std::string& folder, HapticSettings& settings);

} // namespace osgMidair
