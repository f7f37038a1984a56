#include "haptics/base/Bytes.h"

#include <array>
#include <cstring>

#if defined(__x86_64__)
#include <nmmintrin.h>
#endif

namespace midair::base
{

namespace
{

using Tables = std::array<std::array<std::uint32_t, 256>, 8>;

// Table k gives the effect of a byte followed by k further bytes, so that one step takes eight
// bytes.
Tables makeTables()
{
    Tables tables{};
    for (std::uint32_t byte = 0; byte < 256; ++byte)
    {
        std::uint32_t crc = byte;
        for (int bit = 0; bit < 8; ++bit)
            crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0x82F63B78U : 0U);
        tables[0][byte] = crc;
    }
    for (std::size_t k = 1; k < tables.size(); ++k)
        for (std::size_t byte = 0; byte < 256; ++byte)
            tables[k][byte] = (tables[k - 1][byte] >> 8) ^ tables[0][tables[k - 1][byte] & 255U];
    return tables;
}

#if defined(__x86_64__)
// The polynomial is that of the processor's own instruction. Takes whole words; the rest is left.
__attribute__((target("sse4.2"))) std::uint32_t
crcOfWords(const std::uint8_t*& bytes, std::size_t& count, std::uint32_t crc)
{
    std::uint64_t wide = crc;
    for (; count >= 8; bytes += 8, count -= 8)
    {
        std::uint64_t word = 0;
        std::memcpy(&word, bytes, sizeof(word));
        wide = _mm_crc32_u64(wide, word);
    }
    return static_cast<std::uint32_t>(wide);
}
#endif

} // namespace

std::uint32_t crc32c(const std::uint8_t* bytes, std::size_t count, std::uint32_t crc)
{
    static const Tables kTables = makeTables();
    crc = ~crc;
#if defined(__x86_64__)
    static const bool hasInstruction = __builtin_cpu_supports("sse4.2") != 0;
    if (hasInstruction) crc = crcOfWords(bytes, count, crc);
#endif
    for (; count >= 8; bytes += 8, count -= 8)
    {
        const std::uint32_t low =
            crc ^ (std::uint32_t(bytes[0]) | std::uint32_t(bytes[1]) << 8 |
                   std::uint32_t(bytes[2]) << 16 | std::uint32_t(bytes[3]) << 24);
        crc = kTables[7][low & 255U] ^ kTables[6][(low >> 8) & 255U] ^
              kTables[5][(low >> 16) & 255U] ^ kTables[4][low >> 24] ^ kTables[3][bytes[4]] ^
              kTables[2][bytes[5]] ^ kTables[1][bytes[6]] ^ kTables[0][bytes[7]];
    }
    for (; count > 0; ++bytes, --count)
        crc = (crc >> 8) ^ kTables[0][(crc ^ *bytes) & 255U];
    return ~crc;
}

} // namespace midair::base
