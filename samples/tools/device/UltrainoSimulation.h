#pragma once

#include "haptics/array/TransducerArray.h"

#include <cstddef>
#include <string>
#include <vector>

namespace midair::samples
{

/// An array saved by Ultraino's simulator.
struct UltrainoSimulation
{
    haptics::TransducerArray array; ///< in the order of the wires
    std::vector<std::string> notes; ///< differences between the array and the file
};

constexpr std::size_t kMostUltrainoBytes = std::size_t(16) << 20; ///< largest file
constexpr std::size_t kMostUltrainoXml = std::size_t(64) << 20;   ///< largest decompressed file

/// Parses a `.xml.gz` file or an uncompressed one (format: samples/guides/ARRAYS.md). \a source is
/// its name in messages. Throws InputError.
UltrainoSimulation readUltraino(const std::string& bytes, const std::string& source);

} // namespace midair::samples
