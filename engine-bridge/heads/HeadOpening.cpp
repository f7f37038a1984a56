#include "engine-bridge/heads/HeadOpening.h"

#include "device/DeviceUri.h"
#include "engine-bridge/extending/NamedFactories.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/hands/openxr/OpenXrHandSource.h"
#include "engine-bridge/hands/osc/OscReceiver.h"
#include "haptics/base/InputError.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

using base::InputError;
using device::DeviceUri;

/// The head that an OpenXR runtime tracks now, or that it predicts, whatever time is asked for. It
/// shares the connection, and with it the process's one instance, with the hands.
class OpenXrHead : public HeadSource
{
public:
    OpenXrHead(const OpenXrOptions& options, const Eigen::Isometry3d& placement) :
        _tracker(OpenXrTracker::open(options)),
        _placement(placement)
    {
    }

    bool headAt(double time_s, Head& head) override
    {
        _tracker->latestHead(head);
        head.time_s = time_s;
        head.pose = _placement * head.pose;
        return head.isTracked;
    }
    bool setHorizon(double ahead_s) override
    {
        _tracker->setHeadHorizon(ahead_s);
        return true;
    }
    std::string status() const override { return _tracker->status(); }
    std::vector<std::string> takeMessages() override { return _tracker->messages(_told); }

private:
    std::shared_ptr<OpenXrTracker> _tracker;
    Eigen::Isometry3d _placement;
    std::size_t _told = 0;
};

/// The head that comes by OSC now, whatever time is asked for; one port may carry hands as well.
class OscHead : public HeadSource
{
public:
    OscHead(const OscOptions& options, const Eigen::Isometry3d& placement) :
        _receiver((requireOsc(), OscReceiver::open(options))),
        _placement(placement)
    {
        Head none;
        _receiver->inbox().latestHead(0.0, none); // from now on datagrams are read for it
    }

    bool headAt(double time_s, Head& head) override
    {
        _receiver->inbox().latestHead(base::steadySeconds(), head);
        head.time_s = time_s;
        head.pose = _placement * head.pose;
        return head.isTracked;
    }
    std::string status() const override { return _receiver->status(); }
    std::vector<std::string> takeMessages() override { return _receiver->inbox().messages(_told); }

private:
    std::shared_ptr<OscReceiver> _receiver;
    Eigen::Isometry3d _placement;
    std::size_t _told = 0;
};

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

std::shared_ptr<HeadSource> openOpenXrHead(const std::string& text)
{
    DeviceUri uri(text, "head source");
    const OpenXrOptions options = takeOpenXrOptions(uri);
    const Eigen::Isometry3d placement = takePlacement(uri, OpenXrHandSource::upright());
    if (uri.takeText("process", "own") != "own")
        throw uri.error("process=helper gives hands alone; a program that has a session of its own "
                        "knows the head, and sets it");
    uri.rejectUnknown();
    return std::make_shared<OpenXrHead>(options, placement);
}

std::shared_ptr<HeadSource> openOscHead(const std::string& text)
{
    DeviceUri uri(text, "head source");
    const OscOptions options = takeOscOptions(uri);
    const Eigen::Isometry3d placement = takePlacement(uri, Eigen::Isometry3d::Identity());
    uri.rejectUnknown();
    try
    {
        return std::make_shared<OscHead>(options, placement);
    }
    catch (const InputError& wrong)
    {
        throw uri.error(wrong.what());
    }
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

bool OpeningHead::headAt(double time_s, Head& head)
{
    head = {time_s, Eigen::Isometry3d::Identity(), false, 0.0};
    if (!_begin_s) _begin_s = time_s;
    const bool isMade =
        _opening.valid() && _opening.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    const std::string thrown = base::thrownBy(
        [&]
        {
            if (isMade) _source = _opening.get();
        });
    if (!thrown.empty()) _messages.push_back(thrown);
    if (_source) _source->headAt(time_s - *_begin_s, head);
    head.time_s = time_s;
    return head.isTracked;
}

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
    if (kind == "openxr") return openOpenXrHead(text);
    if (kind == "osc") return openOscHead(text);
    if (const auto recorded = RecordedUri::parse(text))
        return std::make_shared<RecordedHeadSource>(recorded->file, recorded->loops);
    if (const HeadSourceMaker make = ownHeads().find(kind)) return openOwnHead(make, text);
    throw InputError(headError(text, "it is opened by a viewer alone"));
}

} // namespace midair::bridge
