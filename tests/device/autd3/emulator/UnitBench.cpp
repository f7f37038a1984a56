#include "tests/device/autd3/emulator/UnitBench.h"

#include <sstream>

#include <fmt/format.h>

namespace midair::device::emulation
{

Bytes hex(const std::string& text)
{
    Bytes bytes;
    std::istringstream words(text);
    for (std::string word; words >> word;)
    {
        const int byte = std::stoi(word.substr(0, 2), nullptr, 16);
        if (word.size() > 3 && word[2] == '*')
            bytes.insert(bytes.end(), std::stoul(word.substr(3)), static_cast<std::uint8_t>(byte));
        else if (word.size() == 6)
            for (int b = byte; b <= std::stoi(word.substr(4), nullptr, 16); ++b)
                bytes.push_back(static_cast<std::uint8_t>(b));
        else
            bytes.push_back(static_cast<std::uint8_t>(byte));
    }
    return bytes;
}

std::string hexText(const Bytes& bytes)
{
    return fmt::format("{:02X}", fmt::join(bytes, " "));
}

std::vector<Bytes> UnitBench::answers()
{
    std::vector<Bytes> all;
    EmulatedChain::Answer answer;
    while (chain.receive(answer, now_ns))
    {
        lastFrom = answer.from;
        all.push_back(answer.bytes);
    }
    return all;
}

std::vector<Bytes> UnitBench::ask(int to, const Bytes& bytes)
{
    chain.send(to, bytes.data(), bytes.size(), 7, now_ns);
    return answers();
}

Bytes UnitBench::askOne(int to, const std::string& text)
{
    const std::vector<Bytes> all = ask(to, hex(text));
    return all.size() == 1 ? all.front() : Bytes();
}

void UnitBench::pass(double time_ms)
{
    now_ns += static_cast<Time_ns>(time_ms * 1e6);
    chain.advance(now_ns);
}

void UnitBench::open()
{
    ask(kGroup, hex("02 02 01 00"));
    pass(120);
    for (int unit = 0; unit < chain.units(); ++unit)
    {
        askOne(kNoId, fmt::format("02 04 02 00 {:02X} {:02X}", unit, unit == 0 ? 1 : 0));
        askOne(unit, "02 05 03 00");
    }
    askOne(0, "02 06 04 00 00*8");
    pass(2000);
    for (int unit = 0; unit < chain.units(); ++unit)
    {
        askOne(unit, "02 00 05 00 00 00");
        next[unit] = 0;
        command(unit, "03");
        command(unit, "01");
        command(unit, "30 00 00 00 01 00 01 01 00 01 00");
    }
}

int UnitBench::command(int unit, const std::string& commandAndPayload)
{
    const Bytes answer =
        askOne(unit, fmt::format("02 00 77 00 {:02X} {}", next[unit], commandAndPayload));
    if (answer.size() < 16) return -1;
    next[unit] = static_cast<std::uint8_t>(answer[4] + 1);
    return answer[5];
}

Bytes UnitBench::read(int unit, const std::string& command)
{
    const Bytes answer = askOne(unit, fmt::format("02 00 77 00 {:02X} {}", next[unit]++, command));
    return answer.size() < 16 ? Bytes() : Bytes(answer.begin() + 16, answer.end());
}

std::string UnitBench::cpuConfig(int margin_ns, int failsafe_ms, int unlocked_ms)
{
    return fmt::format("05 {:02X} {:02X} {:02X} 00 40 42 0F 00 00 94 35 77 90 D0 03 00 64 00 08 00 "
                       "03 00 06 00 E8 03 40 00 10 27 00 00 64 00 00 00 32 00 00 00 01 00 00 00 20 "
                       "A1 07 00 {:02X} {:02X} 20 00 05 00 30 00 40 00 08 00 {:02X} {:02X} 03 00",
                       margin_ns & 255,
                       (margin_ns >> 8) & 255,
                       (margin_ns >> 16) & 255,
                       failsafe_ms & 255,
                       failsafe_ms >> 8,
                       unlocked_ms & 255,
                       unlocked_ms >> 8);
}

std::string UnitBench::patternConfig(int bank, int divider, int slots, int rounds)
{
    const int field = rounds == 0 ? 0xFFFF : rounds - 1;
    return fmt::format("11 {:02X} 01 {:02X} {:02X} {:02X} {:02X} 00*6 {:02X} {:02X}",
                       bank,
                       divider & 255,
                       divider >> 8,
                       slots & 255,
                       slots >> 8,
                       field & 255,
                       field >> 8);
}

std::string UnitBench::activation(int bank, int mode, std::uint64_t value_ns)
{
    std::string text = fmt::format("12 {:02X} {:02X}", bank, mode);
    for (int i = 0; i < 8; ++i)
        text += fmt::format(" {:02X}", (value_ns >> (8 * i)) & 255);
    return text;
}

std::string UnitBench::rawSlot(int bank, int slot, int phase, int intensity)
{
    return fmt::format("15 {:02X} 01 {:02X} {:02X} {:02X}*249 {:02X}*249",
                       bank,
                       slot & 255,
                       slot >> 8,
                       phase,
                       intensity);
}

} // namespace midair::device::emulation
