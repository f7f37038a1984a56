#include "haptics/base/text/Number.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

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

/// Splits \a text at commas; empty texts have no parts.
std::vector<std::string> partsOf(const std::string& text)
{
    if (trimmed(text).empty()) return {};
    std::vector<std::string> parts = splitAt(text, ',');
    for (std::string& part : parts)
        part = trimmed(part);
    return parts;
}

/// Reads "17" or "400-410". Returns false for anything else.
bool readRange(const std::string& text, int& first, int& last)
{
    // A leading minus is not a range: indices have no sign.
    const std::size_t dash = text.find('-');
    if (!parseWhole(trimmed(text.substr(0, dash)), first)) return false;
    last = first;
    if (dash != std::string::npos && !parseWhole(trimmed(text.substr(dash + 1)), last))
        return false;
    return first >= 0 && last >= first && last <= kMostIndex;
}

/// Throws for the first duplicate index in the sorted \a numbers.
void refuseDoubles(const std::vector<std::pair<int, double>>& numbers, const std::string& what)
{
    const auto twice =
        std::adjacent_find(numbers.begin(),
                           numbers.end(),
                           [](const auto& a, const auto& b) { return a.first == b.first; });
    if (twice != numbers.end())
        throw InputError(fmt::format("{} has {} twice; it must be there once", what, twice->first));
}

std::vector<std::pair<int, double>> sorted(std::vector<std::pair<int, double>> numbers,
                                           const std::string& what)
{
    std::sort(numbers.begin(), numbers.end());
    refuseDoubles(numbers, what);
    return numbers;
}

/// Appends \a first to \a last. Throws if there are more than possible without duplicates.
void append(int first,
            int last,
            double number,
            const std::string& what,
            std::vector<std::pair<int, double>>& numbers)
{
    for (int i = first; i <= last; ++i)
        numbers.emplace_back(i, number);
    if (numbers.size() > static_cast<std::size_t>(kMostIndex) + 1)
        refuseDoubles(sorted(numbers, what), what);
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

std::vector<int> parseIndices(const std::string& text, const std::string& what)
{
    std::vector<std::pair<int, double>> numbers;
    for (const std::string& part : partsOf(text))
    {
        int first = 0, last = 0;
        if (!readRange(part, first, last))
            throw InputError(fmt::format("{} has \"{}\", should be numbers of transducers and "
                                         "ranges of them, 0 to {}: 17, 400-410",
                                         what,
                                         part,
                                         kMostIndex));
        append(first, last, 0.0, what, numbers);
    }
    std::vector<int> indices;
    for (const auto& [index, none] : sorted(std::move(numbers), what))
        indices.push_back(index);
    return indices;
}

std::vector<std::pair<int, double>>
parseIndexedNumbers(const std::string& text, const std::string& what, double most)
{
    std::vector<std::pair<int, double>> numbers;
    for (const std::string& part : partsOf(text))
    {
        const std::size_t colon = part.find(':');
        int first = 0, last = 0;
        double number = 0.0;
        if (colon == std::string::npos || !readRange(trimmed(part.substr(0, colon)), first, last) ||
            !parseNumber(trimmed(part.substr(colon + 1)), number) || !(number > 0.0) ||
            number > most)
            throw InputError(
                fmt::format("{} has \"{}\", should be transducers, 0 to {}, each with a number "
                            "above 0, at most {:g}: 17:0.5, 400-410:0.8",
                            what,
                            part,
                            kMostIndex,
                            most));
        append(first, last, number, what, numbers);
    }
    return sorted(std::move(numbers), what);
}

} // namespace midair::base
