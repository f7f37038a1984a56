#pragma once

#include <cstddef>

namespace midair::base
{

/// Returns memory of \a bytes, aligned to 64 bytes and not set, for arrays that a solve reads and
/// writes; throws std::bad_alloc. It lies in huge pages where the system has them, and what is
/// given back is used again: the first touch of a page of 4 KiB costs 0.2 to 20 us, so that of the
/// 10 MB of a solve may take longer than the solve. In checked builds (sanitizers, without NDEBUG)
/// each array is allocated alone, and all its bytes are 0xff, so floats are NaN. Any thread; in the
/// child of a fork, too.
void* takeMemory(std::size_t bytes);
/// Gives \a memory of takeMemory(\a bytes) back. At most 64 MiB of arrays above 1 MiB are kept, and
/// all smaller ones.
void giveMemory(void* memory, std::size_t bytes) noexcept;

} // namespace midair::base
