#pragma once

#include "haptics/array/TransducerArray.h"

#include <vector>

namespace midair::haptics
{

/// Returns a reflector for each plane of boards of \a array: a rectangle around their transducers
/// and half a pitch beyond. Boards share one if their normals differ by at most 1 degree and their
/// middles by at most 1 mm along it. \a reflection, \a phase_rad, \a accuracy_mm: of each, see
/// Reflector. Throws base::InputError for a board that isn't flat to 1 mm, and for more than
/// kMostReflectingBoards planes.
std::vector<Reflector> boardReflectors(const TransducerArray& array,
                                       double reflection,
                                       double phase_rad,
                                       double accuracy_mm);

} // namespace midair::haptics
