#include "plugin/report/Report.h"

#include "device/DeviceLog.h"
#include "haptics/base/threads/Forks.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/solvers/SolveReport.h"
#include "plugin/settings/Grants.h"
#include "plugin/settings/UserOptions.h"

#include <osg/Notify>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <thread>
#include <utility>
#include <vector>

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
                                   {"feeling", s.feeling},
                                   {"maxPressure_Pa", s.maxPressure_Pa},
                                   {"fieldsInTurn", s.fieldsInTurn},
                                   {"fieldRate_Hz", s.fieldRate_Hz},
                                   {"outline", s.outline},
                                   {"updatesPerSecond", s.updatesPerSecond}};
    json.update(midair::haptics::toJson(s.figures));
    json.erase("surface"); // it is beside the field
    // The number of points is written even before the first field.
    if (s.figures.empty()) json["points"] = s.points;
    return json;
}

nlohmann::ordered_json fieldsJson(const ArrayFields& fields)
{
    nlohmann::ordered_json json;
    for (const ArrayFieldsRow& row : kArrayFields)
        json[row.name] = fields.*row.value;
    return json;
}

nlohmann::ordered_json exposureJson(const HapticStatistics& s)
{
    nlohmann::ordered_json json = {{"what", midair::haptics::kExposureMeaning}};
    for (const midair::haptics::ExposureRow& row : midair::haptics::kExposureFigures)
        std::visit([&](auto member) { json[row.name] = s.exposure.*member; }, row.value);
    return json;
}

/// "unknown": with the reason; "none": the object has no such error.
nlohmann::ordered_json coincidenceJson(const HapticStatistics& s)
{
    using midair::bridge::CoincidencePart;
    const auto partJson = [](const CoincidencePart& part) -> nlohmann::ordered_json
    {
        if (part.state == CoincidencePart::NONE) return "none";
        if (part.state == CoincidencePart::UNKNOWN) return "unknown";
        return {{"median_mm", part.median_mm}, {"p95_mm", part.most_mm}};
    };
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (const midair::bridge::CoincidenceFigures& one : s.coincidence)
    {
        nlohmann::ordered_json object = {{"path", printable(one.object)},
                                         {"total", partJson(one.total)},
                                         {"largest", one.largest},
                                         {"unknown", one.unknown}};
        for (const midair::bridge::CoincidenceRow& row : midair::bridge::kCoincidenceParts)
            object["parts"][row.name] = partJson(one.*row.part);
        json.push_back(std::move(object));
    }
    return json;
}

nlohmann::ordered_json countersJson(const HapticStatistics& s)
{
    nlohmann::ordered_json json = {{"frames", s.frames},
                                   {"idleFrames", s.idleFrames},
                                   {"restingFrames", s.restingFrames},
                                   {"processed", s.processed},
                                   {"meshesRead", s.meshesRead},
                                   {"objectsBeingRead", s.objectsBeingRead}};
    for (const midair::bridge::CounterRow& row : midair::bridge::kHologramCounters)
        json[row.name] = s.*row.value;
    return json;
}

/// Returns object \a index of \a field with its control points. Pressures are of the newest field.
nlohmann::ordered_json objectJson(const HapticField& field, std::size_t index)
{
    const HapticField::Object& object = field.getObjects()[index];
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    double lowest_Pa = 0.0;
    double highest_Pa = 0.0;
    double sum_Pa = 0.0;
    for (const HapticField::ControlPoint& point : field.getPoints())
    {
        if (point.object != index) continue;
        const double got_Pa = point.achieved_Pa;
        lowest_Pa = rows.empty() ? got_Pa : std::min(lowest_Pa, got_Pa);
        highest_Pa = std::max(highest_Pa, got_Pa);
        sum_Pa += got_Pa;
        rows.push_back({point.position.x(),
                        point.position.y(),
                        point.position.z(),
                        point.wanted_Pa,
                        point.achieved_Pa});
    }
    const std::size_t count = rows.size();
    return {
        {"path", printable(object.path)},
        {"points", count},
        {"lowest_Pa", lowest_Pa},
        {"mean_Pa", count > 0 ? sum_Pa / static_cast<double>(count) : 0.0},
        {"highest_Pa", highest_Pa},
        {"unreachable", object.isUnreachable},
        {"leftOut",
         {{"outOfWorkspace", object.outOfWorkspace},
          {"overBudget", object.overBudget},
          {"crowded", object.crowded},
          {"unpainted", object.unpainted},
          {"invalid", object.invalid},
          {"outOfReach", object.outOfReach}}},
        {"controlPoints",
         {{"columns", {"x", "y", "z", "wanted_Pa", "achieved_Pa"}}, {"rows", std::move(rows)}}}};
}

