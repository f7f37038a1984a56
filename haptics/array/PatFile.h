#pragma once

#include "haptics/array/TransducerArray.h"

#include <string>

namespace midair::haptics
{

/// An OpenMPD board as its maker measured it.
struct PatBoard
{
    std::string serial;    ///< of its FT232H
    TransducerArray array; ///< in pin order, with the offsets and gains measured
};

/// Reads the text of a `.pat` file (haptics/arrays/README.md says what is in one); \a source names
/// it in messages. Throws InputError: "source, line N: what it is; what it must be".
PatBoard readPat(const std::string& text, const std::string& source);

} // namespace midair::haptics
