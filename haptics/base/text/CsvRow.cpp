#include "haptics/base/text/CsvRow.h"

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

} // namespace midair::base
