#pragma once

#include "haptics/array/TransducerArray.h"

#include <string>

namespace midair::haptics
{

/// OpenMPD board with the values measured by its maker.
struct PatBoard
{
    std::string serial;    ///< serial number of its FT232H
    TransducerArray array; ///< in pin order, with measured offsets and gains; P0 and directivity
                           ///< from the data sheet
};

/// Reads the text of a `.pat` file (format: samples/guides/ARRAYS.md); \a source: its name in
/// messages. Throws InputError: "source, line N: what it is; what it must be".
PatBoard readPat(const std::string& text, const std::string& source);

} // namespace midair::haptics
