#include "samples/views/SampleFiles.h"

#include <osgDB/FileUtils>

#include <filesystem>
#include <system_error>

namespace midair::samples
{

std::string sampleFile(const std::string& name)
{
    std::error_code ignored;
    const std::filesystem::path program =
        std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path();
    const std::filesystem::path installed = program / MIDAIR_SAMPLES_FROM_PROGRAM / name;
    if (std::filesystem::exists(installed, ignored)) return installed.lexically_normal().string();
    const std::string shipped = std::string(MIDAIR_SAMPLES_FOLDER) + "/" + name;
    const std::string found = osgDB::findDataFile(shipped);
    return found.empty() ? shipped : found;
}

} // namespace midair::samples
