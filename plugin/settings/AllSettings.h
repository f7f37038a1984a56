#pragma once

#include "haptics/base/settings/SettingTable.h"

#include <osgMidair/HapticProperty>
#include <osgMidair/HapticSettings>
#include <osgMidair/SettingDescription>

#include <string>
#include <vector>

/// Only scenes have matrices.
template<>
struct midair::base::Kinds<osgMidair::HapticSettings>
{
    using T = osgMidair::HapticSettings;
    using Member = std::
        variant<bool T::*, int T::*, double T::*, Choice<T>, std::string T::*, osg::Matrixd T::*>;
};

namespace osgMidair
{

using midair::base::Choice;
using midair::base::isSame;
using midair::base::Member;
using midair::base::Setting;
using midair::base::SettingTable;
using midair::base::Word;

/// The settings of a HapticScene.
const SettingTable<HapticSettings>& sceneSettings();

/// The properties of a HapticSurface or a tag.
const SettingTable<HapticProperty>& surfaceProperties();

/// Silences \a settings, for the reason \a why.
inline void silence(HapticSettings& settings, const std::string& why)
{
    settings.isSilenced = true;
    settings.whySilenced.push_back(why);
}

/// Returns the rows of \a table in types of installed headers.
template<typename T>
std::vector<SettingDescription> descriptionsOf(const midair::base::SettingTable<T>& table)
{
    std::vector<SettingDescription> all;
    for (const midair::base::Setting<T>& row : table.rows())
    {
        SettingDescription& one = all.emplace_back();
        one.name = row.name;
        one.help = row.help;
        one.values = row.values();
        one.unit = row.unit;
        // "identity" of a matrix is only for display: set() takes numbers.
        one.initial = row.defaultText();
        if (T scratch; !row.assign(scratch, one.initial)) one.initial.clear();
        one.summary = row.summary();
        for (const midair::base::Word& word : row.words)
            one.words.push_back(word.text);
        one.isFlag = std::holds_alternative<bool T::*>(row.member);
        one.isSafety = row.isSafety;
        one.low = row.range.low;
        one.high = row.range.high;
    }
    return all;
}

/// Returns what is wrong with \a value for \a name, as a phrase; empty: nothing.
template<typename T>
std::string problemOf(const midair::base::SettingTable<T>& table,
                      const std::string& name,
                      const std::string& value)
{
    T scratch;
    const midair::base::Setting<T>* row = table.find(name);
    if (row && row->assign(scratch, value)) return row->problem(scratch, value);
    if (row) return "is \"" + value + "\", should be " + row->expected();
    std::string error;
    table.set(scratch, name, value, error);
    return error;
}

/// Number of property changes by setters of all haptic nodes of the program. Any thread.
unsigned int propertyChanges();
void notePropertyChange();

} // namespace osgMidair
