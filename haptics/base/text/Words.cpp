#include "haptics/base/text/Words.h"

namespace midair::base
{

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

} // namespace midair::base
