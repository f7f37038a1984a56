#include "samples/tools/solve/Picture.h"

#include "haptics/probe/PressureProbe.h"
#include "samples/shared/views/CurvePlot.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include <dlfcn.h>
#include <fmt/format.h>

namespace midair::samples
{

namespace
{

Curve curveOf(const std::string& name, double step, const Eigen::VectorXd& y)
{
    return {Eigen::VectorXd::LinSpaced(y.size(), 0.0, step * static_cast<double>(y.size() - 1)),
            y,
            name};
}

// Draws the pressure over time and its spectrum up to the frequency limit of touch: one curve per
// point for few points, else the mean.
std::string drawProbes(const Solution& solution, const std::string& title, const std::string& path)
{
    constexpr double kFelt_Hz = 1000.0;
    constexpr std::size_t kMostCurves = 6;
    const ProbeTraces& traces = *solution.probe;
    CurvePanel time, frequency;
    time.xName = "time (ms)";
    frequency.xName = "frequency (Hz)";
    time.yName = frequency.yName = "radiation pressure (Pa)";
    frequency.logarithmic = true;
    const std::size_t count = traces.pressure_Pa.size();
    Eigen::VectorXd all_Pa = Eigen::VectorXd::Zero(traces.pressure_Pa.front().size());
    const auto add = [&](const std::string& name, const Eigen::VectorXd& radiation_Pa)
    {
        time.curves.push_back(curveOf(name, 1e3 / traces.rate_Hz, radiation_Pa));
        if (radiation_Pa.size() < 2) return;
        const haptics::Spectrum spectrum = haptics::spectrumOf(radiation_Pa, traces.rate_Hz);
        const auto felt =
            std::min(spectrum.amplitude.size(),
                     static_cast<Eigen::Index>(std::ceil(kFelt_Hz / spectrum.step_Hz)) + 1);
        frequency.curves.push_back(curveOf(name, spectrum.step_Hz, spectrum.amplitude.head(felt)));
    };
    for (std::size_t l = 0; l < count; ++l)
    {
        const Eigen::VectorXd radiation_Pa =
            haptics::radiationOf(traces.pressure_Pa[l], solution.scene.medium);
        all_Pa += radiation_Pa / static_cast<double>(count);
        if (count <= kMostCurves) add(fmt::format("point {}", l), radiation_Pa);
    }
    if (count > kMostCurves) add(fmt::format("mean of {} points", count), all_Pa);
    CurvePlot plot;
    plot.title = title + ": pressure over time";
    plot.caption =
        fmt::format("ringing time constant {:.0f} us; mean {:.1f} Pa, steady fields {:.1f} Pa",
                    1e6 * traces.ringing_s,
                    all_Pa.mean(),
                    traces.steadyMean_Pa.mean());
    plot.panels.push_back(time);
    if (!frequency.curves.empty()) plot.panels.push_back(frequency);
    return drawCurves(path, plot);
}

/// Returns the rows of \a deviation as curves of percent over its values times \a scale, with the
/// nominal array at 0.
CurvePanel tolerancePanel(const haptics::ToleranceStudy& study,
                          haptics::Deviation deviation,
                          const std::string& name,
                          double scale)
{
    std::vector<haptics::ToleranceRow> rows = {study.nominal};
    for (const haptics::ToleranceRow& row : study.rows)
        if (row.deviation == deviation) rows.push_back(row);
    std::sort(
        rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
    const auto count = static_cast<Eigen::Index>(rows.size());
    Eigen::VectorXd x(count), rms(count), quieter(count), focus(count);
    for (Eigen::Index k = 0; k < count; ++k)
    {
        const haptics::ToleranceRow& row = rows[static_cast<std::size_t>(k)];
        x[k] = scale * row.value;
        rms[k] = 100.0 * row.rms;
        quieter[k] = 100.0 * (1.0 - row.loudness / study.nominal.loudness);
        focus[k] = 100.0 * (1.0 - row.focus);
    }
    CurvePanel panel;
    panel.xName = name;
    panel.yName = "%";
    panel.curves = {{x, rms, "rms error"}, {x, quieter, "quieter by"}, {x, focus, "focus lost"}};
    return panel;
}

// Draws the losses in percent, a panel for each deviation.
std::string
drawTolerance(const Solution& solution, const std::string& title, const std::string& path)
{
    const haptics::ToleranceStudy& study = *solution.tolerance;
    CurvePlot plot;
    plot.title = title + ": effect of tolerances";
    plot.caption =
        fmt::format("medians of {} random arrays per value; nominal: rms {:.2f} %, E {:.3f}",
                    study.draws,
                    100.0 * study.nominal.rms,
                    study.nominal.loudness);
    using haptics::Deviation;
    struct Axis
    {
        Deviation deviation;
        const char* name;
        double scale;
    };
    for (const Axis& axis : {Axis{Deviation::POSITION, "boards displaced (mm rms)", 1e3},
                             Axis{Deviation::TILT, "boards turned (degrees rms)", 1.0},
                             Axis{Deviation::PHASE, "phase errors (degrees rms)", 1.0},
                             Axis{Deviation::TEMPERATURE, "air warmer (K)", 1.0},
                             Axis{Deviation::DEAD, "transducers dead (%)", 100.0}})
        if (std::any_of(study.rows.begin(),
                        study.rows.end(),
                        [&axis](const auto& row) { return row.deviation == axis.deviation; }))
            plot.panels.push_back(tolerancePanel(study, axis.deviation, axis.name, axis.scale));
    return drawCurves(path, plot);
}

std::string drawField(const Solution& solution, const std::string& title, const std::string& path)
{
    std::error_code error;
    const std::filesystem::path folder =
        std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
    void* module = nullptr;
    for (const char* place : {"midair-picture.so",
                              "../lib/midair-picture.so",
                              MIDAIR_LIBRARY_FROM_PROGRAM "/osgMidair/midair-picture.so"})
        if (!module && std::filesystem::exists(folder / place, error))
            module = dlopen((folder / place).c_str(), RTLD_NOW | RTLD_LOCAL);
    void* symbol = module ? dlsym(module, "midairDrawPicture") : nullptr;
    if (!symbol)
    {
        const char* why = dlerror();
        return "no picture is drawn: midair-picture.so " +
               (why ? std::string("can't be loaded: ") + why : std::string("isn't there"));
    }
    std::string problem;
    reinterpret_cast<decltype(&midairDrawPicture)>(symbol)(solution, title, path, problem);
    return problem;
}

} // namespace

std::string
drawPictures(const Solution& solution, const std::string& title, const std::string& folder)
{
    std::string problems;
    const auto add = [&problems](const std::string& problem)
    {
        if (!problem.empty()) problems += (problems.empty() ? "" : "; ") + problem;
    };
    add(drawField(solution, title, folder + "/field.png"));
    if (solution.probe) add(drawProbes(solution, title, folder + "/probe.png"));
    if (solution.tolerance) add(drawTolerance(solution, title, folder + "/tolerance.png"));
    return problems;
}

} // namespace midair::samples
