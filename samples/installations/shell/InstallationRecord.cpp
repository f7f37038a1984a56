#include "samples/installations/shell/InstallationRecord.h"

#include "haptics/base/threads/SteadyClock.h"
#include "haptics/probe/Feeling.h"

#include <algorithm>
#include <cstdio>
#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

/// Lines that differ only in numbers count as equal.
std::string withoutNumbers(std::string text)
{
    const auto isOfNumber = [](char c) { return (c >= '0' && c <= '9') || c == '.' || c == '\n'; };
    text.erase(std::remove_if(text.begin(), text.end(), isOfNumber), text.end());
    return text;
}

constexpr double kSettled_s = 120.0; ///< until caches and pools have grown
constexpr double kLook_s = 1.0;

} // namespace

void SaidLines::notify(osg::NotifySeverity severity, const char* message)
{
    std::fputs(message, severity <= osg::WARN ? stderr : stdout);
    const base::Lock lock(_mutex);
    ++_count;
    const double now_s = base::steadySeconds();
    if (now_s - _begin_s >= 1.0)
    {
        _begin_s = now_s;
        _second.clear();
    }
    const std::string what = withoutNumbers(message);
    if (what.empty()) return; // a line end
    const std::uint64_t times = ++_second[what];
    if (times > 1) _tooOften[what] = std::max(_tooOften[what], times);
}

std::uint64_t SaidLines::count() const
{
    const base::Lock lock(_mutex);
    return _count;
}

std::map<std::string, std::uint64_t> SaidLines::tooOften() const
{
    const base::Lock lock(_mutex);
    return _tooOften;
}

InstallationRecord::InstallationRecord() : _said(new SaidLines)
{
    osg::setNotifyHandler(_said);
}

