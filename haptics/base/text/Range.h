#pragma once

#include <string>

namespace midair::base
{

/// Checks settings against their ranges and makes a message for the first that is out of range:
///     return RangeCheck("solver option ")
///         .atLeast("maxIterations", maxIterations, 0)
///         .within("maxAmplitude", maxAmplitude, 0.0, 1.0)
///         .passed(error);
/// gives "solver option maxAmplitude is 2; it must be within 0 .. 1". NaN is out of every range;
/// infinity is out of ranges without an upper limit. Doesn't allocate while all checks pass.
class RangeCheck
{
public:
    /// \a owner: text before the setting's name, ending with a blank or colon. It must outlive the
    /// check.
    explicit RangeCheck(const char* owner = "") : _owner(owner) {}

    /// low <= value <= high. \a unit follows the value in the message and begins with a blank.
    RangeCheck&
    within(const char* name, double value, double low, double high, const char* unit = "");
    /// low <= value < infinity.
    RangeCheck& atLeast(const char* name, double value, double low, const char* unit = "");
    /// low < value < infinity.
    RangeCheck& above(const char* name, double value, double low, const char* unit = "");
    /// Any other range, described by \a range: "0 (continuous) or 2 and up".
    RangeCheck& check(bool holds, const char* name, double value, const char* range);
    /// A condition on more than one number; \a message follows the owner.
    RangeCheck& require(bool holds, const char* message);

    /// Returns true if every check passed; otherwise stores the first message in \a error, unless
    /// null.
    bool passed(std::string* error) const;

private:
    void fail(const char* name, double value, const char* unit, const std::string& range);

    const char* _owner;
    std::string _message; // of the first failed check; empty: none so far
};

} // namespace midair::base
