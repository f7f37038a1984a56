#pragma once

#include <string>

namespace midair::base
{

/// Checks settings against their ranges and words the message for the first that is out of its own:
///     return RangeCheck("solver option ")
///         .atLeast("maxIterations", maxIterations, 0)
///         .within("maxAmplitudeStep", maxAmplitudeStep, 0.0, 1.0)
///         .passed(error);
/// gives "solver option maxAmplitudeStep is 2; it must be within 0 .. 1". NaN is out of every
/// range, and infinity out of those that have no upper end. Nothing is allocated as long as all
/// checks hold.
class RangeCheck
{
public:
    /// \a owner stands before the setting's name in the message, with its blank or colons; "":
    /// nothing does. It has to outlive the check.
    explicit RangeCheck(const char* owner = "") : _owner(owner) {}

    /// low <= value <= high. \a unit stands behind the value in the message, with a blank of its
    /// own.
    RangeCheck&
    within(const char* name, double value, double low, double high, const char* unit = "");
    /// low <= value < infinity.
    RangeCheck& atLeast(const char* name, double value, double low, const char* unit = "");
    /// low < value < infinity.
    RangeCheck& above(const char* name, double value, double low, const char* unit = "");
    /// Any other range, which \a range words: "0 (continuous) or 2 and up".
    RangeCheck& check(bool holds, const char* name, double value, const char* range);
    /// A condition that is not about one number; \a message is said behind the owner.
    RangeCheck& require(bool holds, const char* message);

    /// True if every check held; else the first message goes to \a error, where it is not null.
    bool passed(std::string* error) const;

private:
    void fail(const char* name, double value, const char* unit, const std::string& range);

    const char* _owner;
    std::string _message; // of the first that failed; empty: none so far
};

} // namespace midair::base
