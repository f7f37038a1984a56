#pragma once

#include "haptics/array/TransducerArray.h"

#include <cstddef>
#include <string>
#include <vector>

namespace midair::samples
{

/// An array as Ultraino's simulator has saved it.
struct UltrainoSimulation
{
    haptics::TransducerArray array; ///< in the order of the wires
    std::vector<std::string>
        notes; ///< what of the file is taken in another way than it stands there
};

constexpr std::size_t kMostUltrainoBytes = std::size_t(16) << 20; ///< of the file
constexpr std::size_t kMostUltrainoXml = std::size_t(64) << 20;   ///< of what is in it

/// Reads the bytes of a `.xml.gz` file, or of one without compression (format:
/// samples/guides/ARRAYS.md); \a source: its name in messages. Throws InputError.
UltrainoSimulation readUltraino(const std::string& bytes, const std::string& source);

} // namespace midair::samples
