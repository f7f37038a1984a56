#include "device/autd3/LinkChoice.h"

#include "device/autd3/UdpLink.h"
#include "device/autd3/protocol/Messages.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

namespace midair::device::autd3
{

namespace
{

constexpr double kLinkAnswer_s = 0.1;
constexpr int kLinkTries = 3;
constexpr std::uint16_t kNumber = 0x4D44;

// Any answer of the protocol will do, also one that refuses: those of the first question that gets
// one.
std::vector<Answer>
askAll(DatagramLink& link, Refusals& refusals, const std::function<bool()>& isLeft)
{
    Endpoint from;
    std::vector<std::uint8_t> bytes;
    std::vector<Answer> answers;
    for (int i = 0; i < kLinkTries && answers.empty() && !isLeft(); ++i)
    {
        if (!link.sendToGroup(message(Kind::READ_UNIT_INFO, kNumber))) continue;
        const double until_s = link.now_s() + kLinkAnswer_s;
        while (link.now_s() < until_s)
        {
            Answer answer;
            std::string error;
            if (!link.receive(until_s, from, bytes)) continue;
            if (readAnswer(bytes, answer, error) && answer.kind == Kind::READ_UNIT_INFO &&
                answer.number == kNumber)
                answers.push_back(std::move(answer));
            else
                refusals.add(error.empty() ? Refusal::STRAY : Refusal::MALFORMED,
                             endpointText(from) + ": " + error,
                             link.now_s());
        }
    }
    return answers;
}

std::string namesOf(const std::vector<NetworkInterface>& interfaces)
{
    std::string names;
    for (const NetworkInterface& one : interfaces)
        names += (names.empty() ? "" : ", ") + one.name;
    return names;
}

std::unique_ptr<DatagramLink> named(const Autd3Options& options)
{
    const std::vector<NetworkInterface> all = linkLocalInterfaces();
    const auto one =
        std::find_if(all.begin(),
                     all.end(),
                     [&](const NetworkInterface& i) { return i.name == options.interface; });
    if (one == all.end())
        throw DeviceError(fmt::format("{}: interface={} isn't there, is down or has no link-local "
                                      "IPv6 address; there are: {}",
                                      deviceName(options),
                                      options.interface,
                                      all.empty() ? "none" : namesOf(all)));
    return std::make_unique<UdpLink>(*one);
}

} // namespace

std::string deviceName(const Autd3Options& options)
{
    if (!options.group.empty()) return "autd3 at " + options.group;
    return options.interface.empty() ? "autd3" : "autd3 on " + options.interface;
}

std::unique_ptr<DatagramLink>
chooseLink(const Autd3Options& options, Refusals& refusals, const std::function<bool()>& isLeft)
{
    if (!options.group.empty())
    {
        Endpoint group;
        if (!parseEndpoint(options.group, group))
            throw DeviceError(fmt::format(
                "autd3: group={} should be [ADDRESS]:PORT, such as [::1]:44336", options.group));
        return std::make_unique<UdpLink>(group);
    }
    if (!options.interface.empty()) return named(options);
    const std::vector<NetworkInterface> all = linkLocalInterfaces();
    std::vector<NetworkInterface> found;
    std::unique_ptr<UdpLink> chosen;
    for (const NetworkInterface& one : all)
    {
        auto link = std::make_unique<UdpLink>(one);
        if (askAll(*link, refusals, isLeft).empty()) continue;
        found.push_back(one);
        chosen = std::move(link);
    }
    if (found.size() > 1)
        throw DeviceError(fmt::format("autd3: units answer on {}; say which with interface=NAME",
                                      namesOf(found)));
    if (found.empty() && all.empty())
        throw DeviceError("autd3: no network interface is up with a link-local IPv6 address");
    if (found.empty())
        throw DeviceError(fmt::format(
            "autd3: nobody answers on {}: units need some seconds after power-on, and a firewall "
            "must let UDP from port {} in",
            namesOf(all),
            kPort));
    return chosen;
}

std::vector<UnitsListing> listUnits()
{
    std::vector<UnitsListing> found;
    Refusals refusals("autd3");
    for (const NetworkInterface& one : linkLocalInterfaces())
        try
        {
            UdpLink link(one);
            const std::vector<Answer> answers = askAll(link, refusals, [] { return false; });
            if (answers.empty()) continue;
            const Answer& first = answers.front();
            const bool isSpoken = first.version == kProtocolVersion && first.status == 0;
            found.push_back({one.name,
                             static_cast<int>(answers.size()),
                             isSpoken ? first.info.firmware.text() : std::string()});
        }
        catch (const DeviceError&) // it has gone since
        {
        }
    return found;
}

} // namespace midair::device::autd3
