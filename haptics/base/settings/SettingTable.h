#pragma once

#include "haptics/base/settings/Setting.h"
#include "haptics/base/text/NearestWord.h"
#include "haptics/base/text/Range.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::base
{

/// All settings of a struct \a T, in the order in which they are listed and stored.
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

    /// Sets the value of \a name in \a object from text. Returns false if the name or the value
    /// isn't understood, with the expected ones in \a error.
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

    /// Returns true if \a name is a setting that concerns safety, or may be one of these misspelt.
    bool concernsSafety(const std::string& name) const
    {
        const std::vector<std::string> meant =
            find(name) ? std::vector<std::string>{name} : nearestWords(name, names());
        return std::any_of(meant.begin(),
                           meant.end(),
                           [this](const std::string& one) { return find(one)->isSafety; });
    }
    /// Returns true if \a name is none of the table, nor like one.
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

    /// Adds a check for each setting of \a object to \a check.
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

    /// What follows from the settings that differ between \a a and \a b: values of Effect, joined
    /// by |.
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
    std::vector<Member<T>> _members; ///< contiguous, since scenes are compared in every frame
};

} // namespace midair::base
