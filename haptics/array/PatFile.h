#pragma once

#include "haptics/array/TransducerArray.h"

#include <string>

namespace midair::haptics
{

/// OpenMPD board as measured by its maker.
struct PatBoard
{
    std::string serial;    ///< serial number of its FT232H
    TransducerArray array; ///< in pin order, with the measured offsets and gains; P0 and
                           ///< directivity are the transducer's data sheet's
};

/// Reads the text of a `.pat` file (format: samples/guides/ARRAYS.md); \a source: its name in
/// messages. Throws InputError: "source, line N: what it is; what it must be".
PatBoard readPat(const std::string& text, const std::string& source);

} // namespace midair::haptics
