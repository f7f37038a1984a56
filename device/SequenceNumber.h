#pragma once

#include <cstdint>

namespace midair::device
{

/// Returns true if sequence number \a a is newer than \a b; numbers wrap around (RFC 1982).
inline bool newer(std::uint32_t a, std::uint32_t b)
{
    return static_cast<std::int32_t>(a - b) > 0;
}

/// Returns the number after \a sequence; never 0, which means none.
inline std::uint32_t nextAfter(std::uint32_t sequence)
{
    return sequence + 1 == 0 ? 1 : sequence + 1;
}

} // namespace midair::device
