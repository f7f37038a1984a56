#include "haptics/base/UserEnvironment.h"

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <map>
#include <system_error>

#include <dlfcn.h>
#include <link.h>
#include <unistd.h>

namespace midair::base
{

namespace
{

std::atomic<bool> trusted{false};

/// Reads the variables that the kernel stored at program start; setenv() does not change them.
std::map<std::string, std::string> readBeginning()
{
    std::map<std::string, std::string> all;
    std::ifstream file("/proc/self/environ", std::ios::binary);
    for (std::string entry; std::getline(file, entry, '\0');)
    {
        const std::size_t equals = entry.find('=');
        if (equals != std::string::npos)
            all.emplace(entry.substr(0, equals), entry.substr(equals + 1));
    }
    return all;
}

} // namespace

std::optional<std::string> userVariable(const std::string& name)
{
    if (trusted) return variableNow(name);
    static const std::map<std::string, std::string> beginning = readBeginning();
    const auto found = beginning.find(name);
    if (found == beginning.end()) return std::nullopt;
    return found->second;
}

std::optional<std::string> variableNow(const std::string& name)
{
    // NOLINTNEXTLINE(concurrency-mt-unsafe): OSG itself reads it so
    const char* value = std::getenv(name.c_str());
    if (value == nullptr) return std::nullopt;
    return value;
}

std::vector<std::string> variablesNow(const std::string& prefix)
{
    std::vector<std::string> names;
    for (char** entry = environ; entry != nullptr && *entry != nullptr; ++entry)
    {
        const std::string text = *entry;
        if (text.rfind(prefix, 0) == 0)
            names.push_back(text.substr(prefix.size(), text.find('=') - prefix.size()));
    }
    return names;
}

// Only tests declare and call it (tests/TrustedVariables.h): in a program it would treat variables
// set by scene files as the user's.
void trustVariablesOfProgram();
void trustVariablesOfProgram()
{
    trusted = true;
}

std::filesystem::path ownFolder()
{
    static const int here = 0;
    Dl_info info{};
    void* found = nullptr;
    std::filesystem::path file = "/proc/self/exe";
    // The loader has no name for the program itself.
    if (dladdr1(&here, &info, &found, RTLD_DL_LINKMAP) != 0 && found != nullptr)
        if (const char* name = static_cast<const link_map*>(found)->l_name; name && *name)
            file = name;
    std::error_code error;
    file = std::filesystem::canonical(file, error);
    return error ? std::filesystem::path() : file.parent_path();
}

} // namespace midair::base
