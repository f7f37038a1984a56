#include "haptics/base/text/Number.h"

#include <array>
#include <charconv>
#include <cmath>

namespace midair::base
{

namespace
{

template<typename T>
bool parse(const std::string& text, T& value)
{
    const char* begin = text.data();
    const char* const end = begin + text.size();
    if (begin != end && *begin == '+' && end - begin > 1 && begin[1] != '-') ++begin;
    T read{};
    const auto [rest, error] = std::from_chars(begin, end, read);
    if (error != std::errc() || rest != end) return false;
    value = read;
    return true;
}

} // namespace

bool parseNumber(const std::string& text, double& value)
{
    double read = 0.0;
    if (!parse(text, read) || !std::isfinite(read)) return false;
    value = read;
    return true;
}

bool parseWhole(const std::string& text, int& value)
{
    return parse(text, value);
}

std::string shortNumber(double value)
{
    std::array<char, 32> text{};
    const auto end =
        std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6);
    return std::string(text.data(), end.ptr);
}

std::string exactNumber(double value)
{
    std::string text = shortNumber(value);
    double read = 0.0;
    if (!std::isfinite(value) || (parse(text, read) && read == value)) return text;
    std::array<char, 32> all{};
    const auto end = std::to_chars(all.data(), all.data() + all.size(), value);
    return std::string(all.data(), end.ptr);
}

} // namespace midair::base
