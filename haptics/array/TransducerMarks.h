#pragma once

#include "haptics/array/TransducerArray.h"
#include "haptics/base/text/JsonReader.h"

namespace midair::haptics
{

/// Reads the lists of single transducers in an array's file, "dead" and "weak", into \a array,
/// whose transducers are read already. Throws InputError.
void readMarks(const base::JsonReader& reader,
               const base::JsonReader::Json& root,
               TransducerArray& array);

} // namespace midair::haptics