nlohmann::ordered_json objectsJson(const HapticField* field)
{
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (std::size_t i = 0; field && i < field->getObjects().size(); ++i)
        json.push_back(objectJson(*field, i));
    return json;
}

nlohmann::ordered_json
toJson(const HapticStatistics& s, const HapticSettings& settings, const HapticField* field)
{
    return {
        {"array", settings.array},
        {"device", settings.device},
        {"deviceStatus", s.device},
        {"state", midair::bridge::stateName(s.state)},
        {"fields", fieldsJson(s.fields)},
        {"counters", countersJson(s)},
        {"head", {{"tracked", s.headTracked}, {"status", s.head}}},
        {"hands", {{"known", s.hands}, {"touching", s.touching}, {"predicted_ms", s.predicted_ms}}},
        {"field", fieldJson(s)},
        {"surface", surfaceJson(s)},
        {"exposure", exposureJson(s)},
        {"coincidence", coincidenceJson(s)},
        {"latency_ms",
         {{"last", s.latency_ms}, {"p50", s.latencyP50_ms}, {"p99", s.latencyP99_ms}}},
        {"collect_ms", s.collect_ms},
        {"objects", objectsJson(field)},
        {"messages", s.messages}};
}

nlohmann::ordered_json toJson(const ReportedScene& scene)
{
    return toJson(scene.statistics, scene.settings, scene.field);
}

/// The process's report file. Never deleted, because scenes may end during the process's exit; its
/// thread runs while scenes play.
class ReportFile
{
public:
    static ReportFile& instance()
    {
        static auto* const file = new midair::base::OfProcess<ReportFile>(
            [](bool isFirst) { return std::make_unique<ReportFile>(isFirst); });
        return **file;
    }

    /// \a isWritten false: in the child of a fork, whose parent writes the file.
    explicit ReportFile(bool isWritten) : _isOthers(!isWritten) {}

    bool isDue(const void* scene)
    {
        if (_isOthers) return false;
        const double now_s = midair::base::steadySeconds();
        const midair::base::Lock lock(_mutex);
        const auto known = _live.find(scene);
        return known == _live.end() || now_s - known->second.time_s >= kInterval_s;
    }

    void keep(const void* scene, ReportedScene now)
    {
        const midair::base::Lock lock(_mutex);
        _live[scene] = {std::move(now), midair::base::steadySeconds()};
        _isFresh = true;
        if (!_thread.joinable()) _thread = std::thread([this, number = _number] { run(number); });
        _changed.notifyOne();
    }

    void end(const void* scene, const ReportedScene& last)
    {
        std::thread ended;
        {
            const midair::base::Lock lock(_mutex);
            _live.erase(scene);
            _ended.push_back(toJson(last));
            if (_live.empty())
            {
                ended.swap(_thread);
                ++_number;
            }
            _changed.notifyAll();
        }
        if (ended.joinable()) ended.join();
        write();
    }

private:
    struct Live
    {
        ReportedScene scene;
        double time_s = 0.0; ///< steady clock, when it was stored
    };

    static constexpr double kInterval_s = 1.0;

    void run(unsigned int number)
    {
        midair::base::Lock lock(_mutex);
        for (;;)
        {
            while (!_isFresh && number == _number)
                _changed.wait(lock);
            if (number != _number) return;
            _isFresh = false;
            const midair::base::Unlocked unlocked(_mutex);
            write();
        }
    }

