#pragma once

#include "haptics/array/TransducerArray.h"

#include <osgMidair/ArrayDescription>

namespace osgMidair
{

/// Returns \a description as the solver takes it. Throws midair::base::InputError, which names the
/// array, if it is not valid.
midair::haptics::TransducerArray arrayOf(const ArrayDescription& description);

/// Returns the description of a valid array.
ArrayDescription describe(const midair::haptics::TransducerArray& array);

} // namespace osgMidair
