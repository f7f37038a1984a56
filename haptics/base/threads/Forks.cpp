#include "haptics/base/threads/Forks.h"

#include <pthread.h>

namespace midair::base
{

namespace
{

std::atomic<std::uint64_t> count{0};

// Little is allowed in a new child: it only counts.
void beChild()
{
    ++count;
}

// Before main(), so that all forks are counted.
const int kRegistered = ::pthread_atfork(nullptr, nullptr, beChild);

} // namespace

std::uint64_t forks() noexcept
{
    static_cast<void>(kRegistered);
    return count.load(std::memory_order_relaxed);
}

} // namespace midair::base
