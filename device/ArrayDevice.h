#pragma once

#include "device/DriveSignal.h"

#include <complex>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace midair::device
{

/// Thrown when a device can't be opened or a URI can't be read: what() names the URI and what would be right.
class DeviceError : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// How the transducers are spread over the hardware; the caller knows it from the array file.
struct DeviceLayout
{
    int transducers = 0;
    std::vector<int> board; ///< transducers long, ascending from 0; empty: one board
};

/// A phased array that plays one field until the next replaces it whole. send() never blocks on the hardware.
class ArrayDevice
{
public:
    virtual ~ArrayDevice() = default; ///< silences the array

    /// Replaces the field as a whole, or not at all: false when refused (wrong length, muted, device lost), see status().
    virtual bool send(const DriveSignal& signal) = 0;

    /// All transducers off, at once; from any thread.
    virtual void silence() = 0;

    /// One line: what the device is and how it fares.
    virtual std::string status() const = 0;

    /// What the array plays now, as activations (m): quantised, limited, zero when silent. Measured, by `sim:`; else as sent.
    virtual std::vector<std::complex<float>> played() const = 0;
};

/// `sim:`, `record:FILE`, `null:`, .. ; throws DeviceError.
std::unique_ptr<ArrayDevice> openDevice(const std::string& uri, const DeviceLayout& layout);

} // namespace midair::device
