#include "plugin/serializers/ObjectNumbers.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

/// Splits a text into words; a quoted text is one word.
class Words
{
public:
    explicit Words(const std::string& text) : _text(text) {}

    /// False: end of the text.
    bool next(std::string& word)
    {
        const auto isBlank = [&] { return std::isspace(static_cast<unsigned char>(_text[_at])); };
        for (; _at < _text.size() && isBlank(); ++_at)
            if (_text[_at] == '\n') ++line;
        const std::size_t begin = _at;
        if (_at < _text.size() && _text[_at] == '"')
            skipQuoted();
        else
            while (_at < _text.size() && !isBlank())
                ++_at;
        word.assign(_text, begin, _at - begin);
        return !word.empty();
    }

    int line = 1; ///< of the last word's start

private:
    void skipQuoted()
    {
        for (++_at; _at < _text.size() && _text[_at] != '"'; ++_at)
        {
            if (_text[_at] == '\\') ++_at;
            if (_at < _text.size() && _text[_at] == '\n') ++line;
        }
        _at = std::min(_at + 1, _text.size());
    }

    const std::string& _text;
    std::size_t _at = 0;
};

} // namespace

std::string NumbersAround::give(const std::string& number, int line)
{
    if (_numbers.empty()) return {};
    if (std::find(_numbers.begin(), _numbers.end(), number) != _numbers.end())
        return fmt::format("line {}: UniqueID {} is also that of an object around it, which would "
                           "become its own child; use a unique number",
                           line,
                           number.substr(0, 20));
    _numbers.back() = number;
    return {};
}

std::string repeatedNumber(const std::string& text)
{
    NumbersAround around;
    Words words(text);
    for (std::string word; words.next(word);)
    {
        if (word == "{") around.open();
        if (word == "}") around.close();
        if (word != "UniqueID" || around.isEmpty() || !words.next(word)) continue;
        std::string problem = around.give(word, words.line);
        if (!problem.empty()) return problem;
    }
    return {};
}

} // namespace osgMidair
