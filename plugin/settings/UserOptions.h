#pragma once

#include <osgMidair/HapticSettings>

#include <string>
#include <vector>

namespace osgMidair
{

/// The OSG_MIDAIR_* variables, listed by --help-env.
struct Environment
{
    /// Returns \a settings with the environment's overrides, without the user's caps, which
    /// restrict() or the player adds. Adds a sentence to \a errors for each invalid value, or to
    /// HapticSettings::whySilenced if it silences the array.
    static HapticSettings replace(HapticSettings settings, std::vector<std::string>& errors);
    /// Returns \a settings with the user's caps; an invalid one silences.
    static HapticSettings restrict(HapticSettings settings);

    /// Returns true if the user touches with the mouse (OSG_MIDAIR_HANDS=mouse:). What is touched
    /// is played as contacts then, unless OSG_MIDAIR_RENDER says otherwise.
    static bool isByMouse();

    /// Returns the file named by OSG_MIDAIR_REPORT; empty: no report.
    static std::string reportFile();
};

/// Returns the options of the command line, "-O ..", which come from the user. A reader's options
/// may come from elsewhere: other kinds of files (OSG's .p3d) pass their own.
std::string userOptions();

/// Sets the settings in the user's options. Warns about invalid values; ignores options for other
/// readers.
void applyUserOptions(HapticSettings& settings);

/// Turns the device, array, hands and thermometer of \a settings into requests, unless they are the
/// defaults or equal the user's options. \a folder: folder of the file.
void makeWishes(HapticSettings& settings, const std::string& folder);

/// Options of MODEL.haptic that place a model.
inline constexpr const char* kPlacingOptions[] = {"size", "position", "rotation", "overlays"};

/// Returns the names of all options: settings, properties and those that place a model.
std::vector<std::string> optionNames();

/// Returns a warning if \a word, which has no "=", was meant for the kit: the rest of a list of
/// devices cut at its comma, or an option without its "=", as "size:0.08" or "size 0.08". Empty for
/// other words, which belong to other readers.
std::string wordWarning(const std::string& word);

/// Returns true if safety may depend on such a word.
bool isSafetyWord(const std::string& word);

} // namespace osgMidair
