#include "engine-bridge/heads/HeadOpening.h"

#include "engine-bridge/extending/NamedFactories.h"
#include "haptics/base/InputError.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

using base::InputError;

NamedFactories<HeadSourceMaker>& ownHeads()
{
    // Never destroyed, as threads of the application may outlive static objects.
    static auto* const all = new NamedFactories<HeadSourceMaker>("head source");
    return *all;
}

/// What stands before the colon of \a text; where there is none, its first word.
std::string headKind(const std::string& text)
{
    return text.substr(0, text.find_first_of(": "));
}

std::string headError(const std::string& text, const std::string& why)
{
    return "head source \"" + base::printable(text) + "\": " + why;
}

/// Farther than this (m) from the world's origin no head is: it is a mistake in the unit.
constexpr double kFarthest_m = 1000.0;

std::shared_ptr<HeadSource> openFixed(const std::string& text)
{
    const std::vector<std::string> words = base::splitColumns(text);
    Eigen::Vector3d place;
    bool isPlace = words.size() == 4;
    for (std::size_t i = 0; isPlace && i < 3; ++i)
        isPlace = base::parseNumber(words[i + 1], place[static_cast<Eigen::Index>(i)]) &&
                  std::abs(place[static_cast<Eigen::Index>(i)]) <= kFarthest_m;
    if (!isPlace)
        throw InputError(headError(text,
                                   "should be fixed X Y Z: the midpoint between the eyes in the "
                                   "scene's world, metres, each within 1000"));
    return std::make_shared<FixedHeadSource>(FixedHeadSource::upright(place));
}

/// Opens a source of the application's. It is the application's code: what it throws is an error.
std::shared_ptr<HeadSource> openOwnHead(const HeadSourceMaker& make, const std::string& text)
{
    std::string why = "it could not be made";
    try
    {
        if (auto source = make(text.substr(text.find(':') + 1))) return source;
    }
    catch (...)
    {
        why = base::whatWasThrown();
    }
    throw InputError(headError(text, why));
}

} // namespace

bool registerHeads(const std::string& name, HeadSourceMaker make, std::string& error)
{
    return ownHeads().add(name,
                          std::move(make),
                          {"none", "fixed", "mouse", "openxr", "osc", "recorded", "tag"},
                          error);
}

bool isOwnHead(const std::string& text)
{
    return text.find(':') != std::string::npos && ownHeads().find(headKind(text));
}

std::vector<std::string> ownHeadNames()
{
    return ownHeads().names();
}

std::string unknownHead(const std::string& text, const std::vector<std::string>& more)
{
    const std::string kind = headKind(text);
    const bool isUri = text.find(':') != std::string::npos;
    if (kind == "tag" && isUri) return headError(text, "this build has no AprilTag");
    std::vector<std::string> known = {"fixed X Y Z", "recorded:FILE", "recorded:FILE?loop"};
    known.insert(known.end(), more.begin(), more.end());
    known.insert(known.end(), {"openxr:", "osc:"});
    std::vector<std::string> kinds = {"fixed", "recorded", "openxr", "osc"};
    for (const std::string& one : more)
        kinds.push_back(headKind(one));
    for (const std::string& name : ownHeadNames())
    {
        known.push_back(name + ":");
        kinds.push_back(name);
    }
    const bool isKnown = std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
    if (text.empty() || text == "none" || (isKnown && isUri == (kind != "fixed"))) return {};
    const std::string last = known.back();
    known.pop_back();
    return fmt::format("head source \"{}\" is not known{}; {} and {} are",
                       base::printable(text),
                       isKnown ? "" : base::didYouMean(kind, kinds),
                       fmt::join(known, ", "),
                       last);
}

std::shared_ptr<HeadSource> openHead(const std::string& text, const std::vector<std::string>& more)
{
    if (text.empty() || text == "none") return nullptr;
    const std::string unknown = unknownHead(text, more);
    if (!unknown.empty()) throw InputError(unknown);
    const std::string kind = headKind(text);
    if (kind == "fixed") return openFixed(text);
    if (const HeadSourceMaker make = ownHeads().find(kind)) return openOwnHead(make, text);
    throw InputError(headError(text, "it is opened by a viewer alone"));
}

} // namespace midair::bridge
