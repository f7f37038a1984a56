#pragma once

namespace midair::base
{

/// From now on userVariable() returns current values, as if they had been there when the program
/// began. In no installed header.
void trustVariablesOfProgram();

} // namespace midair::base
