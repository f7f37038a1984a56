#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::device
{

/// An open board as seen from its line, written from its published firmware and not from our
/// encoder: bytes in, activations out. The peer of the encoders' tests, of the emulated serial
/// boards and of `sim:?board=NAME`. Starts as after power-up.
class VirtualBoard
{
public:
    virtual ~VirtualBoard() = default;

    /// Bytes from the host, cut anyhow.
    virtual void receive(const std::uint8_t* bytes, std::size_t count) = 0;
    /// Time in which no byte came; only boards that forget something meanwhile care.
    virtual void rest(double /*seconds*/) {}
    /// Forgets all and does what the firmware does first, which with two of the three boards is
    /// full drive.
    virtual void powerUp() = 0;
    /// What it has sent back since.
    virtual std::vector<std::uint8_t> takeAnswer() { return {}; }
    /// What sounds now.
    virtual std::vector<std::complex<float>> playing() const = 0;
    virtual std::uint64_t swaps() const = 0; ///< fields that began to sound
    virtual double mostFieldsPerSecond() const
    {
        return 0;
    } ///< that it takes by its settings; 0: as fast as they come
};

/// "sonicsurface" (256; 512: two stacked boards on one line), "ultraino" (with as many chained
/// boards as \a transducers need), "openmpd"; nullptr for any other name.
std::unique_ptr<VirtualBoard> makeVirtualBoard(const std::string& name, int transducers);

} // namespace midair::device
