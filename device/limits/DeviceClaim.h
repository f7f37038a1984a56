#pragma once

#include <atomic>
#include <memory>
#include <string>

namespace midair::device
{

class DeviceUri;

/// Kind of the path of a device's URI; determines what can have only one owner.
enum class Owned
{
    NOTHING,  ///< any number of owners
    HARDWARE, ///< a device by its serial number or name
    FILE      ///< a file or serial port, including links to it
};

/// Becomes true when nobody waits any more for what a thread opens.
using OpeningIsLeft = std::shared_ptr<const std::atomic<bool>>;

/// Assigns this thread's later claims to the opening of \a isLeft; null: none.
void openFor(OpeningIsLeft isLeft);

/// Ensures that a device has one owner within this program: while a claim exists, another for the
/// same hardware or file throws.
class DeviceClaim
{
public:
    /// \a owner is the name for messages. Throws DeviceError with the present owner's name if there
    /// is one, and says so if that owner is gone but its driver hangs.
    DeviceClaim(const DeviceUri& uri, Owned owned, const std::string& owner);
    ~DeviceClaim();

    DeviceClaim(const DeviceClaim&) = delete;
    DeviceClaim& operator=(const DeviceClaim&) = delete;

private:
    std::string _key; ///< empty: no claim
};

} // namespace midair::device
