#pragma once

#include "plugin/settings/Setting.h"

#include <osgMidair/HapticProperty>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace osgMidair
{

/// All settings of a struct \a T in the order in which they are told of and, version by version,
/// stored.
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

    /// Null: there is none of that name.
    const Setting<T>* find(const std::string& name) const
    {
        const auto found = std::find_if(
            _rows.begin(), _rows.end(), [&](const Setting<T>& row) { return row.name == name; });
        return found == _rows.end() ? nullptr : &*found;
    }

    /// False, with what would be right in \a error, for a name or a value that isn't understood.
    bool set(T& object, const std::string& name, const std::string& value, std::string& error) const
    {
        const Setting<T>* row = find(name);
        if (row && row->assign(object, value)) return true;
        if (row)
            error = name + " is \"" + value + "\", should be " + row->expected();
        else
            error = "unknown option \"" + name + "\"; known are " + names();
        return false;
    }

    /// Brings what is out of range back to its default; one sentence for each.
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

    bool areSame(const T& a, const T& b) const
    {
        return std::all_of(_members.begin(),
                           _members.end(),
                           [&](const Member<T>& member) { return isSame<T>(member, a, b); });
    }

    /// Name and summary of each.
    std::vector<std::pair<std::string, std::string>> describe() const
    {
        std::vector<std::pair<std::string, std::string>> all;
        for (const Setting<T>& row : _rows)
            all.emplace_back(row.name, row.summary());
        return all;
    }

private:
    std::string names() const
    {
        std::vector<std::string> known;
        for (const Setting<T>& row : _rows)
            known.push_back(row.name);
        return fmt::format("{}", fmt::join(known, ", "));
    }

    std::vector<Setting<T>> _rows;
    std::vector<Member<T>> _members; ///< close together: scenes are compared once a frame
};

/// What a HapticScene can be told.
const SettingTable<HapticSettings>& sceneSettings();

/// What a HapticSurface or a tag can be told.
const SettingTable<HapticProperty>& surfaceProperties();

} // namespace osgMidair
