#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace midair::base
{

/// Thrown where a file can't be read: what() says why, as a half sentence that follows the file's
/// name.
class FileError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// The whole of a regular file, of at most \a mostBytes. Follows links; never waits, and never
/// reads from a device, a pipe or a folder, whatever \a path names. Throws FileError.
std::string readRegularFile(const std::string& path, std::size_t mostBytes);

} // namespace midair::base
