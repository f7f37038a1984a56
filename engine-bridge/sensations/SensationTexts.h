#pragma once

#include "engine-bridge/HapticObject.h"

#include <string>
#include <utility>
#include <vector>

// Texts of an object's sensation in scene files, tags and the C interface.
namespace midair::bridge
{

/// Reads "place", "surface", "hand:palm", "hand:index_tip" into \a attach and, for hands, \a joint.
/// Returns false for another text.
bool readAttachment(const std::string& text, SensationProperties::Attach& attach, int& joint);

/// Returns the problem of an attachment, with the nearest known one; empty: none.
std::string problemOfAttachment(const std::string& text);

/// Reads "strength=0.4; size=3", or with & between, into \a values, in its order; a name stands
/// once. Returns the problem, and leaves \a values as it was; empty: none.
std::string readParameters(const std::string& text,
                           std::vector<std::pair<std::string, double>>& values);

/// Returns the value of the property "plays" that begins a sensation anew: another one than \a
/// last, the highest so far, and \a now, the present one.
int nextPlays(int last, int now);

/// Returns a text that readParameters() reads as \a values.
std::string parametersText(const std::vector<std::pair<std::string, double>>& values);

} // namespace midair::bridge
