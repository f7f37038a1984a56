#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace midair::bridge
{

/// Memory of large copies that have gone, for those that come: what the system gives anew has to be
/// mapped page by page, which takes several times as long as the copying. For any thread.
class SpareMemory : public std::enable_shared_from_this<SpareMemory>
{
public:
    using Bytes = std::shared_ptr<std::byte[]>;

    /// Returns \a size bytes, which come back here when the last user lets go of them.
    Bytes take(std::size_t size);
    /// Frees what nobody has taken since the last call.
    void forgetUnused();

    static constexpr std::size_t kLeast = 65536; ///< bytes; smaller memory is not kept
    static constexpr std::size_t kMost = 8;      ///< pieces kept

private:
    /// A piece that nobody uses.
    struct Spare
    {
        std::size_t size = 0;
        std::unique_ptr<std::byte[]> bytes;
        bool isOld = false; ///< was here at the last forgetUnused()
    };

    void giveBack(std::size_t size, std::unique_ptr<std::byte[]> bytes);

    std::mutex _mutex;
    std::vector<Spare> _spares;
};

/// Which bytes of two memories are compared: those of every \a parts th block, from the block \a
/// turn on, so that \a parts turns compare all.
struct ComparedBlocks
{
    std::size_t size = 0;  ///< bytes of either memory
    std::size_t block = 0; ///< bytes
    std::uint64_t parts = 1;
    std::uint64_t turn = 0;
};

bool isSame(const void* a, const void* b, const ComparedBlocks& which);

/// Bytes of an application's memory, copied at once or in slices. Not changed once it is whole, so
/// any thread may read it then.
class DataCopy
{
public:
    DataCopy() = default;
    /// For \a size bytes; \a spares may be null.
    explicit DataCopy(std::size_t size, const std::shared_ptr<SpareMemory>& spares = nullptr);

    /// Copies up to \a most of the bytes at \a data that are not copied yet; returns how many.
    std::size_t copyMore(const void* data, std::size_t most);
    bool isWhole() const { return _copied == _size; }
    std::size_t size() const { return _size; }
    const std::byte* data() const { return _bytes.get(); }

private:
    SpareMemory::Bytes _bytes;
    std::size_t _size = 0;
    std::size_t _copied = 0;
};

} // namespace midair::bridge
