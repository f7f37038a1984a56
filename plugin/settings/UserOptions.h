#pragma once

#include <osgMidair/HapticSettings>

#include <functional>
#include <string>

namespace osgMidair
{

/// The options of the command line, "-O ..", which are the user's. The options that a reader is
/// given need not be: files of other kinds (OSG's .p3d) hand over their own.
std::string userOptions();

/// Sets what of the settings the user's options name. What isn't understood is a warning; options
/// for other readers are passed over.
void applyUserOptions(HapticSettings& settings);

/// Turns what \a settings have of \a given options for device, array and hands into wishes, unless
/// the user's say the same.
void makeWishes(HapticSettings& settings, const std::string& folder);

/// A word without "=" that looks like the rest of a list of devices, cut off at its comma: what to
/// say then; empty for others.
std::string cutListWarning(const std::string& word);

} // namespace osgMidair
