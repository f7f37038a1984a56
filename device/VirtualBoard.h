#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::device
{

/// An open board as seen from its serial line, written from what its firmware is known to do and not from our encoder: bytes
/// in, activations out. The peer of the encoders' tests and of `sim:?board=NAME`.
class VirtualBoard
{
public:
    virtual ~VirtualBoard() = default;

    /// Bytes from the host, cut anyhow.
    virtual void receive(const std::uint8_t* bytes, std::size_t count) = 0;
    /// What sounds now.
    virtual std::vector<std::complex<float>> playing() const = 0;
    virtual std::uint64_t swaps() const = 0; ///< fields that began to sound
};

/// "sonicsurface", "ultraino" (with as many chained boards as \a transducers need), "openmpd"; nullptr for any other name.
std::unique_ptr<VirtualBoard> makeVirtualBoard(const std::string& name, int transducers);

} // namespace midair::device
