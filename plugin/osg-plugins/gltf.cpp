// OSG loads this for file names ending with .gltf or .glb if there is no other plugin: osgdb_gltf
// and osgdb_glb. Another one on OSG's library path replaces it.

#include <osgMidair/FileFormats>

#include <osgDB/Registry>

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>

#include <dlfcn.h>

namespace
{

namespace fs = std::filesystem;

/// The file of this module.
fs::path ownFile()
{
    Dl_info info{};
    std::error_code error;
    if (dladdr(reinterpret_cast<void*>(&ownFile), &info) == 0 || !info.dli_fname) return {};
    return fs::canonical(info.dli_fname, error);
}

/// Returns another plugin for the same files; empty if there is none.
std::string otherPlugin()
{
    const fs::path own = ownFile();
    const std::string name =
        osgDB::Registry::instance()->createLibraryNameForExtension(MIDAIR_EXTENSION);
    for (const std::string& folder : osgDB::Registry::instance()->getLibraryFilePathList())
        for (const fs::path& place :
             {fs::path(folder) / name, fs::path(folder) / fs::path(name).filename()})
        {
            std::error_code error;
            const fs::path file = fs::canonical(place, error);
            if (error || file == own) continue;
            return file.string();
        }
    return {};
}

bool isRead()
{
    const osgDB::Registry::ReaderWriterList& all =
        osgDB::Registry::instance()->getReaderWriterList();
    return std::any_of(all.begin(),
                       all.end(),
                       [](const auto& one) { return one->acceptsExtension(MIDAIR_EXTENSION); });
}

// The other one may be the kit's from another build, which finds this one and also steps aside.
bool registerOrStepAside()
{
    const std::string other = otherPlugin();
    if (!other.empty()) osgDB::Registry::instance()->loadLibrary(other);
    if (!isRead()) osgMidair::registerGltf();
    return true;
}

[[maybe_unused]] const bool kIsRegistered = registerOrStepAside();

} // namespace
