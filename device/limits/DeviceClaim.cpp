#include "device/limits/DeviceClaim.h"

#include "device/DeviceUri.h"
#include "haptics/base/threads/Mutex.h"

#include <filesystem>
#include <map>
#include <utility>

namespace midair::device
{

namespace
{

struct Owner
{
    std::string name;
    OpeningIsLeft isLeft; ///< of the opening that made the claim; null: of none
};

/// All claims of this program.
struct Claims
{
    base::Mutex mutex;
    std::map<std::string, Owner> owners MIDAIR_GUARDED_BY(mutex); ///< by keyOf()
};

Claims& claims()
{
    // Never destroyed: an opening that takes long may be abandoned when the program ends.
    static auto* const all = new Claims;
    return *all;
}

OpeningIsLeft& openingOfThread()
{
    static thread_local OpeningIsLeft isLeft;
    return isLeft;
}

std::string keyOf(const DeviceUri& uri, Owned owned)
{
    if (owned == Owned::NOTHING) return {};
    if (owned == Owned::HARDWARE) // an empty path is identified by its scheme
        return uri.scheme() + ":" + uri.path() + uri.value("interface") + uri.value("group");
    // Links to a file give the same key, and so does a port under two schemes.
    std::error_code error;
    const std::filesystem::path file = std::filesystem::weakly_canonical(uri.path(), error);
    return error ? uri.path() : file.string();
}

} // namespace

void openFor(OpeningIsLeft isLeft)
{
    openingOfThread() = std::move(isLeft);
}

DeviceClaim::DeviceClaim(const DeviceUri& uri, Owned owned, const std::string& owner) :
    _key(keyOf(uri, owned))
{
    if (_key.empty()) return;
    Claims& all = claims();
    const base::Lock lock(all.mutex);
    const auto [place, isFirst] = all.owners.emplace(_key, Owner{owner, openingOfThread()});
    if (isFirst) return;
    const Owner& present = place->second;
    if (present.isLeft && *present.isLeft)
        throw uri.error("was given up by " + present.name +
                        " while it was opened, and its driver still hangs; it can be opened once "
                        "the driver has returned");
    throw uri.error("is driven by " + present.name + "; a device has one owner");
}

DeviceClaim::~DeviceClaim()
{
    if (_key.empty()) return;
    Claims& all = claims();
    const base::Lock lock(all.mutex);
    all.owners.erase(_key);
}

} // namespace midair::device
