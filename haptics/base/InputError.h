#pragma once

#include <stdexcept>

namespace midair::base
{

/// Error in input from outside (files, options): what() names the item, its value and what is
/// expected.
class InputError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

} // namespace midair::base
