#pragma once

#include <stdexcept>

namespace osgMidair
{

/// A glTF file that isn't read; what() says what is wrong and what would be right.
class GltfError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

} // namespace osgMidair
