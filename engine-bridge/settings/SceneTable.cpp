#include "engine-bridge/settings/SceneTable.h"

#include "engine-bridge/settings/SharedRows.h"
#include "haptics/base/settings/Row.h"
#include "haptics/base/settings/SettingText.h"
#include "haptics/sequence/FieldSettings.h"

namespace midair::base
{

template struct Setting<bridge::SceneSettings>;
template bool isSame(const Member<bridge::SceneSettings>&,
                     const bridge::SceneSettings&,
                     const bridge::SceneSettings&);

} // namespace midair::base

namespace midair::bridge
{

using S = SceneSettings;

const base::SettingTable<SceneSettings>& sceneTable()
{
    static const base::SettingTable<S> table(
        base::joined<S>({{base::Row<S>("enabled", &S::enabled, "false: the array is silent")
                              .safety()
                              .effect(base::Effect::NOTHING)},
                         base::inherited<S>(haptics::fieldSettings().rows()),
                         sceneRows<S>()}));
    return table;
}

unsigned effectsOf(const SceneSettings& a, const SceneSettings& b)
{
    unsigned effects = base::Effect::NOTHING;
    if (&a == &b) return effects;
    for (const base::Setting<S>& row : sceneTable().rows())
        if (row.effect != base::Effect::NOTHING && !base::isSame<S>(row.member, a, b))
            effects |= row.effect;
    return effects;
}

} // namespace midair::bridge
