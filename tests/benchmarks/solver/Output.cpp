#include "haptics/base/InputError.h"
#include "haptics/base/simd/InstructionSet.h"
#include "haptics/propagation/kernels/PropagationKernels.h"
#include "tests/benchmarks/solver/Cell.h"

#include <cstdio>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

#ifndef MIDAIR_ROOT
#define MIDAIR_ROOT "."
#endif

namespace midair::bench
{

namespace
{

std::string processor()
{
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
    return "unknown";
}

// Of the sources, read from .git: a benchmark is no reason to need git.
std::string commit()
{
    std::string folder = MIDAIR_ROOT "/.git";
    std::ifstream pointer(folder);
    std::string word, path;
    if (pointer >> word >> path && word == "gitdir:") folder = path;
    std::ifstream head(folder + "/HEAD");
    if (!(head >> word)) return "unknown";
    if (word != "ref:" || !(head >> path)) return word;
    std::string common = folder;
    std::ifstream commonFile(folder + "/commondir");
    if (std::string relative; commonFile >> relative) common = folder + "/" + relative;
    for (const std::string& place : {folder, common})
        if (std::ifstream file(place + "/" + path); file >> word) return word;
    return "unknown";
}

void openOrThrow(std::ofstream& file, const std::string& path)
{
    file.open(path);
    if (!file) throw base::InputError("cannot write " + path);
}

} // namespace

void writeCsv(const std::string& path, const std::vector<Result>& results)
{
    std::ofstream file;
    openOrThrow(file, path);
    file << "case,n,radius_m,solver,mode,threads,isa,time_ms,rms,max,loudness,roofline_ms,"
            "roofline_multiple,cpu_ms,matrix_ms,iterations,iteration_limit,worst_rms,least_"
            "loudness,phase_step_rad,"
            "unequal,stop,loudness_option,audible_change,surface_mean,surface_cv,p01,p05,p10,p95,"
            "contrast,"
            "objective,bound,gap\n";
    for (const Result& r : results)
    {
        char line[768];
        std::snprintf(line,
                      sizeof line,
                      ",%d,%g,%s,%s,%d,%s,%.4f,%.4e,%.4e,%.4f,%.4f,%.3f,%.4f,%.4f,%d,%d,%.4e,%.4f,%"
                      ".4f,%d,%s,%g,%.4f,%.4g,%.4f,%.4f,%.4f,%.4f,%.4f,%.3f,%.6g,%.6g,%.5f\n",
                      r.points,
                      r.cell.radius_m,
                      r.cell.solver.c_str(),
                      r.cell.mode.c_str(),
                      r.cell.threads,
                      base::instructionSetName(base::instructionSet()),
                      r.time_ms,
                      r.rms,
                      r.max,
                      r.loudness,
                      r.roofline_ms,
                      r.roofline_ms > 0.0 ? r.time_ms / r.roofline_ms : 0.0,
                      r.cpu_ms,
                      r.matrix_ms,
                      r.iterations,
                      r.cell.iterations,
                      r.worstRms,
                      r.leastLoudness,
                      r.phaseStep_rad,
                      r.cell.unequal ? 1 : 0,
                      haptics::stopReasonName(r.last.stop),
                      r.cell.loudness,
                      r.audibleChange,
                      r.last.surface.mean_Pa,
                      r.last.surface.coefficientOfVariation,
                      r.last.surface.percentile1,
                      r.last.surface.percentile5,
                      r.last.surface.percentile10,
                      r.last.surface.percentile95,
                      r.last.surface.contrast,
                      r.objective,
                      r.bound,
                      r.gap);
        file << r.cell.kase << line;
    }
}

void writeJson(const std::string& path, const std::vector<Result>& results)
{
    nlohmann::ordered_json json;
    json["machine"] = processor();
    json["compiler"] = "g++ " __VERSION__;
    json["isa"] = base::instructionSetName(base::instructionSet());
    json["commit"] = commit();
    json["results"] = nlohmann::ordered_json::array();
    for (const Result& r : results)
        json["results"].push_back({{"case", r.cell.kase},
                                   {"n", r.points},
                                   {"radius_m", r.cell.radius_m},
                                   {"solver", r.cell.solver},
                                   {"mode", r.cell.mode},
                                   {"threads", r.cell.threads},
                                   {"time_ms", r.time_ms},
                                   {"cpu_ms", r.cpu_ms},
                                   {"matrix_ms", r.matrix_ms},
                                   {"roofline_ms", r.roofline_ms},
                                   {"rms", r.rms},
                                   {"max", r.max},
                                   {"loudness", r.loudness},
                                   {"worst_rms", r.worstRms},
                                   {"least_loudness", r.leastLoudness},
                                   {"iterations", r.iterations},
                                   {"iteration_limit", r.cell.iterations},
                                   {"phase_step_rad", r.phaseStep_rad},
                                   {"unequal", r.cell.unequal},
                                   {"loudness_option", r.cell.loudness},
                                   {"audible_change", r.audibleChange},
                                   {"surface_mean_Pa", r.last.surface.mean_Pa},
                                   {"surface_cv", r.last.surface.coefficientOfVariation},
                                   {"surface_p01", r.last.surface.percentile1},
                                   {"surface_p05", r.last.surface.percentile5},
                                   {"surface_p10", r.last.surface.percentile10},
                                   {"surface_p95", r.last.surface.percentile95},
                                   {"surface_contrast", r.last.surface.contrast},
                                   {"objective", r.objective},
                                   {"bound", r.bound},
                                   {"gap", r.gap},
                                   {"stop", haptics::stopReasonName(r.last.stop)}});
    std::ofstream file;
    openOrThrow(file, path);
    file << json.dump(1) << '\n';
}

} // namespace midair::bench
