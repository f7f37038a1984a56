#include "device/autd3/Refusals.h"

#include "device/DeviceLog.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace midair::device::autd3
{

namespace
{

constexpr const char* kNames[] = {
    "malformed", "foreign", "stray", "of a unit that isn't as it was", "of another protocol"};

} // namespace

void Refusals::add(Refusal refusal, const std::string& what, double now_s)
{
    Entry& entry = _entries[index(refusal)];
    ++entry.count;
    if (refusal == Refusal::STRAY) return;
    if (entry.logged > 0 && now_s - entry.logged_s < kLog_s) return;
    deviceLog().warn("{}: a datagram that is {} is refused: {}; {} since the last such line",
                     _device,
                     kNames[index(refusal)],
                     what,
                     entry.count - entry.logged);
    entry.logged = entry.count;
    entry.logged_s = now_s;
}

std::uint64_t Refusals::total() const
{
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < _entries.size(); ++i)
        if (i != index(Refusal::STRAY)) sum += _entries[i].count;
    return sum;
}

std::string Refusals::text() const
{
    std::string text;
    for (std::size_t i = 0; i < _entries.size(); ++i)
        if (i != index(Refusal::STRAY) && _entries[i].count > 0)
            text += fmt::format("{}{} {}", text.empty() ? "" : ", ", _entries[i].count, kNames[i]);
    return text;
}

} // namespace midair::device::autd3
