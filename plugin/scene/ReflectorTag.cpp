#include "plugin/scene/ReflectorTag.h"

#include "haptics/base/settings/SettingTable.h"
#include "haptics/base/settings/SettingText.h"
#include "plugin/settings/Assignments.h"

#include <set>

namespace midair::base
{

template struct Setting<osgMidair::ReflectorTag>;
template bool isSame(const Member<osgMidair::ReflectorTag>&,
                     const osgMidair::ReflectorTag&,
                     const osgMidair::ReflectorTag&);

} // namespace midair::base

namespace osgMidair
{

namespace
{

const midair::base::SettingTable<ReflectorTag>& reflectorProperties()
{
    using midair::base::Row;
    using T = ReflectorTag;
    static const midair::base::SettingTable<T> table(
        {Row<T>("enabled", &T::enabled, "false: it reflects nothing"),
         Row<T>("reflection", &T::reflection, "amplitude of the reflected wave over the incident")
             .range(0.0, 1.0),
         Row<T>("reflectionPhase", &T::reflectionPhase, "added to the phase of the reflected wave")
             .range(-1000.0, 1000.0, "rad"),
         Row<T>("accuracy", &T::accuracy, "rms error of its place along its normal")
             .range(1e-6, 1000.0, "mm")});
    return table;
}

} // namespace

ReflectorTag ReflectorTag::parse(const std::string& text, std::vector<std::string>& errors)
{
    ReflectorTag tag;
    std::set<std::string> seen;
    const std::size_t before = errors.size();
    for (const auto& [name, value, line] : assignmentsIn(text))
    {
        std::string error;
        if (!seen.insert(name).second)
            errors.push_back(givenTwice(name, false));
        else if (!reflectorProperties().set(tag, name.empty() ? "enabled" : name, value, error))
            errors.push_back(error);
    }
    for (std::string& what : reflectorProperties().repair(tag))
        errors.push_back(std::move(what));
    if (errors.size() == before) return tag;
    ReflectorTag strongest;
    strongest.enabled = tag.enabled;
    return strongest;
}

std::vector<std::string> ReflectorTag::names()
{
    return reflectorProperties().names();
}

} // namespace osgMidair
