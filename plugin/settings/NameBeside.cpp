#include "plugin/settings/NameBeside.h"

#include "engine-bridge/hands/opening/HandOpening.h"

#include <filesystem>

namespace osgMidair
{

std::string nameBeside(const std::string& folder, const std::string& name)
{
    namespace fs = std::filesystem;
    if (name.empty() || fs::path(name).is_absolute()) return name;
    const fs::path beside = fs::path(folder) / name;
    std::error_code ignored;
    return fs::is_regular_file(beside, ignored) ? beside.string() : name;
}

void lookBeside(const std::string& folder, HapticSettings& settings)
{
    settings.array = nameBeside(folder, settings.array);
    settings.temperatureSource = nameBeside(folder, settings.temperatureSource);
    if (auto recorded = midair::bridge::RecordedUri::parse(settings.hands))
    {
        recorded->file = nameBeside(folder, recorded->file);
        settings.hands = recorded->text();
    }
}

} // namespace osgMidair
