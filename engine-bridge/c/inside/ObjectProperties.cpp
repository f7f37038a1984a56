#include "engine-bridge/c/inside/ObjectProperties.h"

#include "engine-bridge/c/inside/Calls.h"
#include "engine-bridge/materials/MaterialLibrary.h"
#include "engine-bridge/settings/SharedRows.h"
#include "haptics/base/settings/Row.h"
#include "haptics/base/settings/SettingText.h"
#include "haptics/base/text/NearestWord.h"

namespace midair::base
{

template struct Setting<capi::ObjectProperties>;
template bool isSame(const Member<capi::ObjectProperties>&,
                     const capi::ObjectProperties&,
                     const capi::ObjectProperties&);

} // namespace midair::base

namespace midair::capi
{

namespace
{

using namespace base;

using P = ObjectProperties;

template<typename E>
int number(E value)
{
    return static_cast<int>(value);
}

/// Read once, when the first object names one.
const bridge::MaterialLibrary& materials()
{
    static const bridge::MaterialLibrary library = bridge::MaterialLibrary::ofUser();
    return library;
}

bridge::HapticMaterial materialOf(const P& property)
{
    bridge::HapticMaterial material;
    if (!property.material.empty())
    {
        const bridge::HapticMaterial* named = materials().find(property.material);
        if (!named)
            fail(MIDAIR_UNKNOWN,
                 "material \"" + property.material + "\" is unknown" +
                     didYouMean(property.material, materials().names()));
        material = *named;
    }
    bridge::replaceNumbers(material, property);
    std::string problem;
    if (!material.isValid(&problem)) fail(MIDAIR_INVALID, problem);
    return material;
}

} // namespace

const SettingTable<ObjectProperties>& objectTable()
{
    using bridge::Render;
    using bridge::Side;
    using haptics::Sampling;
    static const SettingTable<P> table(joined<P>(
        {bridge::strengthRows<P>(
             {number(Sampling::SURFACE), number(Sampling::EDGES), number(Sampling::VERTICES)},
             {number(Side::BOTH), number(Side::FRONT), number(Side::BACK)}),
         {Row<P>("touchEvents",
                 &P::touchEvents,
                 "report hands that begin and end to touch the object")},
         bridge::touchRows<P>({number(Render::INHERIT),
                               number(Render::OBJECT),
                               number(Render::CONTACT),
                               number(Render::AUTO)})}));
    return table;
}

bridge::HapticProperties forPipeline(const ObjectProperties& property)
{
    bridge::HapticProperties p;
    p.pressure = property.pressure;
    p.pressureInPa = property.pressureUnit == P::PASCAL;
    p.spacing_m = property.spacing;
    p.sampling = property.sampling;
    p.side = property.side;
    p.priority = property.priority;
    p.modulationFrequency_Hz = property.modulationFrequency;
    p.modulationDepth = property.modulationDepth;
    p.render = property.render;
    p.material = materialOf(property);
    return p;
}

} // namespace midair::capi
