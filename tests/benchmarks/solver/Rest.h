#pragma once

namespace midair::bench
{

/// Prints loudness, error and duration of fields at rest (haptics::LouderPhases and the walk there)
/// beside those of a start from nothing, of the other methods, and of the best of many starts.
void printRest();

} // namespace midair::bench
