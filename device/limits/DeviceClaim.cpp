#include "device/limits/DeviceClaim.h"

#include "device/DeviceUri.h"

#include <filesystem>
#include <map>
#include <mutex>

namespace midair::device
{

namespace
{

/// All claims of this program.
struct Claims
{
    std::mutex mutex;
    std::map<std::string, std::string> owners; ///< by keyOf()
};

Claims& claims()
{
    // Never destroyed: a device that takes long to open may be given up when the program ends.
    static auto* const all = new Claims;
    return *all;
}

std::string keyOf(const DeviceUri& uri, Owned owned)
{
    if (owned == Owned::NOTHING) return {};
    if (owned == Owned::HARDWARE) return uri.scheme() + ":" + uri.path();
    // Links to a file give one key, and so does one port under two schemes.
    std::error_code error;
    const std::filesystem::path file = std::filesystem::weakly_canonical(uri.path(), error);
    return error ? uri.path() : file.string();
}

} // namespace

DeviceClaim::DeviceClaim(const DeviceUri& uri, Owned owned, const std::string& owner) :
    _key(keyOf(uri, owned))
{
    if (_key.empty()) return;
    const std::lock_guard<std::mutex> lock(claims().mutex);
    const auto [place, isFirst] = claims().owners.emplace(_key, owner);
    if (!isFirst) throw uri.error("is driven by " + place->second + "; a device has one owner");
}

DeviceClaim::~DeviceClaim()
{
    if (_key.empty()) return;
    const std::lock_guard<std::mutex> lock(claims().mutex);
    claims().owners.erase(_key);
}

} // namespace midair::device
