#include "device/simulation/VirtualBoard.h"

#include "haptics/base/Units.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>

namespace midair::device
{

namespace
{

// Fundamental of a periodic two-level wave, given as samples over one period, relative to that of a
// square wave of full drive whose pulse starts at 0. With e^{+jwt} a later pulse has a smaller
// phase.
std::complex<float> fundamental(const std::vector<bool>& period)
{
    const auto n = static_cast<double>(period.size());
    std::complex<double> sum = 0;
    std::complex<double> full = 0;
    bool silent = true;
    for (std::size_t k = 0; k < period.size(); ++k)
    {
        const std::complex<double> turn =
            std::polar(1.0, -base::kTwoPi * static_cast<double>(k) / n);
        if (period[k]) sum += turn;
        if (k < period.size() / 2) full += turn;
        silent = silent && period[k] == period[0]; // constantly on is silent too
    }
    return silent ? std::complex<float>(0) : std::complex<float>(sum / full);
}

/// One of up to two SonicSurface boards on a line. Source: upnalab/SonicSurface, Firmware, "FPGA
/// primary" and "FPGA secondary", Distribute.vhd and PhaseLine.vhd, without the phase correction,
/// which each board has for its own emitters.
class SonicSurfaceFpga
{
public:
    explicit SonicSurfaceFpga(std::uint8_t chooses) : _chooses(chooses) {}

    bool take(std::uint8_t byte) ///< returns true if it swapped
    {
        if (byte == 254 && _enabled)
            _counter = 0;
        else if (byte ==
                 253) // also if the other board is chosen; PhaseLine exchanges its two registers
        {
            std::swap(_current, _previous);
            _counter = 0;
            return true;
        }
        else if (byte == 150 || byte == 151)
            _clocks = byte == 151;
        else if (byte == 192 || byte == 193)
            _enabled = byte == _chooses;
        else if (_enabled) // 251 and 252 too
        {
            // The counter has more bits than the address, which therefore wraps after 256. Values
            // other than 32 are cut to 5 bits.
            _previous[_counter % kEmitters] = byte == 32 ? 32 : (byte & 31);
            ++_counter;
        }
        return false;
    }

    void append(std::vector<std::complex<float>>& q) const
    {
        for (const std::uint8_t phase : _current)
        {
            std::vector<bool> period(32, false);
            if (phase < 32 && _clocks) // the counter never reaches 32
                for (int step = 0; step < 16; ++step)
                    period[(phase + step) % 32] = true;
            q.push_back(fundamental(period));
        }
    }

private:
    static constexpr std::size_t kEmitters = 256;

    std::uint8_t _chooses;
    bool _enabled = true;
    bool _clocks = true;
    std::size_t _counter = 0;
    std::array<std::uint8_t, kEmitters> _current{};  // at power-up all on with delay 0 ..
    std::array<std::uint8_t, kEmitters> _previous{}; // .. in both
};

/// One SonicSurface board, or two stacked ones, on one line.
class SonicSurfaceBoard : public VirtualBoard
{
public:
    explicit SonicSurfaceBoard(int transducers) : _count(transducers / 256)
    {
        SonicSurfaceBoard::powerUp();
    }

    void receive(const std::uint8_t* bytes, std::size_t count) override
    {
        for (; count > 0; --count, ++bytes)
        {
            bool swapped = false;
            for (SonicSurfaceFpga& board : _boards)
                swapped = board.take(*bytes);
            _swaps += swapped ? 1 : 0;
        }
    }
    void powerUp() override
    {
        _boards.clear();
        for (int i = 0; i < _count; ++i)
            _boards.emplace_back(static_cast<std::uint8_t>(192 + i));
    }
    std::vector<std::complex<float>> playing() const override
    {
        std::vector<std::complex<float>> q;
        for (const SonicSurfaceFpga& board : _boards)
            board.append(q);
        return q;
    }
    std::uint64_t swaps() const override { return _swaps; }

private:
    const int _count;
    std::vector<SonicSurfaceFpga> _boards;
    std::uint64_t _swaps = 0;
};

/// One Arduino of a chain; forwards bytes for other boards to the next. Source:
/// asiermarzo/Ultraino, DriverMEGA.ino.
class UltrainoBoard
{
public:
    // At power-up all ports are on in the first half of the period.
    UltrainoBoard() { std::fill_n(_emitting.begin(), kPattern / 2, std::uint8_t(0xFF)); }

