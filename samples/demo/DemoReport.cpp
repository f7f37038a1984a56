#include "samples/demo/DemoReport.h"

#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/base/Percentile.h"
#include "haptics/solvers/SolveReport.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include <nlohmann/json.hpp>

namespace midair::samples
{

void DemoReport::addFrame(double frame_ms, const bridge::HologramResult* newest)
{
    _frame_ms.push_back(frame_ms);
    if (!newest || newest->frame == _lastField) return;
    _lastField = newest->frame;
    _solve_ms.push_back(newest->report().matrix_ms + newest->report().solve_ms);
    _rms.push_back(newest->report().rms);
    _loudness.push_back(newest->report().loudness);
    _latency_ms.push_back(newest->latency_ms);
}

bool DemoReport::write(const std::string& path, std::string& error) const
{
    nlohmann::ordered_json json;
    json["model"] = model;
    json["size_m"] = options.size_m;
    json["array"] = array;
    json["transducers"] = transducers;
    json["device"] = statistics.device;
    json["temperature_C"] = temperature_C;
    json["frames"] = _frame_ms.size();
    json["framesPerSecond"] = seconds > 0.0 ? static_cast<double>(_frame_ms.size()) / seconds : 0.0;
    json["frame_ms"] = {{"median", base::percentile(_frame_ms, 0.5)},
                        {"p99", base::percentile(_frame_ms, 0.99)}};
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
    json["solve_ms"] = {{"median", base::percentile(_solve_ms, 0.5)},
                        {"p99", base::percentile(_solve_ms, 0.99)}};
    json["rms"] = {{"median", base::percentile(_rms, 0.5)}, {"max", base::percentile(_rms, 1.0)}};
    json["loudness"] = {{"median", base::percentile(_loudness, 0.5)},
                        {"min", base::percentile(_loudness, 0.0)}};
    json["maxPressure_Pa"] = statistics.maxPressure_Pa;
    json["capped"] = statistics.capped;
    json["latency_ms"] = {{"median", base::percentile(_latency_ms, 0.5)},
                          {"p99", base::percentile(_latency_ms, 0.99)}};
    json["fieldsInTurn"] = statistics.fieldsInTurn;
    json["fieldRate_Hz"] = statistics.fieldRate_Hz;
    json["outline"] = statistics.outline;
    // Figures of the newest field, except those that are already there as medians.
    const nlohmann::ordered_json figures = haptics::toJson(statistics.figures);
    for (const auto& [name, value] : figures.items())
        if (!json.contains(name)) json[name] = value;
    if (statistics.certifiedGap >= 0.0) json["certifiedGap"] = statistics.certifiedGap;
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
    file << json.dump(2) << '\n';
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
                base::percentile(_frame_ms, 0.99));
    std::printf("fields      %llu solved of %llu handed over, %llu overtaken, %llu unmoved\n",
                static_cast<unsigned long long>(statistics.solves),
                static_cast<unsigned long long>(statistics.snapshots),
                static_cast<unsigned long long>(statistics.superseded),
                static_cast<unsigned long long>(statistics.skippedUnmoved));
    std::printf("solve       %.2f ms median, %.2f ms p99 (matrix included)\n",
                base::percentile(_solve_ms, 0.5),
                base::percentile(_solve_ms, 0.99));
    std::printf("accuracy    rms %.3f %% median, %.3f %% worst\n",
                100.0 * base::percentile(_rms, 0.5),
                100.0 * base::percentile(_rms, 1.0));
    std::printf("loudness    E %.3f, %.0f Pa (peak) at the points\n",
                base::percentile(_loudness, 0.5),
                statistics.level_Pa);
    if (statistics.maxPressure_Pa > 0.0)
        std::printf("cap         %.0f Pa at every point: %llu fields held down, the last to %.3f "
                    "of its amplitude\n",
                    statistics.maxPressure_Pa,
                    static_cast<unsigned long long>(statistics.capped),
                    statistics.capFactor);
    if (statistics.outline) std::printf("curves      one stationary field of dense points\n");
    if (statistics.fieldsInTurn > 1)
        std::printf("in turn     %d fields at %.0f/s, audible change %.2f of the drive\n",
                    statistics.fieldsInTurn,
                    statistics.fieldRate_Hz,
                    statistics.audibleChange);
    if (statistics.surface.samples > 0)
        std::printf(
            "surface     %.1f Pa mean, cv %.2f, first percentile %.2f of the mean, contrast "
            "%.1f\n",
            statistics.surface.mean_Pa,
            statistics.surface.coefficientOfVariation,
            statistics.surface.percentile1,
            statistics.surface.contrast);
    if (statistics.certifiedGap >= 0.0)
        std::printf("certificate phases at most %.2f %% over the best there are\n",
                    100.0 * statistics.certifiedGap);
    std::printf("latency     %.2f ms median, %.2f ms p99, frame stamp to drive signal\n",
                base::percentile(_latency_ms, 0.5),
                base::percentile(_latency_ms, 0.99));
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
