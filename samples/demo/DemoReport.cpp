#include "samples/demo/DemoReport.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include <nlohmann/json.hpp>

namespace midair::samples
{

namespace
{

/// What is said behind the pressure of the newest field.
const char* silenceOf(const osgMidair::HapticStatistics& statistics)
{
    return statistics.stop == "silenced" ? ": silenced" : "";
}

/// Returns the value below which the fraction \a share (0 .. 1) of \a values lies, interpolated
/// between two of them; 0 if there are none.
double percentile(std::vector<double> values, double share)
{
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    const double place = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

} // namespace

void DemoReport::addFrame(double frame_ms, const osgMidair::HapticStatistics& now)
{
    _frame_ms.push_back(frame_ms);
    if (now.figures.empty() || now.fieldFrame == _lastField) return;
    _lastField = now.fieldFrame;
    _solve_ms.push_back(now.matrix_ms + now.solve_ms);
    _rms.push_back(now.rms);
    _loudness.push_back(now.loudness);
    _latency_ms.push_back(now.latency_ms);
}

bool DemoReport::write(const std::string& path, std::string& error) const
{
    nlohmann::ordered_json json;
    json["model"] = model;
    json["size_m"] = options.size_m;
    json["array"] = array;
    json["transducers"] = transducers;
    json["device"] = statistics.device;
    json["stop"] = statistics.stop;
    json["temperature_C"] = temperature_C;
    json["frames"] = _frame_ms.size();
    json["framesPerSecond"] = seconds > 0.0 ? static_cast<double>(_frame_ms.size()) / seconds : 0.0;
    json["frame_ms"] = {{"median", percentile(_frame_ms, 0.5)},
                        {"p99", percentile(_frame_ms, 0.99)}};
    json["objects"] = statistics.objects;
    json["points"] = statistics.points;
    json["snapshots"] = statistics.snapshots;
    json["superseded"] = statistics.superseded;
    json["solves"] = statistics.solves;
    json["skippedUnmoved"] = statistics.skippedUnmoved;
    json["idleFrames"] = statistics.idleFrames;
    json["meshesSampled"] = statistics.meshesSampled;
    json["outOfWorkspace"] = statistics.outOfWorkspace;
    json["updatesPerSecond"] = statistics.updatesPerSecond;
    json["solve_ms"] = {{"median", percentile(_solve_ms, 0.5)},
                        {"p99", percentile(_solve_ms, 0.99)}};
    json["rms"] = {{"median", percentile(_rms, 0.5)}, {"max", percentile(_rms, 1.0)}};
    json["loudness"] = {{"median", percentile(_loudness, 0.5)},
                        {"min", percentile(_loudness, 0.0)}};
    json["maxPressure_Pa"] = statistics.maxPressure_Pa;
    json["capped"] = statistics.capped;
    json["latency_ms"] = {{"median", percentile(_latency_ms, 0.5)},
                          {"p99", percentile(_latency_ms, 0.99)}};
    json["fieldsInTurn"] = statistics.fieldsInTurn;
    json["fieldRate_Hz"] = statistics.fieldRate_Hz;
    json["outline"] = statistics.outline;
    // Figures of the newest field, except those that are already there as medians.
    for (const auto& [name, value] : statistics.figures)
    {
        std::string place = "/" + name; // "/surface/mean_Pa"
        std::replace(place.begin(), place.end(), '.', '/');
        const nlohmann::ordered_json::json_pointer pointer(place);
        if (json.contains(pointer)) continue;
        // Counts are whole numbers.
        if (value == std::floor(value) && std::abs(value) < 1e15)
            json[pointer] = static_cast<std::int64_t>(value);
        else
            json[pointer] = value;
    }
    if (statistics.certifiedGap >= 0.0) json["certifiedGap"] = statistics.certifiedGap;
    json["exposure"]["what"] = midair::haptics::kExposureMeaning;
    for (const midair::haptics::ExposureRow& row : midair::haptics::kExposureFigures)
        std::visit([&](auto member) { json["exposure"][row.name] = statistics.exposure.*member; },
                   row.value);
    json["slice_ms"] = slice_ms;
    json["slicesPerSecond"] = slicesPerSecond;
    json["pictures"] = nlohmann::ordered_json::array();
    for (const DemoPicture& picture : _pictures)
        json["pictures"].push_back({{"file", picture.file},
                                    {"frame", picture.frame},
                                    {"fieldFrame", picture.fieldFrame},
                                    {"latency_ms", picture.latency_ms},
                                    {"peak_Pa", picture.peak_Pa},
                                    {"peakToPoint_mm", picture.peakToPoint_mm}});
    if (!picturesProblem.empty()) json["picturesProblem"] = picturesProblem;
    json["messages"] = statistics.messages;
    std::ofstream file(path);
    file << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
    file.close();
    if (file) return true;
    error = "can't write " + path;
    return false;
}

void DemoReport::print() const
{
    const double fps = seconds > 0.0 ? static_cast<double>(_frame_ms.size()) / seconds : 0.0;
    std::printf("object      %s, largest extent %.0f mm, %d control points\n",
                model.c_str(),
                1e3 * options.size_m,
                statistics.points);
    std::printf(
        "array       %s, %d transducers, %.1f C\n", array.c_str(), transducers, temperature_C);
    std::printf("device      %s\n", statistics.device.c_str());
    std::printf("frames      %zu at %.1f/s, 99 %% within %.1f ms\n",
                _frame_ms.size(),
                fps,
                percentile(_frame_ms, 0.99));
    std::printf("fields      %llu solved of %llu handed over, %llu overtaken, %llu unmoved\n",
                static_cast<unsigned long long>(statistics.solves),
                static_cast<unsigned long long>(statistics.snapshots),
                static_cast<unsigned long long>(statistics.superseded),
                static_cast<unsigned long long>(statistics.skippedUnmoved));
    std::printf("solve       %.2f ms median, %.2f ms p99 (matrix included)\n",
                percentile(_solve_ms, 0.5),
                percentile(_solve_ms, 0.99));
    std::printf("accuracy    rms %.3f %% median, %.3f %% worst\n",
                100.0 * percentile(_rms, 0.5),
                100.0 * percentile(_rms, 1.0));
    std::printf("loudness    E %.3f, %.0f Pa (peak) at the points%s\n",
                percentile(_loudness, 0.5),
                statistics.level_Pa,
                silenceOf(statistics));
    if (statistics.maxPressure_Pa > 0.0)
        std::printf("cap         %.0f Pa at every point: %llu fields held down, the last to %.3f "
                    "of its amplitude\n",
                    statistics.maxPressure_Pa,
                    static_cast<unsigned long long>(statistics.capped),
                    statistics.capFactor);
    if (statistics.exposure.places > 0)
        std::printf(
            "at ears     %.0f dB re 20 uPa (rms) in the mean of %.1f s, at most %.0f dB over "
            "a second, of %d places, %.0f dB of it for a head%s\n",
            statistics.exposure.eq_dB,
            statistics.exposure.time_s,
            statistics.exposure.max_dB,
            statistics.exposure.places,
            statistics.exposure.head_dB,
            statistics.exposure.limit_dB > 0.0 ? ", with a limit" : "");
    if (statistics.outline) std::printf("curves      one stationary field of dense points\n");
    if (statistics.fieldsInTurn > 1)
        std::printf("in turn     %d fields at %.0f/s, audible change %.2f of the drive\n",
                    statistics.fieldsInTurn,
                    statistics.fieldRate_Hz,
                    statistics.audibleChange);
    if (statistics.surface.samples > 0)
        std::printf(
            "surface     %.1f Pa mean, cv %.2f, first percentile %.2f of the mean, contrast "
            "%.2f +- %.2f\n",
            statistics.surface.mean_Pa,
            statistics.surface.coefficientOfVariation,
            statistics.surface.percentile1,
            statistics.surface.contrast,
            statistics.surface.contrastError);
    if (statistics.certifiedGap >= 0.0)
        std::printf("certificate phases at most %.2f %% over the best there are\n",
                    100.0 * statistics.certifiedGap);
    std::printf("latency     %.2f ms median, %.2f ms p99, frame stamp to drive signal\n",
                percentile(_latency_ms, 0.5),
                percentile(_latency_ms, 0.99));
    if (picturesProblem.empty())
        std::printf("pictures    %zu in %s, slice in %.1f ms\n",
                    _pictures.size(),
                    options.out.c_str(),
                    slice_ms);
    else
        std::printf("pictures    none: %s\n", picturesProblem.c_str());
    for (const std::string& message : statistics.messages)
        std::printf("note        %s\n", message.c_str());
}

} // namespace midair::samples
