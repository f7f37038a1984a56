#pragma once

#include <filesystem>
#include <string>

#include <fcntl.h>
#include <unistd.h>

namespace midair::samples
{

/// Makes the new name of the file \a path outlive a power failure, as far as the file system can.
inline void syncFolderOf(const std::string& path)
{
    const std::string folder = std::filesystem::path(path).parent_path().string();
    const int file =
        ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) return;
    ::fsync(file);
    ::close(file);
}

} // namespace midair::samples
