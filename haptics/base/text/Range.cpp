#include "haptics/base/text/Range.h"

#include "haptics/base/text/Number.h"

#include <cmath>

#include <fmt/format.h>

namespace midair::base
{

void RangeCheck::fail(const char* name, double value, const char* unit, const std::string& range)
{
    if (!_message.empty()) return;
    _message =
        fmt::format("{}{} is {}{}; it must be {}", _owner, name, exactNumber(value), unit, range);
}

RangeCheck&
RangeCheck::within(const char* name, double value, double low, double high, const char* unit)
{
    if (value >= low && value <= high) return *this;
    fail(name, value, unit, fmt::format("within {:g} .. {:g}", low, high));
    return *this;
}

RangeCheck& RangeCheck::atLeast(const char* name, double value, double low, const char* unit)
{
    if (value >= low && std::isfinite(value)) return *this;
    fail(name,
         value,
         unit,
         fmt::format("{}at least {:g}", std::isinf(value) ? "finite and " : "", low));
    return *this;
}

RangeCheck& RangeCheck::above(const char* name, double value, double low, const char* unit)
{
    if (value > low && std::isfinite(value)) return *this;
    fail(name,
         value,
         unit,
         fmt::format("{}above {:g}", std::isinf(value) ? "finite and " : "", low));
    return *this;
}

RangeCheck& RangeCheck::check(bool holds, const char* name, double value, const char* range)
{
    if (!holds) fail(name, value, "", range);
    return *this;
}

RangeCheck& RangeCheck::require(bool holds, const char* message)
{
    if (!holds && _message.empty()) _message = std::string(_owner) + message;
    return *this;
}

bool RangeCheck::passed(std::string* error) const
{
    if (_message.empty()) return true;
    if (error != nullptr) *error = _message;
    return false;
}

} // namespace midair::base
