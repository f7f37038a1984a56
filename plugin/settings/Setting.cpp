#include "plugin/settings/Setting.h"

#include "haptics/base/text/Number.h"
#include "haptics/base/text/Trimmed.h"
#include "plugin/settings/Assignments.h"

#include <osgMidair/HapticProperty>

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using midair::base::shortNumber;

std::string listOf(const std::vector<Word>& words)
{
    std::vector<std::string> texts;
    texts.reserve(words.size());
    for (const Word& word : words)
        texts.push_back(word.text);
    return fmt::format("{}", fmt::join(texts, ", "));
}

bool isSameNumber(double a, double b)
{
    return a == b || (std::isnan(a) && std::isnan(b));
}

bool isSameMatrix(const osg::Matrixd& a, const osg::Matrixd& b)
{
    return std::equal(a.ptr(), a.ptr() + 16, b.ptr(), isSameNumber);
}

bool readValue(const std::string& text, bool& value)
{
    const bool yes = text == "true" || text == "on" || text == "1" || text == "yes";
    const bool no = text == "false" || text == "off" || text == "0" || text == "no";
    if (yes || no) value = yes;
    return yes || no;
}

bool readValue(const std::string& text, int& value)
{
    return midair::base::parseWhole(midair::base::trimmed(text), value);
}

bool readValue(const std::string& text, double& value)
{
    return midair::base::parseNumber(midair::base::trimmed(text), value);
}

bool readValue(const std::string& text, std::string& value)
{
    value = text;
    return true;
}

bool readValue(const std::string& text, osg::Matrixd& value)
{
    return parseMatrix(text, value);
}

/// Kinds of settings that are described differently.
enum class Kind
{
    FLAG,
    NUMBER,
    TEXT,
    MATRIX,
    WORDS
};

template<typename M>
Kind kindOf(const M& member)
{
    constexpr Kind kKinds[] = {
        Kind::FLAG, Kind::NUMBER, Kind::NUMBER, Kind::WORDS, Kind::TEXT, Kind::MATRIX};
    static_assert(std::size(kKinds) >= std::variant_size_v<M>);
    return kKinds[member.index()];
}

} // namespace

bool Range::holds(double value) const
{
    return (value >= low && value <= high && std::isfinite(value)) || (orZero && value == 0.0);
}

std::string Range::text() const
{
    const std::string range = std::isinf(high) ? fmt::format("at least {:g}", low)
                                               : fmt::format("{:g} .. {:g}", low, high);
    return (orZero ? "0 or " : "") + range;
}

template<typename T>
std::string Setting<T>::storedName() const
{
    if (!stored.empty() || name.empty()) return stored;
    std::string capital = name;
    capital[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(capital[0])));
    return capital;
}

template<typename T>
bool Setting<T>::assign(T& object, const std::string& text) const
{
    if (parse && parse(object, text)) return true;
    const auto read = [&](auto kept)
    {
        if constexpr (std::is_same_v<decltype(kept), Choice<T>>)
        {
            const auto found = std::find_if(
                words.begin(), words.end(), [&](const Word& word) { return word.text == text; });
            if (found != words.end()) kept.set(object, found->value);
            return found != words.end();
        }
        else
            return readValue(text, object.*kept);
    };
    return std::visit(read, member);
}

template<typename T>
std::string Setting<T>::expected() const
{
    switch (kindOf(member))
    {
    case Kind::FLAG:
        return "true or false";
    case Kind::NUMBER:
        return "a number, " + range.text();
    case Kind::TEXT:
        return "a text";
    case Kind::MATRIX:
        return "16 numbers";
    case Kind::WORDS:
        break;
    }
    return "one of " + listOf(words);
}

template<typename T>
bool Setting<T>::repair(T& object, std::string& what) const
{
    const T defaults;
    const auto mend = [&](auto kept)
    {
        using M = decltype(kept);
        if constexpr (std::is_same_v<M, Choice<T>>)
        {
            // A binary file may hold any number.
            const int value = kept.get(object);
            for (const Word& word : words)
                if (word.value == value) return false;
            what = fmt::format(
                "{} is number {}, should be {}; the default is used", name, value, expected());
            kept.set(object, kept.get(defaults));
            return true;
        }
        else if constexpr (std::is_same_v<M, int T::*> || std::is_same_v<M, double T::*>)
        {
            if (range.holds(object.*kept)) return false;
            what = fmt::format("{} is {:g}, should be {}; {:g} is used",
                               name,
                               static_cast<double>(object.*kept),
                               range.text(),
                               static_cast<double>(defaults.*kept));
            object.*kept = defaults.*kept;
            return true;
        }
        else
            return false;
    };
    return std::visit(mend, member);
}

template<typename T>
std::string Setting<T>::values() const
{
    switch (kindOf(member))
    {
    case Kind::FLAG:
        return "true, false";
    case Kind::NUMBER:
        return range.text() + (unit.empty() ? "" : " " + unit);
    case Kind::TEXT:
        return "text";
    case Kind::MATRIX:
        return "16 numbers";
    case Kind::WORDS:
        break;
    }
    return listOf(words);
}

template<typename T>
std::string Setting<T>::defaultText() const
{
    const T defaults;
    const auto write = [&](auto kept) -> std::string
    {
        using M = decltype(kept);
        if constexpr (std::is_same_v<M, Choice<T>>)
        {
            for (const Word& word : words)
                if (word.value == kept.get(defaults)) return word.text;
            return {};
        }
        else if constexpr (std::is_same_v<M, bool T::*>)
            return defaults.*kept ? "true" : "false";
        else if constexpr (std::is_same_v<M, std::string T::*>)
            return defaults.*kept;
        else if constexpr (std::is_same_v<M, osg::Matrixd T::*>)
            return "identity"; // default of osg::Matrixd
        else
            return shortNumber(defaults.*kept);
    };
    return std::visit(write, member);
}

template<typename T>
std::string Setting<T>::summary() const
{
    const std::string initial = defaultText();
    const bool isText = kindOf(member) == Kind::TEXT;
    std::string facts = isText ? "" : values();
    if (!initial.empty()) facts += (isText ? "default " : "; default ") + initial;
    return help + (facts.empty() ? "" : " (" + facts + ")");
}

template<typename T>
bool isSame(const Member<T>& member, const T& a, const T& b)
{
    const auto compare = [&](auto kept)
    {
        using M = decltype(kept);
        if constexpr (std::is_same_v<M, Choice<T>>)
            return kept.get(a) == kept.get(b);
        else if constexpr (std::is_same_v<M, double T::*>)
            return isSameNumber(a.*kept, b.*kept);
        else if constexpr (std::is_same_v<M, osg::Matrixd T::*>)
            return isSameMatrix(a.*kept, b.*kept);
        else
            return a.*kept == b.*kept;
    };
    return std::visit(compare, member);
}

template struct Setting<HapticSettings>;
template struct Setting<HapticProperty>;
template bool isSame(const Member<HapticSettings>&, const HapticSettings&, const HapticSettings&);
template bool isSame(const Member<HapticProperty>&, const HapticProperty&, const HapticProperty&);

} // namespace osgMidair
