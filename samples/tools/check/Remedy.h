#pragma once

#include "samples/tools/check/SceneCheck.h"

#include <string>
#include <vector>

namespace midair::samples
{

/// One of the options of -O, as "NAME=VALUE" or as a word, which has an empty name.
struct GivenOption
{
    std::string name;
    std::string value; ///< with its quotes

    bool operator==(const GivenOption& other) const
    {
        return name == other.name && value == other.value;
    }
};
using GivenOptions = std::vector<GivenOption>;

/// Splits the text of -O as the kit does.
GivenOptions optionsIn(const std::string& text);

/// Returns the first option that only MODEL.haptic accepts (a property or a place) as text; empty:
/// there is none.
std::string modelOption(const GivenOptions& options);

/// Returns sentences about the options that neither the kit nor a loaded reader knows.
std::vector<std::string> unknownOptions(const GivenOptions& options);

/// Returns what could be checked instead of \a options, the likeliest first, so that the objects of
/// \a result are felt. Each is still to be tried.
std::vector<CheckOptions> remedies(const CheckResult& result, const CheckOptions& options);

/// Returns the command line that checks \a options.
std::string commandOf(const CheckOptions& options);

} // namespace midair::samples
