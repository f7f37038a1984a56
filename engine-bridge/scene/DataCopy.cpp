#include "engine-bridge/scene/DataCopy.h"

#include <algorithm>
#include <cstring>
#include <iterator>

namespace midair::bridge
{

SpareMemory::Bytes SpareMemory::take(std::size_t size)
{
    std::unique_ptr<std::byte[]> bytes;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        // The newest: older ones are soon known to be too many.
        const auto same = std::find_if(
            _spares.rbegin(), _spares.rend(), [size](const Spare& s) { return s.size == size; });
        if (same != _spares.rend())
        {
            bytes = std::move(same->bytes);
            _spares.erase(std::prev(same.base()));
        }
    }
    if (!bytes) bytes.reset(new std::byte[size]); // not make_unique, which would clear it first
    auto giveBack = [home = weak_from_this(), size](std::byte* gone)
    {
        std::unique_ptr<std::byte[]> owned(gone);
        if (const auto pool = home.lock()) pool->giveBack(size, std::move(owned));
    };
    return {bytes.release(), std::move(giveBack)};
}

void SpareMemory::giveBack(std::size_t size, std::unique_ptr<std::byte[]> bytes)
{
    std::unique_ptr<std::byte[]> surplus; // freed outside the lock
    const std::lock_guard<std::mutex> lock(_mutex);
    if (_spares.size() >= kMost)
    {
        surplus = std::move(_spares.front().bytes);
        _spares.erase(_spares.begin());
    }
    _spares.push_back({size, std::move(bytes)});
}

void SpareMemory::forgetUnused()
{
    std::vector<Spare> old;
    const std::lock_guard<std::mutex> lock(_mutex);
    const auto kept = std::stable_partition(
        _spares.begin(), _spares.end(), [](const Spare& s) { return !s.isOld; });
    std::move(kept, _spares.end(), std::back_inserter(old));
    _spares.erase(kept, _spares.end());
    for (Spare& spare : _spares)
        spare.isOld = true;
}

bool isSame(const void* a, const void* b, const ComparedBlocks& which)
{
    const std::uint64_t parts = std::max<std::uint64_t>(which.parts, 1);
    for (std::size_t at = which.block * (which.turn % parts); at < which.size;
         at += which.block * parts)
        if (std::memcmp(static_cast<const std::byte*>(a) + at,
                        static_cast<const std::byte*>(b) + at,
                        std::min(which.block, which.size - at)) != 0)
            return false;
    return true;
}

DataCopy::DataCopy(std::size_t size, const std::shared_ptr<SpareMemory>& spares) : _size(size)
{
    if (spares && size >= SpareMemory::kLeast)
        _bytes = spares->take(size);
    else if (size > 0)
        _bytes = SpareMemory::Bytes(new std::byte[size]);
}

std::size_t DataCopy::copyMore(const void* data, std::size_t most)
{
    const std::size_t now = std::min(most, _size - _copied);
    if (now > 0)
        std::memcpy(_bytes.get() + _copied, static_cast<const std::byte*>(data) + _copied, now);
    _copied += now;
    return now;
}

} // namespace midair::bridge
