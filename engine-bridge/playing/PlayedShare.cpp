#include "engine-bridge/playing/PlayedShare.h"

#include <cmath>

namespace midair::bridge
{

namespace
{

constexpr double kMemory = 0.95; // weight of the older fields: some 20 count
// Two thresholds, so that a line that loses many fields is not told to fail and to be well in turn.
constexpr double kFaulty = 0.4;
constexpr double kWell = 0.6;

} // namespace

// Fields that a newer one replaced, or a mute refused, were not the device's to play.
bool PlayedShare::isFaulty(const device::DeviceReport& report)
{
    const std::uint64_t played = report.played;
    const std::uint64_t settled = played + report.lost;
    if (settled < _settled || played < _played) _settled = _played = 0; // another device's report
    const auto news = static_cast<double>(settled - _settled);
    if (news > 0.0)
    {
        const double old = std::pow(kMemory, news);
        _share = old * _share + (1.0 - old) * static_cast<double>(played - _played) / news;
    }
    _settled = settled;
    _played = played;
    _faulty = _share < (_faulty ? kWell : kFaulty);
    return _faulty;
}

void PlayedShare::forget(const device::DeviceReport& report)
{
    _played = report.played;
    _settled = report.played + report.lost;
    _share = 1.0;
    _faulty = false;
}

} // namespace midair::bridge
