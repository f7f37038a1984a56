#include "engine-bridge/TextColumns.h"

#include <charconv>
#include <cmath>

namespace midair::bridge
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

bool parseNumber(const std::string& text, double& value)
{
    const char* begin = text.data();
    const char* const end = begin + text.size();
    if (begin != end && *begin == '+') ++begin; // which from_chars does not take
    const auto [rest, error] = std::from_chars(begin, end, value);
    return error == std::errc() && rest == end && std::isfinite(value);
}

} // namespace midair::bridge
