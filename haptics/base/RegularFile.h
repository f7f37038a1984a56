#pragma once

#include "haptics/base/InputError.h"

#include <cstddef>
#include <string>

namespace midair::base
{

/// Error for a file that can't be read. what() gives the reason as a phrase to follow the file's
/// name, or begins with the caller's prefix.
class FileError : public InputError
{
public:
    using InputError::InputError;
};

/// Returns the content of a regular file of at most \a mostBytes. Follows links; never blocks, and
/// never reads devices, pipes or folders. Throws FileError whose text begins with \a before,
/// usually the file's name.
std::string
readRegularFile(const std::string& path, std::size_t mostBytes, const std::string& before = {});

} // namespace midair::base
