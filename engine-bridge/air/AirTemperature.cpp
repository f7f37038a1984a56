#include "engine-bridge/air/AirTemperature.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

void AirTemperature::setSource(const std::string& file)
{
    if (file == _name) return;
    _source = file.empty() ? nullptr : std::make_unique<TemperatureSource>(file);
    _name = file;
    _readings = 0;
    _follows = _hasBegun = false;
    _badTold = _staleTold = _closedTold = false;
}

double AirTemperature::at(double now_s, double set_C)
{
    return _source ? follow(_source->take(), now_s, set_C) : set_C;
}

double AirTemperature::follow(const TemperatureSource::News& news, double now_s, double set_C)
{
    if (!_hasBegun) _heard_s = now_s;
    _hasBegun = true;
    listen(news, now_s);
    if (_readings == 0) return set_C;
    if (!_follows) _now_C = set_C;
    const double way_K = median() - _now_C;
    if (std::fabs(way_K) < kLeast_K || (_follows && now_s - _stepped_s < kPause_s)) return _now_C;
    _follows = true;
    _stepped_s = now_s;
    _now_C += std::clamp(way_K, -kStep_K, kStep_K);
    return _now_C;
}

void AirTemperature::listen(const TemperatureSource::News& news, double now_s)
{
    const std::string kept =
        _readings > 0 ? fmt::format("the last good reading, {:.1f} C, is kept", _last[0])
                      : std::string("until there is one the temperature that is set is used");
    if (news.temperature_C)
    {
        _last = {*news.temperature_C, _last[0], _last[1]};
        _readings = std::min(_readings + 1, 3);
        _heard_s = now_s;
        _staleTold = _closedTold = false;
    }
    if (news.bad > 0 && !std::exchange(_badTold, true)) tell(news.problem + "; " + kept);
    if (news.bad > 0) _bad_s = now_s;
    if (now_s - _bad_s > kStale_s) _badTold = false;
    if (news.isClosed && !news.problem.empty() && !std::exchange(_closedTold, true))
        tell(news.problem + "; " + kept);
    if (now_s - _heard_s > kStale_s && !std::exchange(_staleTold, true))
        tell(fmt::format("no good reading for {:g} s; {}", kStale_s, kept));
}

double AirTemperature::median() const
{
    std::array<double, 3> sorted = _last;
    if (_readings < 3) return _last[0];
    std::sort(sorted.begin(), sorted.end());
    return sorted[1];
}

void AirTemperature::tell(const std::string& what)
{
    _messages.push_back(
        {base::MessageCode::AIR_TEMPERATURE, "temperature source \"" + _name + "\": " + what});
}

std::vector<base::Message> AirTemperature::takeMessages()
{
    return std::exchange(_messages, {});
}

} // namespace midair::bridge
