#include "device/boards/BoardKind.h"
#include "haptics/base/DutyLaw.h"

namespace midair::device
{

namespace
{

/// 256 emitters behind an FT232H FIFO: 256 delays of 1/128 period in pin order, then 256 pulse
/// widths of 1/128 period. Bit 7 of the first delay starts a frame; bits 7 of delays 26 to 34 set
/// the rate. Source: the published driver of OpenMPD and the board's FPGA design (RMResearch,
/// OpenMPD_Hardware, FPGA_3.4.2: FrameBufferController.vhd, CommandReader.vhd).
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
            levels.push_back(static_cast<float>(base::pulseAmplitude(width, kSteps)));
        return levels;
    }
    double bytesPerSecond() const override { return 8e6; } // asynchronous FIFO
    void appendOpening(std::vector<std::uint8_t>&) const override {}
    bool restarts() const override { return false; }
    // The board takes 512 bytes at a time and finds the start of a frame by its bit: after a
    // truncated frame it plays each frame only when the next one has arrived, beginning with the
    // second whole one.
    int silentFields() const override { return 4; }

    // Delays of 0, unlike encoded fields with all off, because a frame with a lost start may take
    // delays for pulse widths.
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
            q[i] = pulseActivation(centre / kSteps, width / double(kSteps));
        }
    }

private:
    static constexpr int kEmitters = 256;
    static constexpr int kSteps = 128;
    static constexpr std::uint8_t kStart = 0x80;

    // trunc(128 asin(A)/pi) with the amplitude A of that level.
    static int widthOf(int duty) { return duty * kSteps / base::kDutyPeriod; }
    static int startOf(int phase, int width)
    {
        return (delaySteps(phase, kSteps) + (kSteps / 2 - width) / 2) % kSteps;
    }
};

std::unique_ptr<BoardCodec> makeCodec()
{
    return std::make_unique<OpenMpd>();
}

std::unique_ptr<ArrayDevice> open(DeviceUri& uri, const DeviceLayout& layout)
{
    return openOnFifo(uri, layout, makeCodec());
}

} // namespace

extern const BoardKind kOpenMpd = {"openmpd",
                                   "openmpd:SERIAL          an open board of 256 behind an FT232H",
                                   Owned::HARDWARE,
                                   makeCodec,
                                   open};

} // namespace midair::device
