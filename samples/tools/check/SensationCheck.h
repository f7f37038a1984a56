#pragma once

#include "samples/tools/check/SceneCheck.h"

namespace midair::samples
{

/// Returns true if \a object plays a sensation instead of its surface.
bool isSensation(const CheckedObject& object);

/// Adds what the sensation of \a object is, and why it didn't play if it has no points: its
/// trigger, or the hand that it needs. Returns false if its messages or the array have to say why.
bool judgeSensation(CheckedObject& object, const CheckedScene& scene);

} // namespace midair::samples
