#include "device/opening/DeviceRegistry.h"

#include <algorithm>
#include <mutex>
#include <utility>

namespace midair::device
{

namespace
{

constexpr std::size_t kMostLetters = 32;

struct Registry
{
    std::mutex mutex;
    std::vector<OwnScheme> schemes;
    OpenDevice rehearsedAutd3;
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
        const std::lock_guard<std::mutex> lock(registry().mutex);
        std::vector<OwnScheme>& all = registry().schemes;
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
    const std::lock_guard<std::mutex> lock(registry().mutex);
    return registry().schemes;
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
