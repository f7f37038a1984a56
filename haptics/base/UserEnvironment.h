#pragma once

#include <optional>
#include <string>

namespace midair::base
{

/// A variable of the environment as the user had set it when the program began; none where it was
/// not there. A file that a library reads (OSG's .p3d) can set variables too, so what is set later
/// is not the user's. Where /proc is not readable there are none.
std::optional<std::string> userVariable(const std::string& name);

/// The variable as it is now, by whomever.
std::optional<std::string> variableNow(const std::string& name);

/// What the program itself has set counts as the user's from now on: for programs that read nothing
/// that sets variables, and for tests.
void trustVariablesOfProgram();

} // namespace midair::base