double residentMemory_MB()
{
    std::ifstream file("/proc/self/statm");
    long size = 0;
    long resident = 0;
    if (!(file >> size >> resident)) return 0.0;
    return 1e-6 * static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

void InstallationRecord::Silence::add(bool isAsked, bool isPlaying, double now_s)
{
    if (!isAsked)
    {
        since_s = -1.0;
        return;
    }
    if (since_s < 0.0) since_s = now_s;
    ++frames;
    if (isPlaying && now_s - since_s > kGrace_s) ++played;
}

void InstallationRecord::addFrame(const Frame& frame, const osgMidair::HapticStatistics& now)
{
    if (_begin_s < 0.0) _begin_s = frame.now_s;
    _end_s = frame.now_s;
    _fingertip_N = now.fingertipForce_N;
    ++_frames;
    if (now.hands > 0) ++_withHands;
    const bool isPlaying = now.state == osgMidair::ArrayState::PLAYING;
    if (isPlaying) ++_playing;
    _muted.add(frame.isMuted, isPlaying, frame.now_s);
    _alone.add(frame.mustRest, isPlaying, frame.now_s);
    if (frame.now_s - _looked_s < kLook_s) return;
    look(frame.now_s);
    _looked_s = frame.now_s;
}

void InstallationRecord::look(double now_s)
{
    _memory_MB.last = residentMemory_MB();
    _memory_MB.most = std::max(_memory_MB.most, _memory_MB.last);
    if (now_s - _begin_s < kSettled_s || _memory_MB.first == 0.0)
        _memory_MB.first = _memory_MB.last;
}

void InstallationRecord::addField(const osgMidair::HapticField* field)
{
    if (!field || field == _newest || !field->isPlaying()) return;
    _newest = field;
    for (const osgMidair::HapticField::ControlPoint& point : field->getPoints())
        _most.pressure_Pa = std::max(_most.pressure_Pa, point.achieved_Pa);
}

void InstallationRecord::addTouch(const osgMidair::Touch& touch)
{
    ++_touches;
    addStroke(touch);
}

void InstallationRecord::addStroke(const osgMidair::Touch& touch)
{
    _most.force_N = std::max(_most.force_N, touch.force);
}

osgMidair::Touch InstallationRecord::felt(osgMidair::Touch touch) const
{
    touch.force = std::min(touch.force, _fingertip_N);
    return touch;
}

nlohmann::ordered_json InstallationRecord::figures(const osgMidair::HapticStatistics& end) const
{
    nlohmann::ordered_json json;
    const double seconds = std::max(0.0, _end_s - _begin_s);
    json["frames"] = _frames;
    json["seconds"] = seconds;
    json["framesWithHands"] = _withHands;
    json["framesPlaying"] = _playing;
    json["touches"] = _touches;
    json["largestForce_mN"] = 1e3 * _most.force_N;
    json["largestPressure_Pa"] = _most.pressure_Pa;
    json["transducers"] = end.transducers;
    json["device"] = end.device;
    json["state"] = midair::bridge::stateName(end.state);
    json["solves"] = end.solves;
    json["contactFields"] = end.contactFields;
    for (const midair::bridge::ArrayFieldsRow& row : midair::bridge::kArrayFields)
        json["fields"][row.name] = end.fields.*row.value;
    for (const midair::haptics::ExposureRow& row : midair::haptics::kExposureFigures)
        std::visit([&](auto member) { json["ears"][row.name] = end.exposure.*member; }, row.value);
    json["silence"] = {{"framesMuted", _muted.frames},
                       {"playedMuted", _muted.played},
                       {"framesAlone", _alone.frames},
                       {"playedAlone", _alone.played}};
    json["memory_MB"] = {
        {"settled", _memory_MB.first}, {"end", _memory_MB.last}, {"most", _memory_MB.most}};
    json["messages"] = nlohmann::ordered_json::array();
    for (const osgMidair::HapticMessage& message : end.told)
        json["messages"].push_back({{"code", message.code},
                                    {"severity", static_cast<int>(message.severity)},
                                    {"count", message.count},
                                    {"text", message.text}});
    json["linesSaid"] = _said->count();
    json["tooOften"] = _said->tooOften();
    json["pictures"] = _pictures;
    return json;
}

void InstallationRecord::print(const std::string& program,
                               const osgMidair::HapticStatistics& end) const
{
    const auto count = [](std::uint64_t number) { return static_cast<unsigned long long>(number); };
    std::printf("program     %s: %llu frames in %.1f s, %llu of them with hands\n",
                program.c_str(),
                count(_frames),
                std::max(0.0, _end_s - _begin_s),
                count(_withHands));
    std::printf("array       %d transducers; %s; %llu frames playing\n",
                end.transducers,
                end.device.c_str(),
                count(_playing));
    const std::string force = _touches == 0 ? ""
                              : _most.force_N > 0.0
                                  ? "up to " + haptics::forceText(_most.force_N) + "; "
                                  : "nothing felt; ";
    std::printf("touches     %llu; %sup to %.0f Pa (peak) at control points\n",
                count(_touches),
                force.c_str(),
                _most.pressure_Pa);
    std::printf("fields      %llu sent, %llu played, %llu dropped, %llu lost, %llu refused; %llu "
                "faults\n",
                count(end.fields.sent),
                count(end.fields.played),
                count(end.fields.dropped),
                count(end.fields.lost),
                count(end.fields.refused),
                count(end.fields.faults));
    if (end.exposure.places > 0)
        std::printf("at ears     %.0f dB re 20 uPa (rms) on average over %.0f s, at most %.0f dB "
                    "over a second; %s\n",
                    end.exposure.eq_dB,
                    end.exposure.time_s,
                    end.exposure.max_dB,
                    end.exposure.limit_dB > 0.0
                        ? fmt::format("limit {:.0f} dB", end.exposure.limit_dB).c_str()
                        : "no limit");
    std::printf("muted: %llu frames (%llu played), nobody there: %llu frames (%llu played)\n",
                count(_muted.frames),
                count(_muted.played),
                count(_alone.frames),
                count(_alone.played));
    std::printf("memory      %.1f MB settled, %.1f MB at the end, %.1f MB at most\n",
                _memory_MB.first,
                _memory_MB.last,
                _memory_MB.most);
    for (const auto& [what, times] : _said->tooOften())
        std::printf("too often   %s: %llu times in a second\n", what.c_str(), count(times));
    for (const std::string& message : end.messages)
        std::printf("note        %s\n", message.c_str());
}

} // namespace midair::samples
