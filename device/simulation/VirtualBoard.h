#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::device
{

/// Simulates an open board: bytes in, activations out. Written from the board's published firmware,
/// independently of our encoder. Used by the encoders' tests, the emulated serial boards and
/// `sim:?board=NAME`. Starts in the state after power-up.
class VirtualBoard
{
public:
    virtual ~VirtualBoard() = default;

    /// Receives bytes from the host, split at any place.
    virtual void receive(const std::uint8_t* bytes, std::size_t count) = 0;
    /// Lets time pass without bytes; only boards with a timeout react.
    virtual void rest(double /*seconds*/) {}
    /// Resets the board to its state after power-up, which is full drive for two of the three
    /// boards.
    virtual void powerUp() = 0;
    /// Returns the bytes sent back since the last call.
    virtual std::vector<std::uint8_t> takeAnswer() { return {}; }
    /// Returns the present activations.
    virtual std::vector<std::complex<float>> playing() const = 0;
    virtual std::uint64_t swaps() const = 0; ///< number of fields swapped in so far
    virtual double mostFieldsPerSecond() const
    {
        return 0;
    } ///< the rate that its settings allow; 0: no limit
};

/// Makes "sonicsurface" (256; 512: two stacked boards on one line), "ultraino" (with as many
/// chained boards as \a transducers need) or "openmpd"; nullptr for any other name.
std::unique_ptr<VirtualBoard> makeVirtualBoard(const std::string& name, int transducers);

} // namespace midair::device
