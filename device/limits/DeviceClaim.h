#pragma once

#include <string>

namespace midair::device
{

class DeviceUri;

/// Makes sure that a device has one owner within this program: while a claim exists, another one
/// for the same hardware or recording throws. `sim:`, `null:` and `play:` may be opened any number
/// of times.
class DeviceClaim
{
public:
    /// \a owner is the name for messages. Throws DeviceError, with the name of the present owner,
    /// if there is one.
    DeviceClaim(const DeviceUri& uri, const std::string& owner);
    ~DeviceClaim();

    DeviceClaim(const DeviceClaim&) = delete;
    DeviceClaim& operator=(const DeviceClaim&) = delete;

private:
    std::string _key; ///< empty: nothing to claim
};

} // namespace midair::device
