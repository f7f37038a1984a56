#include "plugin/loader/PlyCheck.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <locale>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

constexpr std::size_t kMostPlyBytes = std::size_t(1) << 30;
constexpr std::size_t kMostPlyLine = 4094; ///< buffer size of OSG's reader, characters

struct PlyType
{
    const char* name;
    const char* otherName;
    std::size_t bytes;
    bool isSigned;
    bool isFloat;
};

const PlyType kPlyTypes[] = {{"char", "int8", 1, true, false},
                             {"uchar", "uint8", 1, false, false},
                             {"short", "int16", 2, true, false},
                             {"ushort", "uint16", 2, false, false},
                             {"int", "int32", 4, true, false},
                             {"uint", "uint32", 4, false, false},
                             {"float", "float32", 4, true, true},
                             {"double", "float64", 8, true, true}};

struct PlyProperty
{
    const PlyType* count; ///< of a list; null: a single number
    const PlyType* type;
    std::string name;
};

struct PlyElement
{
    std::string name;
    long long count;
    std::vector<PlyProperty> properties;
};

template<typename... Values>
[[noreturn]] void failPly(fmt::format_string<Values...> what, Values&&... values)
{
    throw midair::base::InputError(fmt::format(what, std::forward<Values>(values)...));
}

const PlyType* plyType(const std::string& name)
{
    for (const PlyType& type : kPlyTypes)
        if (name == type.name || name == type.otherName) return &type;
    failPly("the header has a property of the unknown type \"{}\"", name.substr(0, 40));
}

/// Checks a file against its header.
class PlyCheck
{
public:
    explicit PlyCheck(std::string_view text) : _text(text) {}

    void check()
    {
        readHeader();
        for (const PlyElement& element : _elements)
            for (long long i = 0; i < element.count; ++i)
                checkItem(element, i);
    }

private:
    std::string_view nextLine()
    {
        if (_at >= _text.size()) failPly("the file ends before what its header announces");
        const std::size_t end = std::min(_text.find('\n', _at), _text.size());
        const std::string_view line = _text.substr(_at, end - _at);
        _at = end + 1;
        ++_line;
        if (line.size() > kMostPlyLine)
            failPly("line {} has more than {} characters", _line, kMostPlyLine);
        return line;
    }

    void readHeader()
    {
        if (nextLine().substr(0, 3) != "ply") failPly("the file doesn't begin with \"ply\"");
        for (std::string word; word != "end_header";)
        {
            std::istringstream words{std::string(nextLine())};
            words.imbue(std::locale::classic());
            word.clear();
            words >> word;
            if (word == "format")
                takeFormat(words);
            else if (word == "element")
                takeElement(words);
            else if (word == "property")
                takeProperty(words);
        }
    }

    void takeFormat(std::istringstream& words)
    {
        std::string name;
        words >> name;
        _isText = name == "ascii";
        _isTurned = name == "binary_big_endian";
        if (!_isText && !_isTurned && name != "binary_little_endian")
            failPly("its format is \"{}\"", name.substr(0, 40));
    }

    void takeElement(std::istringstream& words)
    {
        PlyElement element{{}, -1, {}};
        words >> element.name >> element.count;
        if (!words || element.count < 0 || element.count > static_cast<long long>(_text.size()))
            failPly("line {}: the number of elements is not one that the file has room "
                    "for",
                    _line);
        if (element.name == "vertex") _vertices = element.count;
        _elements.push_back(std::move(element));
    }

    void takeProperty(std::istringstream& words)
    {
        PlyProperty property{nullptr, nullptr, {}};
        std::string word;
        words >> word;
        if (word == "list")
        {
            words >> word;
            property.count = plyType(word);
            if (property.count->isFloat)
                failPly("line {}: the length of a list is no whole number", _line);
            words >> word;
        }
        property.type = plyType(word);
        words >> property.name;
        if (_elements.empty()) failPly("line {}: a property of no element", _line);
        _elements.back().properties.push_back(std::move(property));
    }

    void checkItem(const PlyElement& element, long long item)
    {
        if (_isText) _words = nextLine();
        for (const PlyProperty& property : element.properties)
        {
            const bool isIndex =
                element.name != "vertex" && property.name.rfind("vertex_ind", 0) == 0;
            const long long count = property.count ? number(*property.count) : 1;
            if (count < 0) failPly("{} {} has a list of {} numbers", element.name, item, count);
            for (long long i = 0; i < count; ++i)
            {
                const long long value = number(*property.type);
                // -1 separates strips of triangles.
                const bool isDivider = value == -1 && element.name != "face";
                if (isIndex && !isDivider && (value < 0 || value >= _vertices))
                    failPly("{}{} {} refers to vertex {}; the file has {} vertices, "
                            "counted from 0",
                            _isText ? fmt::format("line {}: ", _line) : "",
                            element.name,
                            item,
                            value,
                            _vertices);
            }
        }
    }

    long long number(const PlyType& type) { return _isText ? nextWord() : nextBytes(type); }

    long long nextWord()
    {
        constexpr std::string_view kBlank = " \t\r";
        const std::size_t begin = std::min(_words.find_first_not_of(kBlank), _words.size());
        if (begin == _words.size())
            failPly("line {} has fewer numbers than the header announces", _line);
        const std::size_t end = std::min(_words.find_first_of(kBlank, begin), _words.size());
        long long value = 0;
        std::from_chars(_words.data() + begin, _words.data() + end, value);
        _words.remove_prefix(end);
        return value;
    }

    long long nextBytes(const PlyType& type)
    {
        if (_text.size() - std::min(_at, _text.size()) < type.bytes)
            failPly("the file ends before what its header announces");
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < type.bytes; ++i)
        {
            const auto byte =
                static_cast<std::uint8_t>(_text[_at + (_isTurned ? i : type.bytes - 1 - i)]);
            value = value << 8 | byte;
        }
        _at += type.bytes;
        if (type.isFloat) return 0;
        const std::uint64_t sign = std::uint64_t(1) << (8 * type.bytes - 1);
        return type.isSigned && (value & sign) != 0
                   ? static_cast<long long>(value) - static_cast<long long>(2 * sign)
                   : static_cast<long long>(value);
    }

    std::string_view _text;
    std::size_t _at = 0;
    std::string_view _words; ///< rest of an element's line
    int _line = 0;
    bool _isText = true;
    bool _isTurned = false;
    long long _vertices = 0;
    std::vector<PlyElement> _elements;
};

} // namespace

std::string plyProblem(const std::string& file)
{
    try
    {
        const std::string text = midair::base::readRegularFile(file, kMostPlyBytes);
        PlyCheck(text).check();
        return {};
    }
    catch (const midair::base::InputError& error)
    {
        return error.what();
    }
}

} // namespace osgMidair
