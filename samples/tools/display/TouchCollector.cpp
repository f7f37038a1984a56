#include "samples/tools/display/TouchCollector.h"

#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/shared/views/Signals.h"

#include <chrono>
#include <cstdio>
#include <thread>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr double kTouchStep_s = 0.01;
constexpr double kTouchEnd_s = 3.0; ///< a recording ends after so long without hands
constexpr std::size_t kIndexTip = 10;

} // namespace

TouchCollector::TouchCollector(const TouchSources& sources) : _sources(sources)
{
    std::string error;
    _hands = osgMidair::openHandSource(sources.hands, error);
    if (!_hands)
        throw base::InputError("--hands: " + (error.empty()
                                                  ? "\"" + sources.hands + "\" is not a hand source"
                                                  : error));
    if (sources.heads.empty()) return;
    _heads = osgMidair::openHeadSource(sources.heads, error);
    if (!_heads)
        throw base::InputError("--head: " + (error.empty()
                                                 ? "\"" + sources.heads + "\" is not a head source"
                                                 : error));
}

std::optional<bridge::StillTip::Sample> TouchCollector::sampleAt(double time_s)
{
    std::vector<osgMidair::Hand> hands;
    bridge::StillTip::Sample sample;
    for (const std::string& message : _hands->takeMessages())
        std::fprintf(stderr, "midair-display: %s\n", message.c_str());
    bool isSeen = _hands->getHands(time_s, hands) && !hands.empty() &&
                  hands.front().joints[kIndexTip].positionValid;
    if (isSeen)
    {
        const osg::Vec3d& tip = hands.front().joints[kIndexTip].position;
        sample.tip = {tip.x(), tip.y(), tip.z()};
    }
    if (_heads)
    {
        osgMidair::Head head;
        const bool isHead = _heads->getHead(time_s, head);
        isSeen = isSeen && isHead;
        const osg::Quat& q = head.orientation;
        sample.head.translation() =
            Eigen::Vector3d(head.position.x(), head.position.y(), head.position.z());
        if (isHead)
            sample.head.linear() =
                Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized().toRotationMatrix();
    }
    if (!isSeen) return {};
    return sample;
}

std::vector<bridge::StillTip::Sample> TouchCollector::collect(int count,
                                                              const std::function<void(int)>& ask,
                                                              const std::function<bool()>& frame)
{
    std::vector<bridge::StillTip::Sample> found;
    bridge::StillTip still(_sources.hold_s);
    const double begin_s = base::steadySeconds();
    double time_s = 0.0, seen_s = 0.0;
    if (count > 0) ask(0);
    for (long step = 0; static_cast<int>(found.size()) < count; ++step)
    {
        if (isStopAsked() || !frame()) throw base::InputError("stopped; nothing is written");
        time_s = _sources.isRehearsal ? static_cast<double>(step) * kTouchStep_s
                                      : base::steadySeconds() - begin_s;
        const auto sample = sampleAt(time_s);
        if (sample) seen_s = time_s;
        if (_sources.isRehearsal && time_s - seen_s > kTouchEnd_s)
            throw base::InputError(fmt::format(
                "the hands ended after {} of {} touches; nothing is written", found.size(), count));
        if (const auto one = still.add(time_s, sample))
        {
            found.push_back(*one);
            if (static_cast<int>(found.size()) < count) ask(static_cast<int>(found.size()));
        }
        if (!_sources.isRehearsal)
            std::this_thread::sleep_for(std::chrono::duration<double>(kTouchStep_s));
    }
    return found;
}

} // namespace midair::samples
