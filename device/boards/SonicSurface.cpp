#include "device/boards/BoardKind.h"
#include "haptics/base/DutyLaw.h"

namespace midair::device
{

namespace
{

/// 16 x 16 emitters on a serial port of 230400 baud: 254, 256 delays of 1/32 period (32: off), 253
/// to exchange two buffers. 151 switches the emitters' clocks on; 192 and 193 choose which of two
/// stacked boards takes fields. They go before 254, since the design for tactile modulation knows
/// none of the three and takes them for delays, which 254 then overwrites. Source: the board's
/// published FPGA design and host program (S. Freire, A. Marzo, "SonicSurface", Distribute.vhd).
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
    int sequenceFields() const override { return 2; }
    // 253 exchanges the two buffers and copies nothing (PhaseLine.vhd). 254 only sets the number of
    // the next emitter back to 0, in all three designs, which 253 does as well.
    const Swap* swap() const override
    {
        static constexpr Swap kSwap = {253, 254};
        return &kSwap;
    }

    // A board stacked on ours may still play a field of another program. Ours comes first, because
    // every swap of buffers swaps both boards.
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
                       ? pulseActivation(delaySteps(signal.phase[i], kSteps) / double(kSteps), 0.5)
                       : std::complex<float>(0);
    }

private:
    static constexpr int kEmitters = 256;
    static constexpr int kSteps = 32;
    static constexpr std::uint8_t kClocksOn = 151;
    static constexpr std::uint8_t kPrimary = 192;
    static constexpr std::uint8_t kSecondary = 193;

    // From amplitude 1/2 up, on (1) is nearer than off (0).
    static bool on(int duty) { return duty >= base::kDutyPeriod / 6; }
};

std::unique_ptr<BoardCodec> makeCodec()
{
    return std::make_unique<SonicSurface>();
}

std::unique_ptr<ArrayDevice> open(DeviceUri& uri, const DeviceLayout& layout)
{
    return openOnSerialPort(uri, layout, makeCodec(), {230400, 0});
}

} // namespace

extern const BoardKind kSonicSurface = {
    "sonicsurface",
    "sonicsurface:TTY        an open board of 256 on a serial port",
    Owned::FILE,
    makeCodec,
    open};

} // namespace midair::device
