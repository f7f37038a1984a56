#include "tests/plugin/KitTest.h"

#include <osgDB/Registry>

void findPlugins()
{
    static const bool once = []
    {
        osgDB::Registry::instance()->getLibraryFilePathList().push_front(MIDAIR_LIBRARY_FOLDER);
        return true;
    }();
    (void)once;
}
