#include "haptics/base/text/LineLimit.h"

#include <iterator>

namespace midair::base
{

namespace
{

/// More places than a scene has messages of; then those where nothing waits begin anew.
constexpr std::size_t kMostPlaces = 1000;

} // namespace

LineLimit::Line LineLimit::lineOf(MessageCode code, Told& told, double time_s)
{
    std::string text = std::exchange(told.newest, {});
    const std::uint64_t before = std::exchange(told.waiting, 0) - 1;
    if (before > 0)
        text += " (" + std::to_string(before) + " messages \"" + kindOf(code).name +
                "\" before it are left out here)";
    ++told.lines;
    told.last_s = time_s;
    return {kindOf(code).severity, std::move(text)};
}

std::optional<LineLimit::Line> LineLimit::take(const Message& message, double time_s)
{
    if (_told.size() >= kMostPlaces)
        for (auto one = _told.begin(); one != _told.end();)
            one = one->second.waiting == 0 ? _told.erase(one) : std::next(one);
    Told& told = _told[{message.code, message.path}];
    ++told.waiting;
    ++_waiting;
    told.newest = message.text;
    if (told.lines >= kFirst && time_s < told.last_s + kPause_s) return {};
    _waiting -= told.waiting;
    return lineOf(message.code, told, time_s);
}

std::vector<LineLimit::Line> LineLimit::due(double time_s)
{
    std::vector<Line> lines;
    if (_waiting == 0) return lines;
    for (auto& [place, told] : _told)
    {
        if (told.waiting == 0 || time_s < told.last_s + kPause_s) continue;
        _waiting -= told.waiting;
        lines.push_back(lineOf(place.first, told, time_s));
    }
    return lines;
}

} // namespace midair::base
