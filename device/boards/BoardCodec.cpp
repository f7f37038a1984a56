#include "device/boards/BoardCodec.h"

#include <array>
#include <cmath>

namespace midair::device
{

namespace
{

constexpr int kDutyHalf = 255; // duty level of a pulse of half a period
constexpr int kDutyPeriod = 510;

// round(-phase * steps / 256) in 0 .. steps-1: the delay in steps of the period.
int delaySteps(int phase, int steps)
{
    const int later = (256 - phase) * steps;
    return ((later + 128) / 256) % steps;
}

std::complex<float> activation(double delay_turns, double duty)
{
    return std::complex<float>(std::polar(std::sin(M_PI * duty), -2 * M_PI * delay_turns));
}

/// 16 x 16 emitters on a serial port of 230400 baud: 254, 256 delays of 1/32 period (32: off), 253 to exchange two buffers.
/// 151 switches the emitters' clocks on; 192 and 193 choose which of two stacked boards takes fields. They go before 254, since the
/// design for tactile modulation knows none of the three and takes them for delays, which 254 then overwrites.
/// Source: the board's published FPGA design and host program (S. Freire, A. Marzo, "SonicSurface", Distribute.vhd).
class SonicSurface : public BoardCodec
{
public:
    const char* name() const override { return "sonicsurface"; }
    bool takes(int transducers) const override { return transducers == kEmitters; }
    std::string takesText() const override { return "256 transducers"; }
    int phaseLevels() const override { return kSteps; }
    std::vector<float> amplitudes() const override { return {0, 1}; }
    double bytesPerSecond() const override { return 23040; }
    void appendOpening(std::vector<std::uint8_t>& out) const override
    {
        out.push_back(kClocksOn);
        out.push_back(kPrimary);
    }
    bool restarts() const override { return true; }
    int silentFields() const override { return 2; } // two buffers

    // The board that is stacked on ours, if there is one, may still play what another program left it. Ours comes first, since
    // every swap is for both.
    void appendReset(std::vector<std::uint8_t>& out, int transducers) const override
    {
        appendSilence(out, transducers);
        out.push_back(kSecondary);
        for (int i = 0; i < silentFields(); ++i)
            appendSilentField(out, transducers);
        out.push_back(kPrimary);
    }

    void appendField(std::vector<std::uint8_t>& out, const DriveSignal& signal) const override
    {
        out.push_back(254);
        for (int i = 0; i < kEmitters; ++i)
            out.push_back(static_cast<std::uint8_t>(
                on(signal.duty[i]) ? delaySteps(signal.phase[i], kSteps) : kSteps));
        out.push_back(253);
    }

    void played(const DriveSignal& signal, std::vector<std::complex<float>>& q) const override
    {
        q.resize(kEmitters);
        for (int i = 0; i < kEmitters; ++i)
            q[i] = on(signal.duty[i])
                       ? activation(delaySteps(signal.phase[i], kSteps) / double(kSteps), 0.5)
                       : std::complex<float>(0);
    }

private:
    static constexpr int kEmitters = 256;
    static constexpr int kSteps = 32;
    static constexpr std::uint8_t kClocksOn = 151;
    static constexpr std::uint8_t kPrimary = 192;
    static constexpr std::uint8_t kSecondary = 193;

    // On is the nearer of the two amplitudes from sin(pi duty/510) = 1/2 up.
    static bool on(int duty) { return duty >= kDutyPeriod / 6; }
};

/// Up to 14 chained Arduino Mega with 64 channels each at 115200 baud: ten time steps a period of a bit a channel.
/// Source: the published firmware and host program (A. Marzo, T. Corkett, B. Drinkwater, "Ultraino").
class Ultraino : public BoardCodec
{
public:
    const char* name() const override { return "ultraino"; }
    bool takes(int transducers) const override
    {
        return transducers > 0 && transducers % kChannels == 0 &&
               transducers <= kMostBoards * kChannels;
    }
    std::string takesText() const override { return "64 transducers a board, 1 to 14 boards"; }
    int phaseLevels() const override { return kSteps; }
    std::vector<float> amplitudes() const override
    {
        std::vector<float> levels;
        for (int high = 0; high <= kSteps / 2; ++high)
            levels.push_back(static_cast<float>(std::sin(M_PI * high / kSteps)));
        return levels;
    }
    double bytesPerSecond() const override { return 11520; }
    bool restarts() const override { return false; }
    // Two buffers, and a field that was cut off shifts the first silent one, which then leaves the cut one's head where it is.
    int silentFields() const override { return 3; }
    int answer() const override
    {
        return 0x00;
    } // what is for the next board of the chain goes to the computer too

