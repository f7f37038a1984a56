#include "samples/shared/views/SampleFiles.h"

#include "device/autd3/emulator/RehearsedAutd3.h"

#include <osgDB/FileUtils>

#include <filesystem>
#include <string>
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

osg::ref_ptr<osgText::Font> labelFont()
{
    const std::string file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    osg::ref_ptr<osgText::Font> found;
    if (osgDB::fileExists(file)) found = osgText::readRefFontFile(file);
    return found ? found : osgText::Font::getDefaultFont();
}

void registerEmulatedDevices()
{
    device::registerRehearsedAutd3();
}

} // namespace midair::samples
