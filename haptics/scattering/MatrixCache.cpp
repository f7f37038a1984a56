#include "haptics/scattering/MatrixCache.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

namespace midair::haptics
{

namespace
{

namespace fs = std::filesystem;

constexpr std::uint32_t kFormat = 1; // of files, and of how RigidBody makes what is in them
constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr const char* kEnding = ".body";
constexpr const char* kUnfinished = ".part";

struct CacheHead
{
    std::array<char, 8> name{'m', 'i', 'd', 'a', 'i', 'r', 'B', 'M'};
    std::uint32_t format = kFormat, byteOrder = kByteOrder;
    std::uint64_t size = 0, checksum = 0;
};

/// Mixes words as FNV-1a does bytes (Fowler, Noll, Vo), and high bits into low ones.
std::uint64_t hashOf(const void* data, std::size_t bytes, std::uint64_t hash)
{
    const auto* at = static_cast<const unsigned char*>(data);
    for (; bytes > 0; at += sizeof(hash))
    {
        std::uint64_t word = 0;
        const std::size_t now = std::min(bytes, sizeof(word));
        std::memcpy(&word, at, now);
        hash = (hash ^ word) * 0x00000100000001b3ULL;
        hash ^= hash >> 32;
        if (now < sizeof(word)) break;
        bytes -= now;
    }
    return hash;
}

std::uint64_t checksumOf(const Eigen::MatrixXcf& matrix)
{
    return hashOf(matrix.data(),
                  static_cast<std::size_t>(matrix.size()) * sizeof(std::complex<float>),
                  0xcbf29ce484222325ULL);
}

/// Returns why \a file doesn't have a matrix of \a n x \a n, which is read; empty: it has.
std::string whyWrong(const fs::path& file, Eigen::Index n, Eigen::MatrixXcf& matrix)
{
    std::error_code error;
    if (!fs::is_regular_file(file, error)) return "it is no file";
    const auto entries = static_cast<std::uintmax_t>(n) * static_cast<std::uintmax_t>(n);
    const std::uintmax_t payload = entries * sizeof(std::complex<float>);
    // The size is what the body needs, not what the file says.
    const std::uintmax_t size = fs::file_size(file, error);
    if (error || size != sizeof(CacheHead) + payload)
        return fmt::format("it has {} bytes, should have {}", size, sizeof(CacheHead) + payload);
    std::ifstream stream(file, std::ios::binary);
    CacheHead head, expected;
    if (!stream.read(reinterpret_cast<char*>(&head), sizeof(head))) return "it can't be read";
    if (head.name != expected.name || head.format != kFormat || head.byteOrder != kByteOrder ||
        head.size != static_cast<std::uint64_t>(n))
        return "its head is another's";
    matrix.resize(n, n);
    if (!stream.read(reinterpret_cast<char*>(matrix.data()), static_cast<std::streamsize>(payload)))
        return "it can't be read";
    if (checksumOf(matrix) != head.checksum) return "its checksum is wrong";
    return matrix.allFinite() ? "" : "it has numbers that aren't finite";
}

} // namespace

fs::path MatrixCache::fileFor(const ClosedBody& body, double wavelength_m) const
{
    const auto bytes = static_cast<std::size_t>(body.corners.size()) * sizeof(double);
    std::array<std::uint64_t, 2> hashes{0xcbf29ce484222325ULL, 0x9e3779b97f4a7c15ULL};
    for (std::uint64_t& hash : hashes)
    {
        hash = hashOf(&kFormat, sizeof(kFormat), hash);
        hash = hashOf(&wavelength_m, sizeof(wavelength_m), hash);
        hash = hashOf(body.corners.data(), bytes, hash);
    }
    return folder / fmt::format("{:016x}{:016x}{}", hashes[0], hashes[1], kEnding);
}

bool MatrixCache::read(const fs::path& file, Eigen::Index n, Eigen::MatrixXcf& matrix) const
{
    std::error_code error;
    if (folder.empty() || !fs::exists(fs::symlink_status(file, error))) return false;
    const std::string why = whyWrong(file, n, matrix);
    if (!why.empty())
    {
        tell(fmt::format("\"{}\" is not used: {}", file.string(), why));
        return false;
    }
    fs::last_write_time(file, fs::file_time_type::clock::now(), error); // so that it stays longest
    tell(fmt::format("read from \"{}\"", file.string()));
    return true;
}

void MatrixCache::write(const fs::path& file, const Eigen::MatrixXcf& matrix) const
{
    const auto payload = static_cast<std::streamsize>(matrix.size()) *
                         static_cast<std::streamsize>(sizeof(std::complex<float>));
    if (folder.empty() || static_cast<double>(payload) > mostBytes) return;
    std::error_code error;
    if (fs::create_directories(folder, error)) fs::permissions(folder, fs::perms::owner_all, error);
    fs::path other = file;
    other += fmt::format(".{}{}", getpid(), kUnfinished);
    CacheHead head;
    head.size = static_cast<std::uint64_t>(matrix.rows());
    head.checksum = checksumOf(matrix);
    std::ofstream stream(other, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(&head), sizeof(head));
    stream.write(reinterpret_cast<const char*>(matrix.data()), payload);
    stream.close();
    const bool isWritten = !stream.fail();
    if (isWritten) fs::rename(other, file, error);
    if (!isWritten || error)
    {
        fs::remove(other, error);
        return tell(fmt::format("\"{}\" can't be written; nothing is kept", file.string()));
    }
    tell(fmt::format("kept as \"{}\"", file.string()));
    prune();
}

// Files of a run that ended before it could rename them are removed after an hour.
void MatrixCache::prune() const
{
    std::vector<std::pair<fs::file_time_type, fs::path>> files;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    {
        if (!entry.is_regular_file(error)) continue;
        const fs::file_time_type used = entry.last_write_time(error);
        if (entry.path().extension() == kEnding)
            files.emplace_back(used, entry.path());
        else if (entry.path().extension() == kUnfinished &&
                 fs::file_time_type::clock::now() - used > std::chrono::hours(1))
            fs::remove(entry.path(), error);
    }
    std::sort(files.rbegin(), files.rend());
    double bytes = 0.0;
    for (const auto& [used, file] : files)
    {
        bytes += static_cast<double>(fs::file_size(file, error));
        if (bytes <= mostBytes) continue;
        if (fs::remove(file, error))
            tell(fmt::format(
                "\"{}\" is removed: more than {:.3g} GB", file.string(), 1e-9 * mostBytes));
    }
}

void MatrixCache::tell(const std::string& what) const
{
    if (told) told(what);
}

} // namespace midair::haptics
