#pragma once

#include <string>

namespace midair::device
{

class DeviceUri;

/// One owner a device within this program: as long as a claim lives no other for the same hardware
/// or the same recording can be made. `sim:`, `null:` and `play:` are as many as one likes.
class DeviceClaim
{
public:
    /// \a owner: who drives it, for messages. Throws DeviceError naming the owner who has it.
    DeviceClaim(const DeviceUri& uri, const std::string& owner);
    ~DeviceClaim();

    DeviceClaim(const DeviceClaim&) = delete;
    DeviceClaim& operator=(const DeviceClaim&) = delete;

private:
    std::string _key; ///< empty: nothing to claim
};

} // namespace midair::device
