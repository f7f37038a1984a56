#include "tests/plugin/KitTest.h"

#include <osgDB/Registry>

#include <algorithm>

void findPlugins()
{
    static const bool once = []
    {
        osgDB::Registry::instance()->getLibraryFilePathList().push_front(MIDAIR_LIBRARY_FOLDER);
        return true;
    }();
    (void)once;
}

bool says(const osgMidair::HapticScene& scene, const std::string& words)
{
    const auto messages = scene.getStatistics().messages;
    return std::any_of(messages.begin(),
                       messages.end(),
                       [&](const std::string& one)
                       { return one.find(words) != std::string::npos; });
}
