#pragma once

#include <stdexcept>

namespace midair::base
{

/// Error in external input (files, options). what() names the item, its value and the expected
/// value.
class InputError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

} // namespace midair::base
