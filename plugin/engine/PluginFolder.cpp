// Tells OSG where the kit's own plugins are: beside this library, wherever it was installed or
// moved to. Without it, scene files of a kit in a private prefix need OSG_LIBRARY_PATH.

#include "haptics/base/UserEnvironment.h"

#include <osgDB/Registry>

namespace osgMidair
{

namespace
{

bool addOwnFolder()
{
    const std::string folder = midair::base::ownFolder().string();
    // First, so that the plugins of another version, in the system's folders, are not taken.
    if (!folder.empty()) osgDB::Registry::instance()->getLibraryFilePathList().push_front(folder);
    return true;
}

[[maybe_unused]] const bool kIsAdded = addOwnFolder();

} // namespace

} // namespace osgMidair
