#include "haptics/base/text/JsonLines.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Words.h"

#include <iterator>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace midair::base
{

namespace
{

/// Characters of a text, which counts the lines that were read.
class CountingIterator
{
public:
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    CountingIterator(const char* at, std::size_t& line) : _at(at), _line(&line) {}

    reference operator*() const { return *_at; }
    CountingIterator& operator++()
    {
        if (*_at++ == '\n') ++*_line;
        return *this;
    }
    CountingIterator operator++(int)
    {
        const CountingIterator before = *this;
        ++*this;
        return before;
    }
    bool operator==(const CountingIterator& other) const { return _at == other._at; }
    bool operator!=(const CountingIterator& other) const { return _at != other._at; }

private:
    const char* _at;
    std::size_t* _line;
};

/// Receives the events of a parser, and knows path and line of each value.
class JsonWalk
{
public:
    using Json = nlohmann::json;

    JsonWalk(const std::string& text, const std::string* wanted) : _text(text), _wanted(wanted) {}

    void run()
    {
        Json::sax_parse(CountingIterator(_text.data(), _line),
                        CountingIterator(_text.data() + _text.size(), _line),
                        this);
    }

    /// The first object or list that nests deeper ends the walk.
    std::size_t mostDepth = 0; ///< 0: any
    std::size_t found = 0;     ///< line of the wanted value; 0: not found
    std::size_t deep = 0;      ///< line of what nests too deep; 0: nothing
    std::size_t doubled = 0;   ///< line of a key that is there twice; 0: none
    std::string doubledKey;

    bool null() { return value(); }
    bool boolean(bool) { return value(); }
    bool number_integer(Json::number_integer_t) { return value(); }
    bool number_unsigned(Json::number_unsigned_t) { return value(); }
    bool number_float(Json::number_float_t, const Json::string_t&) { return value(); }
    bool string(Json::string_t&) { return value(); }
    bool binary(Json::binary_t&) { return value(); }
    bool start_object(std::size_t) { return begin(false); }
    bool end_object() { return end(); }
    bool start_array(std::size_t) { return begin(true); }
    bool end_array() { return end(); }
    bool parse_error(std::size_t, const std::string&, const Json::exception&) { return false; }

    bool key(Json::string_t& name)
    {
        Level& level = _levels.back();
        if (_wanted == nullptr && !level.keys.insert(name).second)
        {
            doubled = _line;
            doubledKey = name;
            return false;
        }
        level.keyLine = _line;
        if (_wanted != nullptr) _path = level.path.empty() ? name : level.path + "." + name;
        return true;
    }

private:
    struct Level
    {
        bool isList = false;
        std::size_t index = 0;
        std::size_t keyLine = 0;
        std::string path;
        std::set<std::string> keys;
    };

    bool value()
    {
        const bool isMember = !_levels.empty() && !_levels.back().isList;
        if (!_levels.empty() && _levels.back().isList)
        {
            const std::size_t index = _levels.back().index++;
            if (_wanted != nullptr) _path = fmt::format("{}[{}]", _levels.back().path, index);
        }
        if (_wanted == nullptr || _path != *_wanted) return true;
        found = isMember ? _levels.back().keyLine : _line;
        return false;
    }

    bool begin(bool isList)
    {
        if (!value()) return false;
        _levels.emplace_back();
        _levels.back().isList = isList;
        _levels.back().path = _path;
        if (mostDepth == 0 || _levels.size() <= mostDepth) return true;
        deep = _line;
        return false;
    }

    bool end()
    {
        _levels.pop_back();
        return true;
    }

    const std::string& _text;
    const std::string* _wanted;
    std::size_t _line = 1;
    std::string _path;
    std::vector<Level> _levels;
};

} // namespace

std::size_t jsonLine(const std::string& text, const std::string& path)
{
    if (path.empty()) return 1;
    JsonWalk walk(text, &path);
    walk.run();
    return walk.found == 0 ? 1 : walk.found;
}

void requirePlainJson(const std::string& text, const std::string& source, std::size_t mostDepth)
{
    JsonWalk walk(text, nullptr);
    walk.mostDepth = mostDepth;
    walk.run();
    if (walk.deep > 0)
        throw InputError(fmt::format(
            "{}, line {}: nests deeper than {} objects and lists", source, walk.deep, mostDepth));
    if (walk.doubled > 0)
        throw InputError(fmt::format("{}, line {}: the key '{}' is there twice in its object",
                                     source,
                                     walk.doubled,
                                     printable(walk.doubledKey, 60)));
}

} // namespace midair::base
