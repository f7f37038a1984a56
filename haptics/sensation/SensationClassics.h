#pragma once

#include "haptics/sensation/Sensation.h"

#include <string>
#include <vector>

namespace midair::haptics
{

/// Returns the names of the classics: sensations that designers know from other systems, most of
/// them from Ultraleap's, made as patterns.
std::vector<std::string> sensationClassics();

/// Returns true if \a text is a classic's name, with parameters or without: "circle?radius=20mm".
bool isClassicSensation(const std::string& text);

/// Returns the sentence of a classic and its parameters with their units, ranges and defaults, a
/// line each; for help. Empty for another name.
std::string describeClassic(const std::string& name);

/// Makes the classic \a text, a name with parameters: "circle?radius=20mm&frequency=70Hz". Numbers
/// have units that convert; without one they are mm, ms, Hz or degrees. The pattern defines these
/// parameters, with the values as their defaults, so a program may change them while it plays.
/// Places of hands ("lightning?tips=0 95 0 mm; -25 85 0 mm") are fixed. Throws InputError for an
/// unknown name or parameter, with the nearest known one, and for a value out of its range.
Sensation classicSensation(const std::string& text);

} // namespace midair::haptics
