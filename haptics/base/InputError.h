#pragma once

#include <stdexcept>

namespace midair::base
{

/// Thrown where the outside comes in (files, options): what() names the thing, the value and what
/// would be right.
class InputError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

} // namespace midair::base
