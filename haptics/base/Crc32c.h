#pragma once

#include <cstddef>
#include <cstdint>

namespace midair::base
{

/// CRC-32C (Castagnoli, reflected polynomial 0x82F63B78, start and final xor 0xFFFFFFFF; RFC 3720,
/// B.4). \a crc: result for the bytes before, to process data in pieces.
std::uint32_t crc32c(const std::uint8_t* bytes, std::size_t count, std::uint32_t crc = 0);

} // namespace midair::base