    // The board plays a list of patterns, each for so many periods: here one pattern for ever (durations 1, then 0 as the end).
    void appendOpening(std::vector<std::uint8_t>& out) const override
    {
        for (const int duration : {1, 0})
            for (int shift = 0; shift <= 6; shift += 2)
                out.push_back(static_cast<std::uint8_t>(0x30 | ((duration << shift) & 0xC0)));
        out.push_back(0x10);
    }

    void appendField(std::vector<std::uint8_t>& out, const DriveSignal& signal) const override
    {
        for (int board = 0; board * kChannels < signal.size(); ++board)
        {
            std::array<std::uint8_t, std::size_t(kSteps) * kPorts> bits{};
            for (int channel = 0; channel < kChannels; ++channel)
            {
                const Pulse pulse = pulseOf(signal, board * kChannels + channel);
                const int pin = kPins[channel];
                for (int step = 0; step < pulse.high; ++step)
                    bits[(pulse.start + step) % kSteps * kPorts + pin / 8] |=
                        static_cast<std::uint8_t>(1 << (pin % 8));
            }
            const int id = board + 1;
            for (const int byte : bits)
            {
                out.push_back(static_cast<std::uint8_t>((byte & 0xF0) | id));
                out.push_back(static_cast<std::uint8_t>(((byte << 4) & 0xF0) | id));
            }
        }
        out.push_back(0x00);
    }

    void played(const DriveSignal& signal, std::vector<std::complex<float>>& q) const override
    {
        q.resize(signal.size());
        for (int i = 0; i < signal.size(); ++i)
        {
            const Pulse pulse = pulseOf(signal, i);
            const double centre = pulse.start + pulse.high / 2.0 - kSteps / 4.0;
            q[i] = activation(centre / kSteps, pulse.high / double(kSteps));
        }
    }

private:
    static constexpr int kChannels = 64;
    static constexpr int kMostBoards = 14;
    static constexpr int kSteps = 10;
    static constexpr int kPorts = 10; // A C L B K F H D G J
    // Which bit of the ten ports drives a channel (bit of port p: 8 p + bit).
    static constexpr std::array<std::uint8_t, kChannels> kPins = {
        51, 52, 53, 54, 28, 29, 30, 31, 47, 46, 45, 44, 43, 42, 41, 40, 56, 57, 58, 59, 48, 49,
        72, 69, 39, 38, 37, 36, 35, 34, 33, 32, 21, 23, 65, 63, 9,  11, 13, 15, 20, 22, 64, 66,
        8,  10, 12, 14, 24, 25, 26, 27, 16, 17, 18, 19, 7,  6,  5,  4,  3,  2,  1,  0};

    struct Pulse
    {
        int start; ///< step
        int high;  ///< steps
    };