    void take(std::uint8_t byte)
    {
        if (byte == 0x00)
        {
            std::swap(_reading, _emitting);
            _nibble = 0;
            _digit = 0;
            ++swaps;
            forward(byte);
        }
        else if ((byte & 0x0F) == 1)
        {
            if (_nibble / 2 < _reading.size()) // the sketch writes beyond the end instead
            {
                std::uint8_t& target = _reading[_nibble / 2];
                target = _nibble % 2 == 0 ? (byte & 0xF0)
                                          : static_cast<std::uint8_t>(target | (byte >> 4));
                ++_nibble;
            }
        }
        else if ((byte & 0x3F) == 0x30)
        {
            std::uint8_t& target = _newDurations[_digit / 4 % _newDurations.size()];
            target = static_cast<std::uint8_t>((_digit % 4 == 0 ? 0 : target) |
                                               ((byte & 0xC0) >> (_digit % 4 * 2)));
            ++_digit;
            forward(byte);
        }
        else if (byte == 0x10)
        {
            _durations = _newDurations;
            _digit = 0;
            forward(byte);
        }
        else
            forward(static_cast<std::uint8_t>(byte - 1));
    }

    // For a list of patterns in turn, takes the loudest activation of each channel, so that the
    // list doesn't count as silent.
    void append(std::vector<std::complex<float>>& q) const
    {
        // Channels in the order of the board's 8 x 8 sockets, as bits of the ports A C L B K F H D
        // G J.
        static constexpr int kSockets[64] = {
            51, 52, 53, 54, 28, 29, 30, 31, 47, 46, 45, 44, 43, 42, 41, 40, 56, 57, 58, 59, 48, 49,
            72, 69, 39, 38, 37, 36, 35, 34, 33, 32, 21, 23, 65, 63, 9,  11, 13, 15, 20, 22, 64, 66,
            8,  10, 12, 14, 24, 25, 26, 27, 16, 17, 18, 19, 7,  6,  5,  4,  3,  2,  1,  0};
        for (const int socket : kSockets)
        {
            std::complex<float> loudest = 0;
            for (std::size_t i = 0; i < _durations.size() && (i == 0 || _durations[i] != 0); ++i)
            {
                const std::complex<float> one = sounds(i, socket);
                if (std::abs(one) > std::abs(loudest)) loudest = one;
            }
            q.push_back(loudest);
        }
    }

    UltrainoBoard* next = nullptr;
    std::uint64_t swaps = 0;
    std::vector<std::uint8_t> forwarded;

private:
    static constexpr std::size_t kPattern = 100; ///< bytes: 10 steps of 10 ports
    static constexpr std::size_t kPatterns = 32;

    std::complex<float> sounds(std::size_t pattern, int socket) const
    {
        std::vector<bool> period(10, false);
        for (std::size_t step = 0; step < 10; ++step)
            period[step] = ((_emitting[pattern * kPattern + 10 * step +
                                       static_cast<std::size_t>(socket) / 8] >>
                             (socket % 8)) &
                            1) != 0;
        return fundamental(period);
    }
    void forward(std::uint8_t byte)
    {
        forwarded.push_back(byte);
        if (next != nullptr) next->take(byte);
    }

