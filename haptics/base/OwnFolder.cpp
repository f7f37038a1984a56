#include "haptics/base/OwnFolder.h"

#include <system_error>

#include <dlfcn.h>
#include <link.h>

namespace midair::base
{

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
