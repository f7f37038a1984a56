#include "haptics/base/text/Words.h"

#include "haptics/base/text/Quantity.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::base
{

namespace
{

/// Longer words are not names; the limit bounds the time for a file's nonsense.
constexpr std::size_t kLongest = 64;

} // namespace

std::vector<std::string> splitAt(const std::string& text, char separator)
{
    std::vector<std::string> parts(1);
    for (const char c : text)
        if (c == separator)
            parts.emplace_back();
        else
            parts.back() += c;
    return parts;
}

std::vector<std::string> splitColumns(const std::string& line)
{
    static const char* const separators = ",; \t\r";
    std::vector<std::string> fields;
    for (std::size_t begin = line.find_first_not_of(separators); begin != std::string::npos;)
    {
        const std::size_t end = line.find_first_of(separators, begin);
        fields.push_back(line.substr(begin, end - begin));
        begin = line.find_first_not_of(separators, end);
    }
    if (!fields.empty() && fields[0][0] == '#') fields.clear();
    return fields;
}

std::string printable(const std::string& text, std::size_t most)
{
    std::string shown = text.substr(0, most);
    for (char& c : shown)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
    // The same in UTF-8 for U+0080 .. U+009F, and for U+200B .. U+202F and U+2060 .. U+206F, which
    // hide text or reverse its direction.
    for (std::size_t i = 0; i + 1 < shown.size(); ++i)
    {
        const auto at = [&](std::size_t k)
        { return k < shown.size() ? static_cast<unsigned char>(shown[k]) : 0U; };
        if (at(i) == 0xC2 && at(i + 1) >= 0x80 && at(i + 1) <= 0x9F) shown[i] = shown[i + 1] = '?';
        const bool hides = at(i + 1) == 0x80 && at(i + 2) >= 0x8B && at(i + 2) <= 0xAF;
        const bool turns = at(i + 1) == 0x81 && at(i + 2) >= 0xA0 && at(i + 2) <= 0xAF;
        if (at(i) == 0xE2 && (hides || turns)) shown[i] = shown[i + 1] = shown[i + 2] = '?';
    }
    return shown.size() < text.size() ? shown + ".." : shown;
}

int editDistance(const std::string& a, const std::string& b)
{
    const std::string from = lowerCase(a.substr(0, kLongest));
    const std::string to = lowerCase(b.substr(0, kLongest));
    // Rows of the table of distances between beginnings: two ago, the last, this one.
    std::vector<int> before(to.size() + 1);
    std::vector<int> last(to.size() + 1);
    std::vector<int> now(to.size() + 1);
    for (std::size_t j = 0; j <= to.size(); ++j)
        last[j] = static_cast<int>(j);
    for (std::size_t i = 1; i <= from.size(); ++i)
    {
        now[0] = static_cast<int>(i);
        for (std::size_t j = 1; j <= to.size(); ++j)
        {
            const int replaced = last[j - 1] + (from[i - 1] == to[j - 1] ? 0 : 1);
            now[j] = std::min({replaced, last[j] + 1, now[j - 1] + 1});
            if (i > 1 && j > 1 && from[i - 1] == to[j - 2] && from[i - 2] == to[j - 1])
                now[j] = std::min(now[j], before[j - 2] + 1);
        }
        std::swap(before, last);
        std::swap(last, now);
    }
    return last[to.size()];
}

std::vector<std::string> nearestWords(const std::string& word,
                                      const std::vector<std::string>& known)
{
    std::vector<std::string> nearest;
    int least = static_cast<int>(kLongest);
    for (const std::string& name : known)
    {
        const int distance = editDistance(word, name);
        if (3 * distance > static_cast<int>(std::max(word.size(), name.size())) || distance > least)
            continue;
        if (distance < least) nearest.clear();
        least = distance;
        nearest.push_back(name);
    }
    return nearest;
}

std::string didYouMean(const std::string& word, const std::vector<std::string>& known)
{
    const std::vector<std::string> nearest = nearestWords(word, known);
    return nearest.empty() ? "" : fmt::format(" (did you mean {}?)", fmt::join(nearest, " or "));
}

} // namespace midair::base
