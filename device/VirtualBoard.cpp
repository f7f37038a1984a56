#include "device/VirtualBoard.h"

#include <array>
#include <cmath>
#include <memory>

namespace midair::device
{

namespace
{

// The fundamental of a periodic two-level wave, given as samples over one period, relative to that of a square wave of full
// drive whose pulse starts at 0. e^{+jwt}: a pulse that comes later has a smaller phase.
std::complex<float> fundamental(const std::vector<bool>& period)
{
    const auto n = static_cast<double>(period.size());
    std::complex<double> sum = 0;
    std::complex<double> full = 0;
    for (std::size_t k = 0; k < period.size(); ++k)
    {
        const std::complex<double> turn = std::polar(1.0, -2 * M_PI * static_cast<double>(k) / n);
        if (period[k]) sum += turn;
        if (k < period.size() / 2) full += turn;
    }
    return std::complex<float>(sum / full);
}

class SonicSurfaceBoard : public VirtualBoard
{
public:
    void receive(const std::uint8_t* bytes, std::size_t count) override
    {
        for (; count > 0; --count, ++bytes)
            take(*bytes);
    }

    std::vector<std::complex<float>> playing() const override
    {
        std::vector<std::complex<float>> q(_playing.size());
        for (std::size_t i = 0; i < q.size(); ++i)
        {
            std::vector<bool> period(32, false);
            if (_playing[i] < 32)
                for (int step = 0; step < 16; ++step)
                    period[(_playing[i] + step) % 32] = true;
            q[i] = fundamental(period);
        }
        return q;
    }
    std::uint64_t swaps() const override { return _swaps; }

private:
    void take(std::uint8_t byte)
    {
        if (byte == 254)
            _next = 0;
        else if (byte == 253)
        {
            _playing = _loading;
            ++_swaps;
        }
        else if (byte == 150 || byte == 151 || byte == 192 || byte == 193)
            return;
        else if (_next < _loading.size())
            _loading[_next++] = byte;
    }

    std::array<std::uint8_t, 256> _loading = filled();
    std::array<std::uint8_t, 256> _playing = filled();
    std::size_t _next = 256;
    std::uint64_t _swaps = 0;

    static std::array<std::uint8_t, 256> filled()
    {
        std::array<std::uint8_t, 256> off{};
        off.fill(32);
        return off;
    }
};

// One Arduino of a chain; bytes that aren't for it go to the next.
class UltrainoBoard
{
public:
    void take(std::uint8_t byte)
    {
        if (byte == 0x00)
        {
            std::swap(_loading, _playing);
            _nibble = 0;
            _digit = 0;
            ++swaps;
            forward(byte);
        }
        else if ((byte & 0x0F) == 1)
        {
            if (_nibble < 2 * _loading.size())
            {
                std::uint8_t& target = _loading[_nibble / 2];
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

    void append(std::vector<std::complex<float>>& q) const
    {
        // Channels in the order of the board's 8 x 8 sockets, as bits of the ports A C L B K F H D G J.
        static constexpr int kSockets[64] = {
            51, 52, 53, 54, 28, 29, 30, 31, 47, 46, 45, 44, 43, 42, 41, 40, 56, 57, 58, 59, 48, 49,
            72, 69, 39, 38, 37, 36, 35, 34, 33, 32, 21, 23, 65, 63, 9,  11, 13, 15, 20, 22, 64, 66,
            8,  10, 12, 14, 24, 25, 26, 27, 16, 17, 18, 19, 7,  6,  5,  4,  3,  2,  1,  0};
        const bool onePattern = _durations[0] != 0 && _durations[1] == 0;
        for (const int socket : kSockets)
        {
            std::vector<bool> period(10, false);
            for (int step = 0; step < 10; ++step)
                period[step] =
                    onePattern && ((_playing[10 * step + socket / 8] >> (socket % 8)) & 1) != 0;
            q.push_back(fundamental(period));
        }
    }

    UltrainoBoard* next = nullptr;
    std::uint64_t swaps = 0;

private:
    void forward(std::uint8_t byte)
    {
        if (next != nullptr) next->take(byte);
    }

    std::array<std::uint8_t, 100> _loading{};
    std::array<std::uint8_t, 100> _playing{};
    std::array<std::uint8_t, 32> _durations{1};
    std::array<std::uint8_t, 32> _newDurations{1};
    std::size_t _nibble = 0;
    std::size_t _digit = 0;
};

class UltrainoChain : public VirtualBoard
{
public:
    explicit UltrainoChain(int transducers) : _boards(static_cast<std::size_t>(transducers / 64))
    {
        for (std::size_t i = 0; i + 1 < _boards.size(); ++i)
            _boards[i].next = &_boards[i + 1];
    }
    void receive(const std::uint8_t* bytes, std::size_t count) override
    {
        for (; count > 0; --count, ++bytes)
            _boards.front().take(*bytes);
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

class OpenMpdBoard : public VirtualBoard
{
public:
    void receive(const std::uint8_t* bytes, std::size_t count) override
    {
        for (; count > 0; --count, ++bytes)
        {
            // Only the first byte of a frame and LED and rate bits carry bit 7; the first frame needs it to be found.
            if (_next == 512 && (*bytes & 0x80) == 0) continue;
            if (_next == 512) _next = 0;
            _frame[_next++] = *bytes;
            if (_next == 512)
            {
                _playing = _frame;
                ++_swaps;
            }
        }
    }
    std::vector<std::complex<float>> playing() const override
    {
        std::vector<std::complex<float>> q(256);
        for (int i = 0; i < 256; ++i)
        {
            std::vector<bool> period(128, false);
            for (int step = 0; step < std::min<int>(_playing[256 + i], 128); ++step)
                period[((_playing[i] & 0x7F) + step) % 128] = true;
            q[i] = fundamental(period);
        }
        return q;
    }
    std::uint64_t swaps() const override { return _swaps; }

private:
    std::array<std::uint8_t, 512> _frame{};
    std::array<std::uint8_t, 512> _playing{};
    std::size_t _next = 512;
    std::uint64_t _swaps = 0;
};

} // namespace

std::unique_ptr<VirtualBoard> makeVirtualBoard(const std::string& name, int transducers)
{
    if (name == "sonicsurface") return std::make_unique<SonicSurfaceBoard>();
    if (name == "ultraino") return std::make_unique<UltrainoChain>(transducers);
    if (name == "openmpd") return std::make_unique<OpenMpdBoard>();
    return nullptr;
}

} // namespace midair::device