    // Amplitude A, as relative pulse width, is round(A 10/2) high steps. A pulse of fewer than 5 starts later by half of what it
    // lacks, to keep its centre, rounded to a step: (256 - phase) 10/256 + (5 - high)/2.
    static Pulse pulseOf(const DriveSignal& signal, int i)
    {
        const int high = (signal.duty[i] * kSteps + kDutyHalf) / kDutyPeriod;
        const int start256 = (256 - signal.phase[i]) * kSteps + (kSteps / 2 - high) * 128;
        return {((start256 + 128) / 256) % kSteps, high};
    }
};

/// 256 emitters behind an FT232H FIFO: 256 delays of 1/128 period in pin order, then 256 pulse widths of 1/128 period.
/// Bit 7 of the first delay starts a frame; bits 7 of delays 26 to 34 set the rate. Source: the published driver of OpenMPD
/// and the board's FPGA design (RMResearch, OpenMPD_Hardware, FPGA_3.4.2: FrameBufferController.vhd, CommandReader.vhd).
class OpenMpd : public BoardCodec
{
public:
    const char* name() const override { return "openmpd"; }
    bool takes(int transducers) const override { return transducers == kEmitters; }
    std::string takesText() const override { return "256 transducers"; }
    int phaseLevels() const override { return kSteps; }
    std::vector<float> amplitudes() const override
    {
        std::vector<float> levels;
        for (int width = 0; width <= kSteps / 2; ++width)
            levels.push_back(static_cast<float>(std::sin(M_PI * width / kSteps)));
        return levels;
    }
    double bytesPerSecond() const override { return 8e6; } // the asynchronous FIFO's
    void appendOpening(std::vector<std::uint8_t>&) const override {}
    bool restarts() const override { return false; }
    // The board takes 512 bytes at a time and finds the start of a frame by its bit: after one that was cut off it plays every
    // frame when the next one has come, the second whole one at the earliest.
    int silentFields() const override { return 4; }

    // Delays of 0, where a field that is all off has others: a frame whose start is lost may take delays for pulse widths.
    void appendSilentField(std::vector<std::uint8_t>& out, int) const override
    {
        out.push_back(kStart);
        out.insert(out.end(), 2UL * kEmitters - 1, 0);
    }

    void appendField(std::vector<std::uint8_t>& out, const DriveSignal& signal) const override
    {
        const std::size_t begin = out.size();
        out.resize(begin + 2UL * kEmitters);
        for (int i = 0; i < kEmitters; ++i)
        {
            const int width = widthOf(signal.duty[i]);
            out[begin + i] = static_cast<std::uint8_t>(startOf(signal.phase[i], width));
            out[begin + kEmitters + i] = static_cast<std::uint8_t>(width);
        }
        out[begin] |= kStart;
    }

    void played(const DriveSignal& signal, std::vector<std::complex<float>>& q) const override
    {
        q.resize(kEmitters);
        for (int i = 0; i < kEmitters; ++i)
        {
            const int width = widthOf(signal.duty[i]);
            const double centre = startOf(signal.phase[i], width) + width / 2.0 - kSteps / 4.0;
            q[i] = activation(centre / kSteps, width / double(kSteps));
        }
    }

private:
    static constexpr int kEmitters = 256;
    static constexpr int kSteps = 128;
    static constexpr std::uint8_t kStart = 0x80;

    // trunc(128 asin(A)/pi) with A = sin(pi duty/510).
    static int widthOf(int duty) { return duty * kSteps / kDutyPeriod; }
    static int startOf(int phase, int width)
    {
        return (delaySteps(phase, kSteps) + (kSteps / 2 - width) / 2) % kSteps;
    }
};

} // namespace

double BoardCodec::fieldsPerSecond(int transducers) const
{
    std::vector<std::uint8_t> field;
    appendSilentField(field, transducers);
    return bytesPerSecond() / static_cast<double>(field.size());
}

void BoardCodec::appendSilentField(std::vector<std::uint8_t>& out, int transducers) const
{
    DriveSignal off;
    off.phase.assign(transducers, 0);
    off.duty.assign(transducers, 0);
    appendField(out, off);
}

void BoardCodec::appendSilence(std::vector<std::uint8_t>& out, int transducers) const
{
    appendOpening(out);
    for (int i = 0; i < silentFields(); ++i)
        appendSilentField(out, transducers);
}

std::unique_ptr<BoardCodec> makeBoardCodec(const std::string& name)
{
    if (name == "sonicsurface") return std::make_unique<SonicSurface>();
    if (name == "ultraino") return std::make_unique<Ultraino>();
    if (name == "openmpd") return std::make_unique<OpenMpd>();
    return nullptr;
}

} // namespace midair::device
