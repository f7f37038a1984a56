#pragma once

#include "haptics/base/AssignPart.h"
#include "haptics/base/settings/Setting.h"

#include <initializer_list>
#include <stdexcept>

namespace midair::base
{

/// Builds a Setting: the constructor takes what every row has, the named functions set the rest.
template<typename T>
class Row
{
public:
    Row(const char* name, Member<T> member, const std::string& help)
    {
        _setting.name = name;
        _setting.member = member;
        _setting.help = help;
    }
    Row& range(double low, double high, const char* unit = "")
    {
        _setting.range.low = low;
        _setting.range.high = high;
        _setting.unit = unit;
        return *this;
    }
    Row& orZero()
    {
        _setting.range.orZero = true;
        return *this;
    }
    Row& zeroIs(const char* word)
    {
        _setting.zero = word;
        return *this;
    }
    Row& words(const std::vector<Word>& words)
    {
        _setting.words = words;
        return *this;
    }
    Row& stored(const char* name)
    {
        _setting.stored = name;
        return *this;
    }
    Row& variable(const char* name)
    {
        _setting.variable = name;
        return *this;
    }
    Row& safety()
    {
        _setting.isSafety = true;
        return *this;
    }
    Row& effect(unsigned effect)
    {
        _setting.effect = effect;
        return *this;
    }
    Row& noIdentity()
    {
        _setting.isIdentity = false;
        return *this;
    }
    Row& wish()
    {
        _setting.isWish = true;
        return *this;
    }
    Row& use(unsigned use)
    {
        _setting.use = use;
        return *this;
    }
    Row& parsedBy(bool (*parse)(T&, const std::string&))
    {
        _setting.parse = parse;
        return *this;
    }
    Row& judgedBy(std::string (*judge)(const T&))
    {
        _setting.judge = judge;
        return *this;
    }
    operator Setting<T>() const { return _setting; } // NOLINT(google-explicit-constructor)

private:
    Setting<T> _setting;
};

/// Range without an upper end.
constexpr double kNoEnd = std::numeric_limits<double>::infinity();

/// The same member, as one of the struct \a T, which inherits from \a B.
template<typename T, typename V, typename B>
V T::*asMemberOf(V B::*member)
{
    return member;
}

/// Returns \a rows of the struct \a B as rows of \a T, which inherits from it. Throws
/// std::logic_error for settings of an enum type, and for those with a parser of their own.
/// Which texts hold stays as it is.
template<typename T, typename B>
std::vector<Setting<T>> inherited(const std::vector<Setting<B>>& rows)
{
    std::vector<Setting<T>> all;
    for (const Setting<B>& row : rows)
    {
        if (row.parse) throw std::logic_error(row.name + " has its own parser");
        Setting<T>& own = all.emplace_back();
        const auto convert = [&](auto member)
        {
            if constexpr (std::is_same_v<decltype(member), Choice<B>>)
                throw std::logic_error(row.name + " is an enum");
            else
                own.member = asMemberOf<T>(member);
        };
        std::visit(convert, row.member);
        assignPart<SettingFacts>(own, row);
        if (row.judge) own.judge = [judge = row.judge](const T& object) { return judge(object); };
    }
    return all;
}

/// Appends each of \a groups of rows to one list.
template<typename T>
std::vector<Setting<T>> joined(std::initializer_list<std::vector<Setting<T>>> groups)
{
    std::vector<Setting<T>> rows;
    for (const std::vector<Setting<T>>& group : groups)
        rows.insert(rows.end(), group.begin(), group.end());
    return rows;
}

} // namespace midair::base
