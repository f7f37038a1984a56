#pragma once

#include <array>
#include <charconv>
#include <string>

#include <CLI/CLI.hpp>

namespace midair::samples
{

/// For CLI::Option::transform(): takes a number in \a unit, or with another unit of the same kind:
/// "8 cm" in "m" is 0.08. Anything else is refused. \a read: reads such a text.
inline CLI::Validator inUnit(const std::string& unit,
                             bool (*read)(const std::string&, const std::string&, double&))
{
    const auto convert = [unit, read](std::string& text) -> std::string
    {
        double value = 0.0;
        if (!read(text, unit, value))
            return "is \"" + text + "\", should be a number" + (unit.empty() ? "" : " in " + unit);
        std::array<char, 32> digits{};
        const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
        text.assign(digits.data(), end.ptr);
        return {};
    };
    return {convert, ""};
}

} // namespace midair::samples
