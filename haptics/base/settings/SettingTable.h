#pragma once

#include "haptics/base/settings/Setting.h"
#include "haptics/base/text/Range.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::base
{

/// Builds a Setting: the constructor takes the required facts, named functions set the others.
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
    Row& orZero() { return set(_setting.range.orZero, true); }
    Row& zeroIs(const char* word) { return set(_setting.zero, word); }
    Row& words(const std::vector<Word>& words) { return set(_setting.words, words); }
    Row& named(const std::vector<Word>& words) { return set(_setting.named, words); }
    Row& stored(const char* name) { return set(_setting.stored, name); }
    Row& variable(const char* name) { return set(_setting.variable, name); }
    Row& safety() { return set(_setting.isSafety, true); }
    Row& effect(unsigned effect) { return set(_setting.effect, effect); }
    Row& noIdentity() { return set(_setting.isIdentity, false); }
    Row& wish() { return set(_setting.isWish, true); }
    Row& use(unsigned use) { return set(_setting.use, use); }
    Row& parsedBy(bool (*parse)(T&, const std::string&)) { return set(_setting.parse, parse); }
    Row& judgedBy(std::string (*judge)(const T&)) { return set(_setting.judge, judge); }
    operator Setting<T>() const { return _setting; } // NOLINT(google-explicit-constructor)

private:
    template<typename V, typename To>
    Row& set(V& fact, const To& value)
    {
        fact = value;
        return *this;
    }

    Setting<T> _setting;
};

/// Range without an upper limit.
constexpr double kNoEnd = std::numeric_limits<double>::infinity();

/// Converts a member of \a B to a member of \a T, which inherits from \a B.
template<typename T, typename V, typename B>
V T::*asMemberOf(V B::*member)
{
    return member;
}

/// Converts \a rows of struct \a B to rows of \a T, which inherits from it. judge() is unchanged.
/// Throws std::logic_error for settings of enum type and for those with their own parser.
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

/// Concatenates \a groups of rows.
template<typename T>
std::vector<Setting<T>> joined(std::initializer_list<std::vector<Setting<T>>> groups)
{
    std::vector<Setting<T>> rows;
    for (const std::vector<Setting<T>>& group : groups)
        rows.insert(rows.end(), group.begin(), group.end());
    return rows;
}

/// All settings of struct \a T, in the order of lists and files.
template<typename T>
class SettingTable
{
public:
    explicit SettingTable(std::vector<Setting<T>> rows) : _rows(std::move(rows))
    {
        for (const Setting<T>& row : _rows)
            _members.push_back(row.member);
    }

    const std::vector<Setting<T>>& rows() const { return _rows; }

    /// Returns the row of that name, or null.
    const Setting<T>* find(const std::string& name) const
    {
        const auto found = std::find_if(
            _rows.begin(), _rows.end(), [&](const Setting<T>& row) { return row.name == name; });
        return found == _rows.end() ? nullptr : &*found;
    }

    /// Sets \a name in \a object from text. Returns false, with the valid names or values in \a
    /// error, if the name or value is invalid.
    bool set(T& object, const std::string& name, const std::string& value, std::string& error) const
    {
        const Setting<T>* row = find(name);
        if (row && row->assign(object, value)) return true;
        if (row)
        {
            std::vector<std::string> words;
            for (const Word& word : row->words)
                words.push_back(word.text);
            error = name + " is \"" + value + "\", should be " + row->expected() +
                    didYouMean(value, words);
        }
        else if (const std::string meant = didYouMean(name, names()); !meant.empty())
            error = "unknown option \"" + name + "\"" + meant;
        else
            error =
                fmt::format("unknown option \"{}\"; known are {}", name, fmt::join(names(), ", "));
        return false;
    }

    /// Returns true if \a name is a safety setting or a likely misspelling of one.
    bool concernsSafety(const std::string& name) const
    {
        const std::vector<std::string> meant =
            find(name) ? std::vector<std::string>{name} : nearestWords(name, names());
        return std::any_of(meant.begin(),
                           meant.end(),
                           [this](const std::string& one) { return find(one)->isSafety; });
    }
    /// Returns true if \a name neither equals nor resembles a setting.
    bool isUnlikeAny(const std::string& name) const
    {
        return !find(name) && nearestWords(name, names()).empty();
    }

    std::vector<std::string> names() const
    {
        std::vector<std::string> known;
        for (const Setting<T>& row : _rows)
            known.push_back(row.name);
        return known;
    }

    /// Resets values that are out of range to their defaults. Returns one sentence for each.
    std::vector<std::string> repair(T& object) const
    {
        std::vector<std::string> said;
        for (const Setting<T>& row : _rows)
        {
            std::string what;
            if (row.repair(object, what)) said.push_back(what);
        }
        return said;
    }

    /// Adds checks of all settings of \a object to \a check.
    RangeCheck& check(const T& object, RangeCheck& check) const
    {
        for (const Setting<T>& row : _rows)
        {
            if (row.holds(object)) continue;
            const std::string unit = row.unit.empty() ? "" : " " + row.unit;
            const double value = row.number(object);
            if (row.judge)
                check.require(false, row.judge(object).c_str());
            else if (row.range.orZero || !row.words.empty())
                check.check(false, row.name.c_str(), value, row.expected().c_str());
            else if (std::isinf(row.range.high))
                check.atLeast(row.name.c_str(), value, row.range.low, unit.c_str());
            else
                check.within(row.name.c_str(), value, row.range.low, row.range.high, unit.c_str());
        }
        return check;
    }

    /// Returns the effects (Effect, joined by |) of all settings that differ between \a a and \a b.
    unsigned effects(const T& a, const T& b) const
    {
        unsigned all = Effect::NOTHING;
        if (&a == &b) return all;
        for (const Setting<T>& row : _rows)
            if (row.effect != Effect::NOTHING && !isSame<T>(row.member, a, b)) all |= row.effect;
        return all;
    }

    bool areSame(const T& a, const T& b) const
    {
        return std::all_of(_members.begin(),
                           _members.end(),
                           [&](const Member<T>& member) { return isSame<T>(member, a, b); });
    }

    /// Returns name and summary of each setting.
    std::vector<std::pair<std::string, std::string>> describe() const
    {
        std::vector<std::pair<std::string, std::string>> all;
        for (const Setting<T>& row : _rows)
            all.emplace_back(row.name, row.summary());
        return all;
    }

private:
    std::vector<Setting<T>> _rows;
    std::vector<Member<T>> _members; ///< contiguous, because scenes are compared in every frame
};

} // namespace midair::base