    std::array<std::uint8_t, kPatterns * kPattern> _reading{};
    std::array<std::uint8_t, kPatterns * kPattern> _emitting{};
    std::array<std::uint8_t, kPatterns> _durations{1};
    std::array<std::uint8_t, kPatterns> _newDurations{1};
    std::size_t _nibble = 0;
    std::size_t _digit = 0;
};

/// A chain of Ultraino boards; the first is wired to the computer.
class UltrainoChain : public VirtualBoard
{
public:
    explicit UltrainoChain(int transducers) : _boards(static_cast<std::size_t>(transducers / 64))
    {
        UltrainoChain::powerUp();
    }
    void receive(const std::uint8_t* bytes, std::size_t count) override
    {
        for (; count > 0; --count, ++bytes)
            _boards.front().take(*bytes);
        for (std::size_t i = 1; i < _boards.size(); ++i)
            _boards[i].forwarded.clear(); // only the first is wired to the computer
    }
    std::vector<std::uint8_t> takeAnswer() override
    {
        return std::exchange(_boards.front().forwarded, {});
    }
    void powerUp() override
    {
        std::fill(_boards.begin(), _boards.end(), UltrainoBoard());
        for (std::size_t i = 0; i + 1 < _boards.size(); ++i)
            _boards[i].next = &_boards[i + 1];
    }
    std::vector<std::complex<float>> playing() const override
    {
        std::vector<std::complex<float>> q;
        for (const UltrainoBoard& board : _boards)
            board.append(q);
        return q;
    }
    std::uint64_t swaps() const override { return _boards.back().swaps; }

private:
    std::vector<UltrainoBoard> _boards;
};

/// An OpenMPD board. Takes 512 bytes at a time out of its FIFO, whatever they are; a byte with bit
/// 7 set starts a frame, and the next 511 bytes complete it. Source: RMResearch/OpenMPD_Hardware,
/// FPGA_3.4.2, FrameBufferController.vhd, CommandReader.vhd and MuxPhase.vhd.
class OpenMpdBoard : public VirtualBoard
{
public:
    void receive(const std::uint8_t* bytes, std::size_t count) override
    {
        _fifo.insert(_fifo.end(), bytes, bytes + count);
        while (_fifo.size() >= kFrame)
        {
            for (std::size_t i = 0; i < kFrame; ++i)
                take(_fifo[i]);
            _fifo.erase(_fifo.begin(), _fifo.begin() + kFrame);
        }
    }
    // A partial frame is dropped after a second without bytes.
    void rest(double seconds) override
    {
        if (seconds >= 1) _fifo.clear();
    }
    void powerUp() override { *this = OpenMpdBoard(); }
    std::vector<std::complex<float>> playing() const override
    {
        std::vector<std::complex<float>> q(256);
        for (std::size_t i = 0; i < q.size(); ++i)
        {
            std::vector<bool> period(128, false);
            for (int step = 0; step < (_playing[256 + i] & 0x7F); ++step)
                period[((_playing[i] & 0x7F) + step) % 128] = true;
            q[i] = fundamental(period);
        }
        return q;
    }
    std::uint64_t swaps() const override { return _swaps; }
    double mostFieldsPerSecond() const override
    {
        return 40000.0 / (_divider == 0 ? 256 : _divider);
    }

private:
    static constexpr std::ptrdiff_t kFrame = 512;

    void take(std::uint8_t byte)
    {
        if (_next == 0 && (byte & 0x80) == 0) return;
        _frame[_next] = byte;
        if (_next >= 26 && _next < 34)
            _newDivider = static_cast<std::uint8_t>((_newDivider & ~(1 << (_next - 26))) |
                                                    (byte >> 7) << (_next - 26));
        if (_next == 34 && (byte & 0x80) != 0) _divider = _newDivider;
        if (++_next < _frame.size()) return;
        _next = 0;
        _playing = _frame;
        ++_swaps;
    }

    std::deque<std::uint8_t> _fifo;
    std::array<std::uint8_t, kFrame> _frame{};
    std::array<std::uint8_t, kFrame> _playing{}; // silent at power-up
    std::size_t _next = 0;
    std::uint8_t _divider = 4;
    std::uint8_t _newDivider = 0;
    std::uint64_t _swaps = 0;
};

} // namespace

std::unique_ptr<VirtualBoard> makeVirtualBoard(const std::string& name, int transducers)
{
    if (name == "sonicsurface") return std::make_unique<SonicSurfaceBoard>(transducers);
    if (name == "ultraino") return std::make_unique<UltrainoChain>(transducers);
    if (name == "openmpd") return std::make_unique<OpenMpdBoard>();
    return nullptr;
}

} // namespace midair::device
