#pragma once

#include "haptics/tolerance/ToleranceStudy.h"
#include "samples/tools/solve/SolveOptions.h"

#include <string>

namespace CLI
{
class App;
}

namespace midair::samples
{

/// Adds --tolerance and its options to \a app.
void addToleranceOptions(CLI::App& app, SolveArguments& arguments);

/// Writes
///     deviation,value,unit,draws,rms,rms_p90,loudness,loudness_p10,focus,focus_p10,
///     expected_rms,expected_focus
/// to \a path: first the array as it was meant (nominal), then each value; what theory has no
/// figure for is empty. Throws base::InputError.
void writeTolerance(const std::string& path, const haptics::ToleranceStudy& study);

/// Prints what each value leaves, and the time that all took.
void printTolerance(const haptics::ToleranceStudy& study);

} // namespace midair::samples
