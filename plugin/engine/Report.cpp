#include "plugin/engine/Report.h"

#include "haptics/solvers/SolveReport.h"
#include "plugin/settings/EnvironmentVariables.h"

#include <osg/Notify>

#include <fstream>
#include <mutex>
#include <string>

#include <nlohmann/json.hpp>

namespace osgMidair
{

namespace
{

nlohmann::ordered_json surfaceJson(const HapticStatistics& s)
{
    if (s.surface.samples == 0) return nullptr;
    nlohmann::ordered_json json = midair::haptics::toJson(s.figures)["surface"];
    if (s.certifiedGap >= 0.0) json["certifiedGap"] = s.certifiedGap;
    return json;
}

nlohmann::ordered_json fieldJson(const HapticStatistics& s)
{
    nlohmann::ordered_json json = {{"objects", s.objects},
                                   {"stop", s.stop},
                                   {"maxPressure_Pa", s.maxPressure_Pa},
                                   {"fieldsInTurn", s.fieldsInTurn},
                                   {"fieldRate_Hz", s.fieldRate_Hz},
                                   {"outline", s.outline},
                                   {"updatesPerSecond", s.updatesPerSecond}};
    json.update(midair::haptics::toJson(s.figures));
    json.erase("surface"); // stands beside the field
    // The number of points is written even before the first field.
    if (s.figures.empty()) json["points"] = s.points;
    return json;
}

nlohmann::ordered_json countersJson(const HapticStatistics& s)
{
    nlohmann::ordered_json json = {{"frames", s.frames},
                                   {"idleFrames", s.idleFrames},
                                   {"restingFrames", s.restingFrames},
                                   {"meshesRead", s.meshesRead}};
    for (const midair::bridge::CounterRow& row : midair::bridge::kHologramCounters)
        json[row.name] = s.*row.value;
    return json;
}

nlohmann::ordered_json toJson(const HapticStatistics& s, const HapticSettings& settings)
{
    return {{"array", settings.array},
            {"device", settings.device},
            {"deviceStatus", s.device},
            {"counters", countersJson(s)},
            {"hands", {{"known", s.hands}, {"touching", s.touching}}},
            {"field", fieldJson(s)},
            {"surface", surfaceJson(s)},
            {"latency_ms",
             {{"last", s.latency_ms}, {"p50", s.latencyP50_ms}, {"p99", s.latencyP99_ms}}},
            {"collect_ms", s.collect_ms},
            {"messages", s.messages}};
}

} // namespace

std::string reportJson(const HapticStatistics& statistics, const HapticSettings& settings)
{
    return toJson(statistics, settings).dump(2);
}

void writeReport(const HapticStatistics& statistics, const HapticSettings& settings)
{
    const std::string name = Environment::reportFile();
    if (name.empty()) return;
    static std::mutex mutex;
    static nlohmann::ordered_json scenes = nlohmann::ordered_json::array();
    const std::lock_guard<std::mutex> lock(mutex);
    scenes.push_back(toJson(statistics, settings));
    std::ofstream file(name);
    file << nlohmann::ordered_json{{"scenes", scenes}}.dump(2) << '\n';
    if (!file.flush())
        OSG_WARN << "osgMidair: OSG_MIDAIR_REPORT: can't write \"" << name << "\"" << std::endl;
}

} // namespace osgMidair
