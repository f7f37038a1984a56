#include "device/DeviceLog.h"
#include "device/autd3/UnitGroup.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/fuzz/FuzzTargets.h"
#include "tests/fuzz/Require.h"

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

using namespace midair::device::autd3;
using midair::device::sendDeviceLogTo;

namespace
{

Endpoint unitAt(int k)
{
    Endpoint at;
    at.address = {0xFE, 0x80};
    at.address.back() = static_cast<std::uint8_t>(k);
    at.port = kPort;
    at.scope = 1;
    return at;
}

/// Hands out what it was given, and keeps what is sent.
class GivenLink : public DatagramLink
{
public:
    std::string name() const override { return "fuzz"; }
    bool send(const Endpoint& to, const std::vector<std::uint8_t>& bytes) override
    {
        sent.emplace_back(to, bytes);
        return true;
    }
    bool sendToGroup(const std::vector<std::uint8_t>&) override { return true; }
    bool receive(double, Endpoint& from, std::vector<std::uint8_t>& bytes) override
    {
        if (given.empty()) return false;
        from = given.front().first;
        bytes = std::move(given.front().second);
        given.pop_front();
        return true;
    }
    void rest(double) override {}
    void wake() override {}

    std::deque<std::pair<Endpoint, std::vector<std::uint8_t>>> given;
    std::vector<std::pair<Endpoint, std::vector<std::uint8_t>>> sent;
};

void readAgain(const std::vector<std::uint8_t>& bytes)
{
    Answer answer;
    answer.number = 0x5A5A;
    answer.reply.data = {1, 2, 3};
    std::string error;
    if (readAnswer(bytes, answer, error)) return;
    require(!error.empty(), "what is no answer is refused with a reason");
    require(answer.number == 0x5A5A && answer.reply.data.size() == 3,
            "what is refused changes nothing");
}

} // namespace

// A datagram: its length, who it is from (0 .. 1: a unit, else somebody else), and its bytes; those
// from a unit get, where the first byte says so, the header of the answer that is waited for.
void fuzzAutd3(const std::uint8_t* data, std::size_t size)
{
    static const bool kQuiet = (sendDeviceLogTo([](bool, const std::string&) {}), true);
    (void)kQuiet;
    constexpr int kUnits = 2;
    constexpr int kCommands = 20;
    GivenLink link;
    Refusals refusals("fuzz");
    std::vector<Unit> units(kUnits);
    for (int k = 0; k < kUnits; ++k)
    {
        units[static_cast<std::size_t>(k)].at = unitAt(k);
        units[static_cast<std::size_t>(k)].id = static_cast<std::uint8_t>(k);
    }
    UnitGroup group(link, refusals, std::move(units), {10, 10});
    for (int i = 0; i < kCommands; ++i)
        for (int k = 0; k < kUnits; ++k)
            group.push(k, Command::nop());
    std::vector<int> settled(kUnits);
    std::size_t at = 0;
    std::uint64_t foreign = 0;
    while (at + 2 <= size)
    {
        group.pump(midair::base::steadySeconds());
        const int from = data[at + 1] % 4;
        const std::size_t length = std::min<std::size_t>(data[at] % 80, size - at - 2);
        std::vector<std::uint8_t> bytes(data + at + 2, data + at + 2 + length);
        at += 2 + length;
        if (from < kUnits && length >= 16 && bytes[1] == 0x80 && !link.sent.empty())
            std::copy_n(link.sent.back().second.begin(), 4, bytes.begin());
        readAgain(bytes);
        if (from >= kUnits) ++foreign;
        link.given.emplace_back(unitAt(from), std::move(bytes));
        group.receive(0);
        for (const UnitGroup::Outcome& outcome : group.takeOutcomes())
        {
            require(from < kUnits && outcome.unit == from, "a foreign answer settles nothing");
            ++settled[static_cast<std::size_t>(outcome.unit)];
            require(outcome.done.data.size() <= kMostReplyData, "no more data than there may be");
        }
    }
    for (const int count : settled)
        require(count <= kCommands, "a command is settled once");
    require(refusals.total() >= foreign, "foreign datagrams are counted");
    for (const auto& one : link.sent)
        require(one.second.size() <= kMostDatagramBytes && one.second[0] == kProtocolVersion,
                "what is sent are datagrams of the protocol");
}
