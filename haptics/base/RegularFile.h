#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace midair::base
{

/// Error for a file that can't be read: what() gives the reason as a phrase to follow the file's
/// name.
class FileError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// Returns the content of a regular file of at most \a mostBytes. Follows links; never blocks, and
/// never reads from a device, a pipe or a folder. Throws FileError.
std::string readRegularFile(const std::string& path, std::size_t mostBytes);

} // namespace midair::base
