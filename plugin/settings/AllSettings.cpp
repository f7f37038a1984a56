// The tables of settings. To add one that needs the scene graph, add its member to HapticSettings
// or HapticProperty and its row here; others: CONTRIBUTING.md.
// Rows are stored in this order; .osgb is positional, so a stored row must keep its place.
#include "plugin/settings/AllSettings.h"

#include "engine-bridge/settings/SharedRows.h"
#include "haptics/base/settings/SettingTable.h"
#include "haptics/base/settings/SettingText.h"
#include "haptics/sequence/FieldSettings.h"
#include "plugin/settings/Assignments.h"

namespace midair::base
{

template<>
struct ValueText<osg::Matrixd>
{
    static constexpr const char* kExpected = "16 numbers";
    static constexpr const char* kValues = "16 numbers";
    static bool read(const std::string& text, osg::Matrixd& value)
    {
        return osgMidair::parseMatrix(text, value);
    }
    static bool same(const osg::Matrixd& a, const osg::Matrixd& b)
    {
        return std::equal(a.ptr(), a.ptr() + 16, b.ptr(), ValueText<double>::same);
    }
    static std::string write(const osg::Matrixd&) { return "identity"; } // the default
};

template struct OSGMIDAIR_EXPORT Setting<osgMidair::HapticSettings>;
template struct OSGMIDAIR_EXPORT Setting<osgMidair::HapticProperty>;
template OSGMIDAIR_EXPORT bool isSame(const Member<osgMidair::HapticSettings>&,
                                      const osgMidair::HapticSettings&,
                                      const osgMidair::HapticSettings&);
template OSGMIDAIR_EXPORT bool isSame(const Member<osgMidair::HapticProperty>&,
                                      const osgMidair::HapticProperty&,
                                      const osgMidair::HapticProperty&);

} // namespace midair::base

namespace osgMidair
{

namespace
{

using namespace midair::base;
namespace bridge = midair::bridge;

using S = HapticSettings;
using P = HapticProperty;

std::vector<Setting<S>> place()
{
    return {
        Row<S>("enabled", &S::enabled, "false: the array is silent")
            .variable("ENABLED")
            .safety()
            .effect(Effect::NOTHING),
        Row<S>(
            "array",
            &S::array,
            "array to play on: octagon, board, the name of another shipped array, or a JSON file")
            .variable("ARRAY")
            .safety()
            .effect(Effect::REOPEN)
            .noIdentity()
            .wish(),
        Row<S>("device",
               &S::device,
               "device to play on: a URI (sim:, record:FILE, null:, ..) or a name from the "
               "user's grants")
            .variable("DEVICE")
            .safety()
            .effect(Effect::REOPEN)
            .noIdentity()
            .wish(),
        Row<S>("calibration",
               &S::calibration,
               "rigid transform from the world in m to the array; row by row, translation last")
            .safety()
            .effect(Effect::MOVE),
        Row<S>("metresPerUnit", &S::metresPerUnit, "length of a scene unit")
            .range(1e-9, 1e9, "m")
            .safety()
            .effect(Effect::MOVE)};
}

std::vector<Setting<S>> hands()
{
    return {Row<S>("hands",
                   &S::hands,
                   "source of tracked hands: none, recorded:FILE, recorded:FILE?loop, mouse:, "
                   "openxr:, osc:, or a name from the user's grants")
                .variable("HANDS")
                .effect(Effect::NOTHING)
                .noIdentity()
                .wish(),
            Row<S>("heads",
                   &S::heads,
                   "source of the viewer's head: none, fixed X Y Z, recorded:FILE, "
                   "recorded:FILE?loop, mouse:, openxr:, osc:, or a name from the user's grants")
                .variable("HEADS")
                .effect(Effect::NOTHING)
                .noIdentity()
                .wish()};
}

std::vector<Setting<S>> head()
{
    return {Row<S>("earCamera",
                   &S::earCamera,
                   "adds listening places at the ears of the viewer's head, or of the camera if "
                   "there is no head source")
                .safety()
                .effect(Effect::NOTHING)
                .noIdentity()};
}

std::vector<Setting<P>> paint()
{
    return {Row<P>("intensity",
                   choiceOf<P, &P::intensity>(),
                   "painted haptics: source of the factor on the pressure")
                .words({{"uniform", "UNIFORM", P::UNIFORM},
                        {"vertex-color", "VERTEX_COLOR", P::VERTEX_COLOR},
                        {"texture", "TEXTURE", P::TEXTURE}}),
            Row<P>("intensityChannel",
                   choiceOf<P, &P::intensityChannel>(),
                   "channel of the paint that gives the factor; brightness: mean of red, green and "
                   "blue, times alpha")
                .words({{"brightness", "BRIGHTNESS", P::BRIGHTNESS},
                        {"red", "RED", P::RED},
                        {"green", "GREEN", P::GREEN},
                        {"blue", "BLUE", P::BLUE},
                        {"alpha", "ALPHA", P::ALPHA}}),
            Row<P>("intensityLow",
                   &P::intensityLow,
                   "factor where the channel is 0; points with factor 0 are not felt")
                .range(0.0, 1.0),
            Row<P>("intensityHigh",
                   &P::intensityHigh,
                   "factor where the channel is full; below intensityLow: inverted")
                .range(0.0, 1.0)};
}

} // namespace

const SettingTable<HapticSettings>& sceneSettings()
{
    static const SettingTable<S> table(
        joined<S>({place(),
                   inherited<S>(midair::haptics::fieldSettings().rows()),
                   hands(),
                   bridge::sceneRows<S>(),
                   head()}));
    return table;
}

const SettingTable<HapticProperty>& surfaceProperties()
{
    static const SettingTable<P> table(joined<P>(
        {bridge::strengthRows<P>(), paint(), bridge::touchRows<P>(), bridge::sensationRows<P>()}));
    return table;
}

} // namespace osgMidair
