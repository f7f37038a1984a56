#include "device/boards/BoardKind.h"
#include "haptics/base/DutyLaw.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace midair::device
{

namespace
{

/// Up to 14 chained Arduino Megas with 64 channels each at 115200 baud: ten time steps per period,
/// each with one bit per channel. Source: the published firmware and host program (A. Marzo, T.
/// Corkett, B. Drinkwater, "Ultraino").
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
            levels.push_back(static_cast<float>(base::pulseAmplitude(high, kSteps)));
        return levels;
    }
    double bytesPerSecond() const override { return 11520; }
    bool restarts() const override { return false; }
    // Two buffers, plus one: after a truncated field the first silent one is shifted and doesn't
    // overwrite the beginning of the truncated one.
    int silentFields() const override { return 3; }
    int answer() const override
    {
        return 0x00;
    } // the bytes for the next board of the chain also go to the computer

    // The board plays a list of patterns with durations in periods: here one pattern for ever
    // (durations 1, then 0 as the end).
    void appendOpening(std::vector<std::uint8_t>& out) const override
    {
        appendDurations(out, {1, 0});
    }

    static void appendDurations(std::vector<std::uint8_t>& out, const std::vector<int>& durations)
    {
        for (const int duration : durations)
            for (int shift = 0; shift <= 6; shift += 2)
                out.push_back(static_cast<std::uint8_t>(0x30 | ((duration << shift) & 0xC0)));
        out.push_back(0x10);
    }

    int sequenceFields() const override { return kPatterns; }
    double sequenceClock_Hz() const override { return DriveSequence::kMostRate_Hz; }

    // Patterns with their durations in periods of the ultrasound, 1 to 255 each, and 0 as the end
    // of the list. The durations come first, so that the next byte exchanges the patterns; the
    // sketch goes on counting where it was, so that for up to 255 periods patterns may have each
    // other's durations.
    Pieces piecesOf(const DriveSequence& sequence) const override
    {
        const int periods =
            static_cast<int>(std::lround(DriveSequence::kMostRate_Hz / sequence.rate_Hz));
        Pieces pieces;
        std::vector<int> durations;
        const DriveSignal* last = nullptr;
        for (const DriveSignal& signal : sequence.signals)
            for (int left = periods; left > 0;)
            {
                const bool isSame = last != nullptr && last->phase == signal.phase &&
                                    last->duty == signal.duty && durations.back() < kLongest;
                if (!isSame)
                {
                    durations.push_back(0);
                    if (durations.size() > static_cast<std::size_t>(kPatterns)) return {};
                    appendPattern(pieces.emplace_back(), signal);
                    last = &signal;
                }
                const int more = std::min(left, kLongest - durations.back());
                durations.back() += more;
                left -= more;
            }
        if (durations.size() < static_cast<std::size_t>(kPatterns)) durations.push_back(0);
        // The last pattern isn't without its end, as the board has no room for one more.
        appendDurations(pieces.back(), durations);
        pieces.back().push_back(0x00);
        return pieces;
    }
    void appendBreak(std::vector<std::uint8_t>& out) const override
    {
        appendOpening(out);
        out.push_back(0x00);
    }

    void appendField(std::vector<std::uint8_t>& out, const DriveSignal& signal) const override
    {
        appendPattern(out, signal);
        out.push_back(0x00);
    }

    static void appendPattern(std::vector<std::uint8_t>& out, const DriveSignal& signal)
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
    }

    void played(const DriveSignal& signal, std::vector<std::complex<float>>& q) const override
    {
        q.resize(signal.size());
        for (int i = 0; i < signal.size(); ++i)
        {
            const Pulse pulse = pulseOf(signal, i);
            const double centre = pulse.start + pulse.high / 2.0 - kSteps / 4.0;
            q[i] = pulseActivation(centre / kSteps, pulse.high / double(kSteps));
        }
    }

private:
    static constexpr int kChannels = 64;
    static constexpr int kMostBoards = 14;
    static constexpr int kSteps = 10;
    static constexpr int kPorts = 10; // A C L B K F H D G J
    static constexpr int kPatterns = 32;
    static constexpr int kLongest = 255; ///< periods that a pattern lasts at most
    // Bit of the ten ports that drives a channel (bit of port p: 8 p + bit).
    static constexpr std::array<std::uint8_t, kChannels> kPins = {
        51, 52, 53, 54, 28, 29, 30, 31, 47, 46, 45, 44, 43, 42, 41, 40, 56, 57, 58, 59, 48, 49,
        72, 69, 39, 38, 37, 36, 35, 34, 33, 32, 21, 23, 65, 63, 9,  11, 13, 15, 20, 22, 64, 66,
        8,  10, 12, 14, 24, 25, 26, 27, 16, 17, 18, 19, 7,  6,  5,  4,  3,  2,  1,  0};

    /// A pulse in time steps of the period.
    struct Pulse
    {
        int start; ///< step
        int high;  ///< steps
    };

    // Amplitude A, as relative pulse width, is round(A 10/2) high steps. A pulse of fewer than 5
    // starts later by half of what it lacks, to keep its centre, rounded to a step: (256 - phase)
    // 10/256 + (5 - high)/2.
    static Pulse pulseOf(const DriveSignal& signal, int i)
    {
        const int high = (signal.duty[i] * kSteps + base::kFullDuty) / base::kDutyPeriod;
        const int start256 = (256 - signal.phase[i]) * kSteps + (kSteps / 2 - high) * 128;
        return {((start256 + 128) / 256) % kSteps, high};
    }
};

std::unique_ptr<BoardCodec> makeCodec()
{
    return std::make_unique<Ultraino>();
}

// Opening the port resets an Arduino, whose bootloader waits for a second, and longer while bytes
// arrive.
std::unique_ptr<ArrayDevice> open(DeviceUri& uri, const DeviceLayout& layout)
{
    return openOnSerialPort(uri, layout, makeCodec(), {115200, 2});
}

} // namespace

extern const BoardKind kUltraino = {
    "ultraino",
    "ultraino:TTY            open boards of 64, chained, on a serial port",
    Owned::FILE,
    makeCodec,
    open};

} // namespace midair::device
