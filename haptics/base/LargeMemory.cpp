#include "haptics/base/LargeMemory.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <new>
#include <vector>

#include <pthread.h>
#include <sys/mman.h>

#ifdef __has_feature
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MIDAIR_CHECKED_MEMORY
#endif
#if __has_feature(memory_sanitizer)
#define MIDAIR_CHECKED_MEMORY
#define MIDAIR_WATCHED_MEMORY // it knows what is not set
#endif
#endif
#if !defined(NDEBUG) || defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MIDAIR_CHECKED_MEMORY
#endif

namespace midair::base
{

namespace
{

constexpr std::size_t kAlignment = 64; // a cache line, an AVX-512 register

void* allocated(std::size_t bytes)
{
    return ::operator new (bytes, std::align_val_t{kAlignment});
}

void freed(void* memory) noexcept
{
    ::operator delete (memory, std::align_val_t{kAlignment});
}

} // namespace

#ifdef MIDAIR_CHECKED_MEMORY

void* takeMemory(std::size_t bytes)
{
    void* memory = allocated(bytes);
#ifndef MIDAIR_WATCHED_MEMORY
    std::memset(memory, 0xff, bytes);
#endif
    return memory;
}

void giveMemory(void* memory, std::size_t) noexcept
{
    freed(memory);
}

#else

namespace
{

constexpr std::size_t kHuge = 2U << 20;      // bytes of a huge page
constexpr std::size_t kSmallest = 4096;      // smaller arrays are left to the system's allocator
constexpr std::size_t kLargest = kHuge >> 1; // of those that share huge pages
constexpr std::size_t kMostKept = 64U << 20; // bytes of larger ones

/// Huge pages, whole ones for large arrays, and parts of powers of two.
class HugePages
{
public:
    void* take(std::size_t bytes)
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        if (bytes > kLargest) return takeWhole(wholeOf(bytes));
        std::size_t index = indexOf(bytes);
        std::size_t from = index;
        while (from < _parts.size() && _parts[from] == nullptr)
            ++from;
        Part* part = nullptr;
        if (from < _parts.size())
        {
            part = _parts[from];
            _parts[from] = part->next;
        }
        else
            part = static_cast<Part*>(mapped(kHuge));
        // The upper halves of what is too large are free parts.
        for (; from > index; --from)
        {
            auto* half =
                reinterpret_cast<Part*>(reinterpret_cast<char*>(part) + (kSmallest << (from - 1)));
            half->next = _parts[from - 1];
            _parts[from - 1] = half;
        }
        return part;
    }

    void give(void* memory, std::size_t bytes) noexcept
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        if (bytes > kLargest) return giveWhole(memory, wholeOf(bytes));
        auto* part = static_cast<Part*>(memory);
        Part*& first = _parts[indexOf(bytes)];
        part->next = first;
        first = part;
    }

    /// \{ Held while the program forks, so that the guarded data is consistent.
    void lock() { _mutex.lock(); }
    void unlock() { _mutex.unlock(); }
    /// \}

private:
    /// Begin of a free part.
    struct Part
    {
        Part* next;
    };
    /// A free array of whole pages.
    struct Whole
    {
        void* memory;
        std::size_t bytes;
    };

    static std::size_t wholeOf(std::size_t bytes) { return (bytes + kHuge - 1) / kHuge * kHuge; }
    /// Parts of an index have kSmallest << index bytes.
    static std::size_t indexOf(std::size_t bytes)
    {
        std::size_t index = 0;
        while (kSmallest << index < bytes)
            ++index;
        return index;
    }

    static void* mapped(std::size_t bytes)
    {
        void* all = ::mmap(
            nullptr, bytes + kHuge, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (all == MAP_FAILED) throw std::bad_alloc();
        auto* begin = static_cast<char*>(all);
        const std::size_t before = (kHuge - reinterpret_cast<std::uintptr_t>(all) % kHuge) % kHuge;
        if (before > 0) ::munmap(begin, before);
        ::munmap(begin + before + bytes, kHuge - before);
        ::madvise(begin + before, bytes, MADV_HUGEPAGE); // otherwise its pages are small
        return begin + before;
    }

    void* takeWhole(std::size_t bytes)
    {
        const auto found = std::find_if(
            _whole.begin(), _whole.end(), [&](const Whole& one) { return one.bytes == bytes; });
        if (found == _whole.end())
        {
            _whole.reserve(_whole.size() + ++_wholeInUse); // so that give() needs no memory
            return mapped(bytes);
        }
        void* memory = found->memory;
        _kept -= bytes;
        ++_wholeInUse;
        _whole.erase(found);
        return memory;
    }

    void giveWhole(void* memory, std::size_t bytes) noexcept
    {
        --_wholeInUse;
        if (_kept + bytes > kMostKept)
        {
            ::munmap(memory, bytes);
            return;
        }
        _kept += bytes;
        _whole.push_back({memory, bytes});
    }

    std::mutex _mutex;             // of all below
    std::array<Part*, 9> _parts{}; // free ones, kSmallest .. kLargest
    std::vector<Whole> _whole;     // free ones
    std::size_t _wholeInUse = 0;
    std::size_t _kept = 0; // bytes of _whole
};

// Never destroyed: static objects may give memory back later.
HugePages& hugePages()
{
    static auto* const all = new HugePages;
    return *all;
}

const int kMemoryWatchesForks = ::pthread_atfork(
    [] { hugePages().lock(); }, [] { hugePages().unlock(); }, [] { hugePages().unlock(); });

} // namespace

void* takeMemory(std::size_t bytes)
{
    static_cast<void>(kMemoryWatchesForks);
    return bytes < kSmallest ? allocated(bytes) : hugePages().take(bytes);
}

void giveMemory(void* memory, std::size_t bytes) noexcept
{
    if (bytes < kSmallest)
        freed(memory);
    else
        hugePages().give(memory, bytes);
}

#endif

} // namespace midair::base
