#include "device/autd3/emulator/EmulatedChain.h"
#include "haptics/base/Bytes.h"
#include "tests/fuzz/FuzzTargets.h"
#include "tests/fuzz/Require.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

using namespace midair::device::emulation;

namespace
{

using Bytes = std::vector<std::uint8_t>;

/// A host that comes after whatever was sent before.
class NewHost
{
public:
    NewHost(EmulatedChain& chain, Time_ns& now_ns) : _chain(chain), _now_ns(now_ns) {}

    Bytes ask(int to, const Bytes& bytes)
    {
        EmulatedChain::Answer answer;
        while (_chain.receive(answer, _now_ns))
        {
        }
        _chain.send(to, bytes.data(), bytes.size(), 1, _now_ns);
        pass(5);
        Bytes last;
        while (_chain.receive(answer, _now_ns))
            last = answer.bytes;
        return last;
    }
    void command(std::uint8_t number, Bytes commandAndPayload)
    {
        Bytes bytes = {2, 0, 1, 0, number};
        bytes.insert(bytes.end(), commandAndPayload.begin(), commandAndPayload.end());
        const Bytes answer = ask(0, bytes);
        require(answer.size() >= 16 && answer[5] == 0, "a command of a new host is done");
    }
    void pass(int time_ms)
    {
        _now_ns += time_ms * kMillisecond_ns;
        _chain.advance(_now_ns);
    }

private:
    EmulatedChain& _chain;
    Time_ns& _now_ns;
};

void playAnew(EmulatedChain& chain, Time_ns now_ns)
{
    NewHost host(chain, now_ns);
    host.pass(5000); // commands that wait are done
    host.ask(kGroup, {2, 2, 1, 0});
    host.pass(100);
    require(host.ask(kNoId, {2, 4, 1, 0, 0, 1}).size() == 5, "the first unit takes an id");
    host.ask(0, {2, 0, 1, 0, 255, 0}); // Reset, twice: the first may look like a repeat
    host.ask(0, {2, 0, 1, 0, 254, 0});
    host.command(0, {3});
    Bytes raw = {0x15, 1, 1, 0, 0};
    raw.insert(raw.end(), 249, 16);
    raw.insert(raw.end(), 249, 255);
    host.command(1, {0x30, 0, 0, 0, 1, 0, 1, 1, 0, 1, 0});
    host.command(2, raw);
    host.command(3, {0x11, 1, 1, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF});
    host.command(4, {0x12, 1, 0xFF, 0, 0, 0, 0, 0, 0, 0, 0});
    const midair::device::DriveSignal field = chain.field(now_ns);
    require(field.phase[248] == 240 && field.duty[248] == 255, "and its field plays");
}

} // namespace

void fuzzUnits(const std::uint8_t* data, std::size_t size)
{
    midair::base::ByteReader in(data, size);
    const unsigned how = in.u8();
    ChainOptions options;
    options.units = 1 + static_cast<int>(how % 3);
    options.perFrame_ns = (how & 4U) != 0 ? kMillisecond_ns : 0;
    options.wirePerByte_ns = (how & 8U) != 0 ? 80 : 0;
    options.settle_ns = (how & 16U) != 0 ? 20 * kMillisecond_ns : 0;
    options.drift_ppm = (how & 32U) != 0 ? 500 : 0;
    EmulatedChain chain(options);
    Time_ns now_ns = 0;
    EmulatedChain::Answer answer;
    while (in.left() >= 4)
    {
        const int to = in.u8();
        now_ns += Time_ns(in.u8()) * kMillisecond_ns / 4;
        const std::size_t wanted = in.u16() % 1500; // before left(), which it changes
        const std::size_t length = std::min(wanted, in.left());
        const std::uint8_t* bytes = in.bytes(length);
        chain.send(to < 250 ? to % 4 : (to == 255 ? kGroup : kNoId), bytes, length, 0, now_ns);
        while (chain.receive(answer, now_ns))
            require(answer.bytes.size() >= 5 && answer.bytes.size() <= 56 && answer.bytes[0] == 2,
                    "answers are as long as answers are");
    }
    for (const std::complex<float>& q : chain.output(now_ns))
        require(std::abs(q) <= 1.001F, "no transducer plays more than full drive");
    playAnew(chain, now_ns);
}
