#pragma once

#include <osgMidair/HapticSettings>

#include <string>

namespace osgMidair
{

/// The OSG_MIDAIR_* variables, listed by --help-env.
struct Environment
{
    /// Returns \a settings as the environment overrides them. Adds a sentence to \a errors for each
    /// value that isn't understood.
    static HapticSettings apply(HapticSettings settings, std::vector<std::string>& errors);

    /// Returns the file named by OSG_MIDAIR_REPORT; empty: no report.
    static std::string reportFile();
};

} // namespace osgMidair
