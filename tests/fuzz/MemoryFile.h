#pragma once

#include "tests/fuzz/Require.h"

#include <cstddef>
#include <cstdint>
#include <string>

#include <sys/mman.h>
#include <unistd.h>

/// A regular file in memory, for what is read by its name.
class MemoryFile
{
public:
    MemoryFile(const std::uint8_t* data, std::size_t size) :
        _file(::memfd_create("fuzz", MFD_CLOEXEC))
    {
        require(_file >= 0 && ::write(_file, data, size) == static_cast<ssize_t>(size),
                "there is memory for a file");
    }
    ~MemoryFile() { ::close(_file); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;

    std::string path() const { return "/proc/self/fd/" + std::to_string(_file); }

private:
    int _file;
};
