#include "haptics/base/text/Range.h"

#include "haptics/base/text/PlainText.h"

#include <cmath>

namespace midair::base
{

void RangeCheck::fail(const char* name, double value, const char* unit, const std::string& range)
{
    if (!_message.empty()) return;
    PlainStream text;
    text << _owner << name << " is " << value << unit << "; it must be " << range;
    _message = text.str();
}

RangeCheck&
RangeCheck::within(const char* name, double value, double low, double high, const char* unit)
{
    if (value >= low && value <= high) return *this;
    PlainStream range;
    range << "within " << low << " .. " << high;
    fail(name, value, unit, range.str());
    return *this;
}

RangeCheck& RangeCheck::atLeast(const char* name, double value, double low, const char* unit)
{
    if (value >= low && std::isfinite(value)) return *this;
    PlainStream range;
    range << (std::isinf(value) ? "finite and at least " : "at least ") << low;
    fail(name, value, unit, range.str());
    return *this;
}

RangeCheck& RangeCheck::above(const char* name, double value, double low, const char* unit)
{
    if (value > low && std::isfinite(value)) return *this;
    PlainStream range;
    range << (std::isinf(value) ? "finite and above " : "above ") << low;
    fail(name, value, unit, range.str());
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
