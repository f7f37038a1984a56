#include "plugin/settings/Assignments.h"

#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <vector>

namespace osgMidair
{

namespace
{

bool isBlank(char c)
{
    return std::isspace(static_cast<unsigned char>(c)) != 0;
}

// Returns the text without surrounding blanks, then without quotes.
std::string unquoted(const std::string& text)
{
    const std::string bare = midair::base::trimmed(text);
    const bool quoted =
        bare.size() >= 2 && (bare[0] == '"' || bare[0] == '\'') && bare.back() == bare[0];
    return quoted ? bare.substr(1, bare.size() - 2) : bare;
}

bool isDigit(char c)
{
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// Text between two separators, and its first line.
struct Piece
{
    std::string text;
    int line = 1;
};

/// Splits at semicolons, commas and line ends outside quotes, and drops comments. A comma between
/// two digits is no separator: "500,0" is one invalid value, not 500.
std::vector<Piece> pieces(const std::string& text)
{
    std::vector<Piece> all(1);
    int line = 1;
    char quote = 0;
    bool comment = false;
    for (std::size_t i = 0; i < text.size(); ++i)
    {
        const char c = text[i];
        const bool isInNumber = c == ',' && i > 0 && i + 1 < text.size() && isDigit(text[i - 1]) &&
                                isDigit(text[i + 1]);
        if (c == '\n') comment = false;
        if (c == '\n') ++line;
        if (comment) continue;
        if (quote)
            quote = c == quote ? '\0' : quote;
        else if (c == '"' || c == '\'')
            quote = c;
        else if (c == '#')
        {
            comment = true;
            continue;
        }
        else if (c == ';' || (c == ',' && !isInNumber) || c == '\n' || c == '\r')
        {
            all.emplace_back().line = line;
            continue;
        }
        all.back().text += c;
    }
    return all;
}

/// Returns the start of the next "name=" after \a from, or the end of \a piece.
std::size_t nextName(const std::string& piece, std::size_t from)
{
    char quote = 0;
    for (std::size_t i = from; i < piece.size(); ++i)
    {
        const char c = piece[i];
        if (quote)
            quote = c == quote ? '\0' : quote;
        else if (c == '"' || c == '\'')
            quote = c;
        else if (c == '=' && i > from)
        {
            std::size_t start = i;
            while (start > from && !isBlank(piece[start - 1]))
                --start;
            if (start > from) return start;
        }
    }
    return piece.size();
}

} // namespace

std::vector<Assignment> assignmentsIn(const std::string& text)
{
    std::vector<Assignment> all;
    for (const auto& [piece, line] : pieces(text))
    {
        std::size_t start = 0;
        while (start < piece.size())
        {
            const std::size_t equals = piece.find('=', start);
            if (equals == std::string::npos)
            {
                const std::string word = unquoted(piece.substr(start));
                if (!word.empty()) all.push_back({"", word, line});
                break;
            }
            const std::size_t end = nextName(piece, equals + 1);
            // A name is one word; words before it have no value.
            std::istringstream words(piece.substr(start, equals - start));
            std::string name;
            std::string word;
            while (words >> word)
            {
                if (!name.empty()) all.push_back({"", name, line});
                name = word;
            }
            all.push_back({name, unquoted(piece.substr(equals + 1, end - equals - 1)), line});
            start = end;
        }
    }
    return all;
}

bool parseNumbers(const std::string& text, double* values, int count, const std::string& unit)
{
    std::istringstream in(text);
    std::vector<double> read;
    std::string last; // a unit after the numbers applies to all of them
    for (std::string word; in >> word;)
    {
        double value = 0.0;
        if (!last.empty()) return false;
        if (midair::base::parseQuantity(word, unit, value))
            read.push_back(value);
        else if (midair::base::isUnitFor(word, unit))
            last = word;
        else
            return false;
    }
    if (read.size() != static_cast<std::size_t>(count)) return false;
    double factor = 1.0;
    if (!last.empty() && !midair::base::parseQuantity("1 " + last, unit, factor)) return false;
    std::transform(
        read.begin(), read.end(), values, [factor](double value) { return value * factor; });
    return true;
}

bool parseMatrix(const std::string& text, osg::Matrixd& matrix)
{
    return parseNumbers(text, matrix.ptr(), 16);
}

} // namespace osgMidair
