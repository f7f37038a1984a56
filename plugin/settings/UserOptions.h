#pragma once

#include <osgMidair/HapticSettings>

#include <string>

namespace osgMidair
{

/// The OSG_MIDAIR_* variables, listed by --help-env.
struct Environment
{
    /// Returns \a settings as the environment overrides them, but for the user's caps, which
    /// restrict() or whoever plays adds. Adds a sentence to \a errors for each value that isn't
    /// understood, or to HapticSettings::whySilenced if it silences the array.
    static HapticSettings replace(HapticSettings settings, std::vector<std::string>& errors);
    /// Returns \a settings with the user's caps; one that isn't understood silences.
    static HapticSettings restrict(HapticSettings settings);

    /// Returns the file named by OSG_MIDAIR_REPORT; empty: no report.
    static std::string reportFile();
};

/// Returns the options of the command line, "-O ..", which come from the user. The options that a
/// reader gets may come from elsewhere: other kinds of files (OSG's .p3d) pass their own.
std::string userOptions();

/// Sets the settings that the user's options name. Values that aren't understood give a warning;
/// options for other readers are ignored.
void applyUserOptions(HapticSettings& settings);

/// Turns the device, array, hands and thermometer of \a settings into wishes, unless they are the
/// defaults or the user's options set the same values. \a folder: folder of the file.
void makeWishes(HapticSettings& settings, const std::string& folder);

/// Returns a warning if \a word, which has no "=", looks like the rest of a list of devices that
/// was cut at its comma; empty for other words.
std::string cutListWarning(const std::string& word);

} // namespace osgMidair
