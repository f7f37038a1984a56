#include "haptics/base/threads/Forks.h"

#include <pthread.h>

namespace midair::base
{

namespace
{

std::atomic<std::uint64_t> count{0};

// A child may do little before it is itself: it only counts.
void beChild()
{
    ++count;
}

// Before main(), so that no fork of the program goes unseen.
const int kRegistered = ::pthread_atfork(nullptr, nullptr, beChild);

} // namespace

std::uint64_t forks() noexcept
{
    static_cast<void>(kRegistered);
    return count.load(std::memory_order_relaxed);
}

} // namespace midair::base
