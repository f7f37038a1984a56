#pragma once

// Implementation of Setting. A file that instantiates it for a struct includes this file,
// specialises ValueText for the struct's own types, and ends with
//     template struct Setting<MyStruct>;
//     template bool isSame(const Member<MyStruct>&, const MyStruct&, const MyStruct&);
#include "haptics/base/settings/Setting.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::base
{

/// Reads, compares, writes and describes values of type \a V. read() returns false on a syntax
/// error.
template<typename V>
struct ValueText;

template<>
struct ValueText<bool>
{
    static constexpr const char* kExpected = "true or false";
    static constexpr const char* kValues = "true, false";
    static bool read(const std::string& text, bool& value) { return parseYesNo(text, value); }
    static bool same(bool a, bool b) { return a == b; }
    static std::string write(bool value) { return value ? "true" : "false"; }
};

template<>
struct ValueText<int>
{
    static bool read(const std::string& text, int& value)
    {
        return parseWhole(trimmed(text), value);
    }
    static bool same(int a, int b) { return a == b; }
    static std::string write(int value) { return shortNumber(value); }
};

template<>
struct ValueText<double>
{
    static bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }
    static std::string write(double value) { return shortNumber(value); }
};

template<>
struct ValueText<std::string>
{
    static constexpr const char* kExpected = "a text";
    static constexpr const char* kValues = "text";
    static bool read(const std::string& text, std::string& value)
    {
        value = text;
        return true;
    }
    static bool same(const std::string& a, const std::string& b) { return a == b; }
    static std::string write(const std::string& value) { return value; }
};

/// Value type of a member of struct \a T.
template<typename T, typename M>
using ValueOf = std::decay_t<decltype(std::declval<T&>().*std::declval<M&>())>;

template<typename M, typename T>
constexpr bool kIsNumber = std::is_same_v<M, int T::*> || std::is_same_v<M, double T::*>;

/// "surface, edges, vertices".
std::string listOf(const std::vector<Word>& words);
/// Returns the one of \a words that \a text means, as users or files write it; null: none.
const Word* wordFor(const std::vector<Word>& words, const std::string& text);

template<typename T>
bool Setting<T>::assign(T& object, const std::string& text) const
{
    if (parse && parse(object, text)) return true;
    const auto read = [&](auto kept)
    {
        using M = decltype(kept);
        if constexpr (std::is_same_v<M, Choice<T>>)
        {
            const Word* const word = wordFor(words, text);
            if (word) kept.set(object, word->value);
            return word != nullptr;
        }
        else if constexpr (std::is_same_v<M, double T::*>)
        {
            const bool isZero = !zero.empty() && lowerCase(trimmed(text)) == zero;
            return isZero ? (object.*kept = 0.0, true) : parseQuantity(text, unit, object.*kept);
        }
        else if constexpr (std::is_same_v<M, int T::*>)
        {
            const Word* const word = wordFor(named, text);
            return word ? (object.*kept = word->value, true)
                        : ValueText<int>::read(text, object.*kept);
        }
        else
            return ValueText<ValueOf<T, M>>::read(text, object.*kept);
    };
    return std::visit(read, member);
}

template<typename T>
std::string Setting<T>::expected() const
{
    const auto describe = [&](auto kept) -> std::string
    {
        using M = decltype(kept);
        if constexpr (std::is_same_v<M, Choice<T>>)
            return "one of " + listOf(words);
        else if constexpr (kIsNumber<M, T>)
            return "a number, " + numbers();
        else
            return ValueText<ValueOf<T, M>>::kExpected;
    };
    return std::visit(describe, member);
}

template<typename T>
bool Setting<T>::holds(const T& object) const
{
    const auto look = [&](auto kept)
    {
        using M = decltype(kept);
        if constexpr (std::is_same_v<M, Choice<T>>)
            return std::any_of(words.begin(),
                               words.end(),
                               [value = kept.get(object)](const Word& word)
                               { return word.value == value; });
        else if constexpr (kIsNumber<M, T>)
            return range.holds(object.*kept);
        else
            return !judge || judge(object).empty();
    };
    return std::visit(look, member);
}

template<typename T>
std::string Setting<T>::problem(const T& object, const std::string& text) const
{
    if (holds(object)) return {};
    return judge ? judge(object).substr(name.size() + 1)
                 : "is \"" + text + "\", should be " + expected();
}

template<typename T>
double Setting<T>::number(const T& object) const
{
    const auto read = [&](auto kept) -> double
    {
        using M = decltype(kept);
        if constexpr (std::is_same_v<M, Choice<T>>)
            return kept.get(object);
        else if constexpr (kIsNumber<M, T>)
            return static_cast<double>(object.*kept);
        else
            return 0.0;
    };
    return std::visit(read, member);
}

template<typename T>
bool Setting<T>::repair(T& object, std::string& what) const
{
    if (holds(object)) return false;
    const T defaults;
    const auto mend = [&](auto kept)
    {
        using M = decltype(kept);
        if constexpr (std::is_same_v<M, Choice<T>>)
        {
            // A binary file may contain any number.
            what = fmt::format("{} is number {}, should be {}; the default is used",
                               name,
                               kept.get(object),
                               expected());
            kept.set(object, kept.get(defaults));
        }
        else if constexpr (kIsNumber<M, T>)
        {
            what = fmt::format("{} is {}, should be {}; {:g} is used",
                               name,
                               exactNumber(number(object)),
                               range.text(),
                               number(defaults));
            object.*kept = defaults.*kept;
        }
        else
        {
            what = judge(object) + "; the default is used";
            object.*kept = defaults.*kept;
        }
    };
    std::visit(mend, member);
    return true;
}

template<typename T>
std::string Setting<T>::values() const
{
    const auto describe = [&](auto kept) -> std::string
    {
        using M = decltype(kept);
        if constexpr (std::is_same_v<M, Choice<T>>)
            return listOf(words);
        else if constexpr (kIsNumber<M, T>)
            return numbers();
        else
            return ValueText<ValueOf<T, M>>::kValues;
    };
    return std::visit(describe, member);
}

template<typename T>
std::string Setting<T>::defaultText(const T& defaults) const
{
    const auto write = [&](auto kept) -> std::string
    {
        using M = decltype(kept);
        if constexpr (std::is_same_v<M, Choice<T>>)
        {
            for (const Word& word : words)
                if (word.value == kept.get(defaults)) return word.text;
            return {};
        }
        else
            return ValueText<ValueOf<T, M>>::write(defaults.*kept);
    };
    return std::visit(write, member);
}

template<typename T>
std::string Setting<T>::summary(const T& defaults) const
{
    const std::string initial = defaultText(defaults);
    const bool isText = std::holds_alternative<std::string T::*>(member);
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
        else
            return ValueText<ValueOf<T, M>>::same(a.*kept, b.*kept);
    };
    return std::visit(compare, member);
}

} // namespace midair::base