    /// Writes a new file and replaces the old one with it.
    void write()
    {
        const midair::base::Lock writing(_writing);
        const std::string name = Environment::reportFile();
        if (name.empty() || _isOthers) return;
        std::map<const void*, Live> live;
        nlohmann::ordered_json scenes;
        {
            const midair::base::Lock lock(_mutex);
            live = _live;
            scenes = _ended;
        }
        for (const auto& [key, one] : live)
            scenes.push_back(toJson(one.scene));
        // Special files (/dev/stdout, a pipe) can't be replaced.
        std::error_code error;
        const auto kind = std::filesystem::status(name, error).type();
        const bool isReplaced = kind == std::filesystem::file_type::regular ||
                                kind == std::filesystem::file_type::not_found;
        if (!isReplaced && !live.empty()) return;
        const std::string fresh = isReplaced ? name + ".new" : name;
        std::ofstream file(fresh);
        file << nlohmann::ordered_json{{"scenes", scenes}}.dump(
                    2, ' ', false, nlohmann::json::error_handler_t::replace)
             << '\n';
        bool isWritten = static_cast<bool>(file.flush());
        file.close();
        if (isReplaced && isWritten) std::filesystem::rename(fresh, name, error);
        isWritten = isWritten && !error;
        if (!isWritten && !_isWarned)
            OSG_WARN << "osgMidair: OSG_MIDAIR_REPORT: can't write \"" << name << "\"" << std::endl;
        _isWarned = _isWarned || !isWritten;
    }

    const bool _isOthers;
    midair::base::Mutex _writing; ///< held while the file is written; taken before _mutex
    bool _isWarned MIDAIR_GUARDED_BY(_writing) = false;
    midair::base::Mutex _mutex;
    midair::base::Condition _changed;
    std::map<const void*, Live> _live MIDAIR_GUARDED_BY(_mutex);
    nlohmann::ordered_json _ended MIDAIR_GUARDED_BY(_mutex) = nlohmann::ordered_json::array();
    bool _isFresh MIDAIR_GUARDED_BY(_mutex) = false;
    std::thread _thread MIDAIR_GUARDED_BY(_mutex);
    /// the thread's number; threads with lower numbers end
    unsigned int _number MIDAIR_GUARDED_BY(_mutex) = 0;
};

constexpr std::size_t kMost = 1000; // limit on waiting lines, if no scene is updated any more

struct Lines
{
    midair::base::Mutex mutex;
    std::vector<std::pair<bool, std::string>> waiting MIDAIR_GUARDED_BY(mutex);
};

// Never destroyed: devices may be closed while the program ends.
Lines& lines()
{
    static auto* const all = new Lines;
    return *all;
}

} // namespace

std::string reportJson(const HapticStatistics& statistics,
                       const HapticSettings& settings,
                       const HapticField* field)
{
    return toJson(statistics, settings, field).dump(2);
}

bool isReportDue(const void* scene)
{
    static const bool isWanted = !Environment::reportFile().empty();
    return isWanted && ReportFile::instance().isDue(scene);
}

void keepReport(const void* scene, ReportedScene now)
{
    ReportFile::instance().keep(scene, std::move(now));
}

void writeReport(const void* scene, const ReportedScene& last)
{
    if (!Environment::reportFile().empty()) ReportFile::instance().end(scene, last);
}

void collectDeviceLines()
{
    static const bool once = []
    {
        midair::device::sendDeviceLogTo(
            [](bool isWarning, const std::string& line)
            {
                const midair::base::Lock lock(lines().mutex);
                if (lines().waiting.size() < kMost) lines().waiting.emplace_back(isWarning, line);
            });
        return true;
    }();
    (void)once;
}

void tellDeviceLines()
{
    std::vector<std::pair<bool, std::string>> waiting;
    {
        const midair::base::Lock lock(lines().mutex);
        waiting.swap(lines().waiting);
    }
    for (const auto& [isWarning, line] : waiting)
        osg::notify(isWarning ? osg::WARN : osg::NOTICE) << "osgMidair: " << line << std::endl;
}

} // namespace osgMidair
