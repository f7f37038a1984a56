#pragma once

#include "device/autd3/emulator/EmulatedChain.h"

#include <cstdint>
#include <string>
#include <vector>

namespace midair::device::emulation
{

using Bytes = std::vector<std::uint8_t>;

/// Bytes of hexadecimal text: "02 00", "FF*249" so many, "00..F8" counting.
Bytes hex(const std::string& text);
/// The same, back, for messages.
std::string hexText(const Bytes& bytes);

/// Units on a bench in virtual time: what is sent is answered at once, unless the options say how
/// long things take.
class UnitBench
{
public:
    explicit UnitBench(const ChainOptions& options = {}) : chain(options) {}

    /// Sends, and returns what has come back by then, oldest first.
    std::vector<Bytes> ask(int to, const Bytes& bytes);
    /// The only answer to that; empty if there was none, or more than one.
    Bytes askOne(int to, const std::string& text);
    std::vector<Bytes> answers(); ///< that have come since
    void pass(double time_ms);

    /// ResetId, then an id for each unit, clocks and Reset, Clear, Synchronize, silencer off.
    void open();
    /// A command in turn to \a unit; returns its result, or -1 without an answer.
    int command(int unit, const std::string& commandAndPayload);
    /// What a read in turn answers.
    Bytes read(int unit, const std::string& command);
    unsigned state(int unit) { return read(unit, "E7").at(0); } ///< ReadFpgaState

    /// SetCpuConfig with these, and the firmware's defaults.
    static std::string cpuConfig(int margin_ns, int failsafe_ms, int unlocked_ms = 0);
    std::string patternConfig(int bank, int divider, int slots, int rounds); ///< rounds 0: for ever
    std::string activation(int bank, int mode, std::uint64_t value_ns = 0);
    /// Every transducer with one phase and intensity, in \a slot of \a bank.
    std::string rawSlot(int bank, int slot, int phase, int intensity);

    ChainReport report() const { return chain.report(now_ns); }

    EmulatedChain chain;
    Time_ns now_ns = 0;
    int lastFrom = kNoId;                                           ///< who gave the last answer
    std::vector<std::uint8_t> next = std::vector<std::uint8_t>(64); ///< numbers that are due
};

} // namespace midair::device::emulation
