#include "device/opening/DeviceRegistry.h"

#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <utility>

namespace midair::device
{

namespace
{

constexpr std::size_t kMostLetters = 32;

struct Registry
{
    base::Mutex mutex;
    std::vector<OwnScheme> schemes MIDAIR_GUARDED_BY(mutex);
    OpenDevice rehearsedAutd3; ///< set before devices are opened
};

Registry& registry()
{
    static Registry all;
    return all;
}

// Letters only: where a list of devices is split, letters and a colon begin the next.
bool isSchemeName(const std::string& name)
{
    return !name.empty() && name.size() <= kMostLetters &&
           std::all_of(name.begin(), name.end(), [](char c) { return c >= 'a' && c <= 'z'; });
}

bool isOneOf(const std::vector<OwnScheme>& registered, const std::string& scheme)
{
    const std::vector<std::string> kits = deviceSchemes();
    return std::find(kits.begin(), kits.end(), scheme) != kits.end() ||
           std::any_of(registered.begin(),
                       registered.end(),
                       [&](const OwnScheme& other) { return other.name == scheme; });
}

} // namespace

bool registerScheme(OwnScheme scheme, std::string& error)
{
    if (!isSchemeName(scheme.name))
        error = "\"" + scheme.name + "\" is no scheme; it must have 1 to 32 small letters";
    else if (!scheme.open)
        error = "the scheme \"" + scheme.name + "\" has nothing that opens it";
    else
    {
        Registry& known = registry();
        const base::Lock lock(known.mutex);
        std::vector<OwnScheme>& all = known.schemes;
        if (!isOneOf(all, scheme.name))
        {
            all.push_back(std::move(scheme));
            return true;
        }
        error = "the scheme \"" + scheme.name + "\" is taken";
    }
    return false;
}

bool isKnownScheme(const std::string& scheme)
{
    return isOneOf(ownSchemes(), scheme);
}

std::vector<OwnScheme> ownSchemes()
{
    Registry& known = registry();
    const base::Lock lock(known.mutex);
    return known.schemes;
}

void setRehearsedAutd3(OpenDevice open)
{
    registry().rehearsedAutd3 = std::move(open);
}

const OpenDevice& rehearsedAutd3()
{
    return registry().rehearsedAutd3;
}

} // namespace midair::device
