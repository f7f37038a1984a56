#pragma once

#include <atomic>
#include <memory>
#include <string>

namespace midair::device
{

class DeviceUri;

/// What the path of a device's URI names, and so what can have one owner only.
enum class Owned
{
    NOTHING,  ///< any number of owners
    HARDWARE, ///< a device by its serial number or name
    FILE      ///< a file or serial port, links to it included
};

/// Becomes true when nobody waits any more for what a thread opens.
using OpeningIsLeft = std::shared_ptr<const std::atomic<bool>>;

/// Claims that this thread makes from now on are those of an opening that \a isLeft tells about;
/// null: none.
void openFor(OpeningIsLeft isLeft);

/// Makes sure that a device has one owner within this program: while a claim exists, another one
/// for the same hardware or file throws.
class DeviceClaim
{
public:
    /// \a owner is the name for messages. Throws DeviceError, with the name of the present owner,
    /// if there is one; if that one has gone and its driver alone hangs, it says so.
    DeviceClaim(const DeviceUri& uri, Owned owned, const std::string& owner);
    ~DeviceClaim();

    DeviceClaim(const DeviceClaim&) = delete;
    DeviceClaim& operator=(const DeviceClaim&) = delete;

private:
    std::string _key; ///< empty: nothing to claim
};

} // namespace midair::device
