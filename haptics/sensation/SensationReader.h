#pragma once

#include "haptics/sensation/Sensation.h"

#include <cstddef>
#include <string>

namespace midair::haptics
{

/// Largest file of a pattern.
constexpr std::size_t kMostSensationBytes = std::size_t(4) << 20;

/// Reads the text of an AdapTics file (.adaptics, JSON; revisions 0.0.10-alpha.1, 0.1.0-alpha.2 and
/// 0.1.0-alpha.3). Keyframes may be in any order, unknown keys are ignored. Throws InputError
/// "SOURCE, line N: PATH is VALUE; it must be RIGHT" for a pattern that AdapTics refuses too, and
/// for one above kMostKeyframes, kMostParameters, 1,000 jumps of a keyframe, or the limits of
/// SensationNumber.
Sensation readSensation(const std::string& text, const std::string& source);

/// Returns the classic \a nameOrPath ("circle?radius=20mm", see SensationClassics.h), or reads the
/// file at that path, at most kMostSensationBytes. Throws InputError.
Sensation loadSensation(const std::string& nameOrPath);

} // namespace midair::haptics
