#include "samples/solve/Picture.h"

#include <filesystem>
#include <system_error>

#include <dlfcn.h>

namespace midair::samples
{

std::string drawPicture(const Solution& solution, const std::string& title, const std::string& path)
{
    std::error_code error;
    const std::filesystem::path folder =
        std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
    void* module = nullptr;
    for (const char* place : {"midair-picture.so",
                              "../lib/midair-picture.so",
                              MIDAIR_LIBRARY_FROM_PROGRAM "/osgMidair/midair-picture.so"})
        if (!module && std::filesystem::exists(folder / place, error))
            module = dlopen((folder / place).c_str(), RTLD_NOW | RTLD_LOCAL);
    void* symbol = module ? dlsym(module, "midairDrawPicture") : nullptr;
    if (!symbol)
    {
        const char* why = dlerror();
        return "no picture is drawn: midair-picture.so " +
               (why ? std::string("can't be loaded: ") + why : std::string("isn't there"));
    }
    std::string problem;
    reinterpret_cast<decltype(&midairDrawPicture)>(symbol)(
        solution, title, path, base::instructionSet(), problem);
    return problem;
}

} // namespace midair::samples
