#include "engine-bridge/heads/HeadOpening.h"

#include "device/DeviceUri.h"
#include "engine-bridge/extending/NamedFactories.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "engine-bridge/hands/openxr/OpenXrHandSource.h"
#include "engine-bridge/hands/osc/OscReceiver.h"
#include "engine-bridge/heads/TagHead.h"
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

/// The head that an OpenXR runtime tracks now, or predicts, for any requested time. It shares the
/// process's only instance and its connection with the hands.
class OpenXrHead : public HeadSource
{
public:
    OpenXrHead(const OpenXrOptions& options, const Eigen::Isometry3d& placement) :
        _tracker(OpenXrTracker::open(options)),
        _asker(_tracker->newAsker(true)),
        _placement(placement)
    {
    }

    bool headAt(double time_s, Head& head) override
    {
        _tracker->latestHead(*_asker, head);
        head.time_s = time_s;
        head.pose = _placement * head.pose;
        return head.isTracked;
    }
    bool setHorizon(double ahead_s) override
    {
        OpenXrTracker::setHorizon(*_asker, ahead_s);
        return true;
    }
    std::string status() const override { return _tracker->status(); }
    std::vector<std::string> takeMessages() override { return _tracker->messages(_told); }

private:
    std::shared_ptr<OpenXrTracker> _tracker;
    std::shared_ptr<OpenXrAsker> _asker;
    Eigen::Isometry3d _placement;
    std::size_t _told = 0;
};

/// The head that comes by OSC now, for any requested time; the same port may carry hands.
class OscHead : public HeadSource
{
public:
    OscHead(const OscOptions& options, const Eigen::Isometry3d& placement) :
        _receiver((requireOsc(), OscReceiver::open(options))),
        _placement(placement)
    {
        Head none;
        _receiver->inbox().latestHead(0.0, none); // from now on the receiver reads datagrams for it
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
    // Never destroyed, because threads of the application may outlive static objects.
    static auto* const all = new NamedFactories<HeadSourceMaker>("head source");
    return *all;
}

/// Returns the part of \a text before the colon; without a colon its first word.
std::string headKind(const std::string& text)
{
    return text.substr(0, text.find_first_of(": "));
}

std::string headName(const std::string& text)
{
    return "head source \"" + base::printable(text) + "\"";
}

std::string headError(const std::string& text, const std::string& why)
{
    return headName(text) + ": " + why;
}

/// m; a head farther from the world's origin means a wrong unit.
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
        throw uri.error(
            "process=helper gives only hands; a program with its own session sets the head itself");
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

std::shared_ptr<HeadSource> openTagHead(const std::string& text)
{
    const std::string file = text.substr(text.find(':') + 1);
    try
    {
        if (file.empty())
            throw InputError("should be tag:FILE, where FILE describes camera and tags");
        return std::make_shared<TagHead>(loadTagRig(file));
    }
    catch (const InputError& wrong)
    {
        throw InputError(headError(text, wrong.what()));
    }
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
    std::vector<std::string> known = {"fixed X Y Z", "recorded:FILE", "recorded:FILE?loop"};
    known.insert(known.end(), more.begin(), more.end());
    known.insert(known.end(), {"tag:FILE", "openxr:", "osc:"});
    std::vector<std::string> kinds = {"fixed", "recorded", "tag", "openxr", "osc"};
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
    if (kind == "tag") return openTagHead(text);
    if (const auto recorded = RecordedUri::parse(text))
        return std::make_shared<RecordedHeadSource>(recorded->file, recorded->loops);
    if (const HeadSourceMaker make = ownHeads().find(kind))
        return makeNamed(make, text, headName(text));
    throw InputError(headError(text, "only a viewer can open it"));
}

} // namespace midair::bridge
