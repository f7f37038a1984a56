#include "engine-bridge/settings/SceneTable.h"

#include "engine-bridge/settings/SharedRows.h"
#include "haptics/base/settings/SettingTable.h"
#include "haptics/base/settings/SettingText.h"
#include "haptics/sequence/FieldSettings.h"

namespace midair::base
{

template struct Setting<bridge::SceneSettings>;
template bool isSame(const Member<bridge::SceneSettings>&,
                     const bridge::SceneSettings&,
                     const bridge::SceneSettings&);
template struct Setting<bridge::ObjectSettings>;
template bool isSame(const Member<bridge::ObjectSettings>&,
                     const bridge::ObjectSettings&,
                     const bridge::ObjectSettings&);

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

const base::SettingTable<ObjectSettings>& objectTable()
{
    using P = ObjectSettings;
    static const base::SettingTable<P> table(
        base::joined<P>({strengthRows<P>(), touchRows<P>(), sensationRows<P>()}));
    return table;
}

} // namespace midair::bridge
