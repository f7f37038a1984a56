#include "engine-bridge/hands/HandSource.h"

#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/extending/HandSourceRegistry.h"
#include "plugin/extending/RegisteredNames.h"
#include "plugin/hands/BridgedHands.h"
#include "plugin/hands/HandKinds.h"
#include "plugin/hands/MouseSource.h"
#include "plugin/hands/TrackedHands.h"
#include "plugin/settings/RecordedUri.h"

#include <osgMidair/HandSource>

#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using RecordedHands = BridgedHands<midair::bridge::RecordedHandSource>;

/// Returns what stands before the colon of \a uri; empty if there is none.
std::string schemeOf(const std::string& uri)
{
    const std::size_t colon = uri.find(':');
    return colon == std::string::npos ? "" : uri.substr(0, colon);
}

/// Opens a source that the application registered. It is the application's code: what it throws is
/// an error.
osg::ref_ptr<HandSource>
openOwn(const HandSourceFactory& make, const std::string& uri, std::string& error)
{
    osg::ref_ptr<HandSource> source;
    std::string why;
    const std::string thrown =
        midair::base::thrownBy([&] { source = make(uri.substr(uri.find(':') + 1), why); });
    if (thrown.empty() && source) return source;
    if (!thrown.empty()) why = "what makes it has thrown " + thrown;
    error = "hand source \"" + uri + "\": " + (why.empty() ? "it could not be made" : why);
    return nullptr;
}

} // namespace

void InjectedHands::setHands(const std::vector<Hand>& hands)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    _hands = hands;
    _set_s = midair::base::steadySeconds();
    ++_set;
}

bool InjectedHands::getHands(double /*time*/, std::vector<Hand>& hands)
{
    const std::lock_guard<std::mutex> lock(_mutex);
    hands = _hands;
    for (Hand& hand : hands)
        hand.age += midair::base::steadySeconds() - _set_s;
    return !hands.empty();
}

std::string InjectedHands::getStatus() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return fmt::format("hands set by the application, {} times so far", _set);
}

std::string unknownHands(const std::string& uri)
{
    const std::string scheme = schemeOf(uri);
    if (uri.empty() || uri == "none" || uri == "mouse" || uri == "mouse:" || scheme == "openxr" ||
        scheme == "osc" || RecordedUri::parse(uri) || HandSourceRegistry::find(scheme))
        return {};
    const std::string names = registeredNames("hands");
    return "hand source \"" + uri + "\" is not known; recorded:FILE, recorded:FILE?loop" +
           (names.empty() ? ", mouse:, openxr: and osc: are"
                          : ", mouse:, openxr:, osc:, " + names + " are");
}

osg::ref_ptr<HandSource> openHandSource(const std::string& uri, std::string& error)
{
    if (uri.empty() || uri == "none") return nullptr;
    try
    {
        if (const auto recorded = RecordedUri::parse(uri))
            return new RecordedHands(recorded->file, recorded->loops);
        if (schemeOf(uri) == "openxr") return openOpenXr(uri);
        if (schemeOf(uri) == "osc") return openOsc(uri);
        if (uri == "mouse" || uri == "mouse:") return new MouseSource;
        if (const HandSourceFactory own = HandSourceRegistry::find(schemeOf(uri)))
            return openOwn(own, uri, error);
        error = unknownHands(uri);
    }
    catch (const std::runtime_error& wrong) // InputError from recordings, DeviceError from URIs
    {
        error = wrong.what();
    }
    return nullptr;
}

Hand openHand(int id, const osg::Vec3d& tip, const osg::Quat& orientation)
{
    return fromBridge(midair::bridge::openHandWithIndexTipAt(
        id,
        Eigen::Vector3d(tip.x(), tip.y(), tip.z()),
        Eigen::Quaterniond(orientation.w(), orientation.x(), orientation.y(), orientation.z())));
}

} // namespace osgMidair
