#pragma once

#include <osgMidair/HapticSettings>

#include <string>

namespace osgMidair
{

/// The OSG_MIDAIR_* variables, listed by --help-env.
struct Environment
{
    /// \a settings with what the environment overrides; what isn't understood goes to \a errors.
    static HapticSettings apply(HapticSettings settings, std::vector<std::string>& errors);

    /// OSG_MIDAIR_REPORT; empty: no report.
    static std::string reportFile();
};

} // namespace osgMidair
