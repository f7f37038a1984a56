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

} // namespace osgMidair
