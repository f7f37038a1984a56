#include "samples/tools/solve/SolveProbe.h"

#include "haptics/base/InputError.h"
#include "haptics/probe/PressureProbe.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/SurfaceStatistics.h"

#include <fstream>
#include <iterator>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr double kMostSamples = 1e7; // about 700 MB of text

haptics::ProbeOptions optionsOf(const SolveArguments& arguments)
{
    haptics::ProbeOptions options;
    options.rate_Hz = arguments.probeRate_Hz;
    options.duration_s = arguments.probeDuration_s;
    return options;
}

Eigen::Matrix3Xd givenPlaces(const SolveArguments& arguments)
{
    return Eigen::Map<const Eigen::Matrix3Xd>(
        arguments.probes.data(), 3, static_cast<Eigen::Index>(arguments.probes.size() / 3));
}

void append(const Eigen::Matrix3Xd& more, Eigen::Matrix3Xd& places)
{
    places.conservativeResize(3, places.cols() + more.cols());
    places.rightCols(more.cols()) = more;
}

class CsvFile
{
public:
    CsvFile(std::string path, const std::string& header) : _path(std::move(path)), _file(_path)
    {
        if (!_file) throw base::InputError("cannot write " + _path);
        _file << header << '\n';
    }
    template<typename... Values>
    void row(fmt::format_string<Values...> format, Values&&... values)
    {
        _line.clear();
        fmt::format_to(std::back_inserter(_line), format, std::forward<Values>(values)...);
        _line.push_back('\n');
        _file.write(_line.data(), static_cast<std::streamsize>(_line.size()));
    }
    void finish()
    {
        _file.close();
        if (!_file)
            throw base::InputError("could not write " + _path + " to its end: is the disk full?");
    }

private:
    std::string _path;
    std::ofstream _file;
    fmt::memory_buffer _line;
};

/// The mean radiation pressure at a point over the steps of \a schedule, each as its steady field.
double steadyMean_Pa(const haptics::PressureProbe& probe,
                     const haptics::DriveSchedule& schedule,
                     const Eigen::Vector3d& point,
                     const haptics::Medium& medium)
{
    const std::vector<std::complex<double>> steady = probe.steadyAt(point);
    double sum = 0.0;
    for (const haptics::ScheduledDrive& step : schedule.steps)
        sum += step.duration_s * std::norm(step.amplitude * steady[std::size_t(step.drive)]);
    return sum / schedule.duration_s() * haptics::radiationPressure(1.0, medium);
}

} // namespace

bool asksForProbes(const SolveArguments& arguments)
{
    return !arguments.probes.empty() || arguments.probePoints;
}

Eigen::Matrix3Xd probePlaces(const SolveArguments& arguments,
                             const Eigen::Matrix3Xd& controlPoints,
                             const SolveScene& scene)
{
    const haptics::ProbeOptions options = optionsOf(arguments);
    std::string error;
    if (!options.isValid(&error)) throw base::InputError(error);
    Eigen::Matrix3Xd places = givenPlaces(arguments);
    if (arguments.probePatch_m > 0.0)
    {
        places = haptics::samplesNear(
            feltSurface(arguments, controlPoints, scene), places, arguments.probePatch_m);
        if (places.cols() == 0)
            throw base::InputError(fmt::format(
                "--probe-patch: no place of the felt surface is within {:g} m of a --probe",
                arguments.probePatch_m));
    }
    if (arguments.probePoints) append(controlPoints, places);
    if (places.cols() == 0) throw base::InputError("--probe-points: there are no control points");
    const double samples = static_cast<double>(places.cols()) * options.samples();
    if (samples > kMostSamples)
        throw base::InputError(fmt::format(
            "{} probes of {} samples are more than {:g} in all: shorten --duration, or lower "
            "--probe-rate",
            places.cols(),
            options.samples(),
            kMostSamples));
    return places;
}

ProbeTraces probe(const SolveArguments& arguments,
                  const Eigen::Matrix3Xd& places,
                  const haptics::FieldSequence& sequence,
                  const SolveScene& scene)
{
    const haptics::ProbeOptions options = optionsOf(arguments);
    const haptics::DriveSchedule schedule = haptics::stepsOf(sequence, options.duration_s);
    const haptics::PressureProbe probe(scene.array, scene.medium, schedule);
    ProbeTraces traces;
    traces.rate_Hz = options.rate_Hz;
    traces.ringing_s = scene.array.ringing_s;
    traces.points = places;
    traces.steadyMean_Pa.resize(places.cols());
    for (Eigen::Index l = 0; l < places.cols(); ++l)
    {
        traces.pressure_Pa.push_back(probe.at(places.col(l), options));
        traces.steadyMean_Pa[l] = steadyMean_Pa(probe, schedule, places.col(l), scene.medium);
    }
    return traces;
}

void writeProbe(const std::string& folder, const ProbeTraces& traces, const haptics::Medium& medium)
{
    CsvFile probes(folder + "/probe.csv", "point,time_s,p_re_Pa,p_im_Pa,radiation_Pa");
    CsvFile spectra(folder + "/spectrum.csv", "point,frequency_Hz,radiation_Pa");
    CsvFile places(folder + "/probe_points.csv", "point,x_m,y_m,z_m,mean_Pa,steadyMean_Pa");
    for (std::size_t l = 0; l < traces.pressure_Pa.size(); ++l)
    {
        const Eigen::VectorXcd& p_Pa = traces.pressure_Pa[l];
        const Eigen::VectorXd radiation_Pa = haptics::radiationOf(p_Pa, medium);
        for (Eigen::Index k = 0; k < p_Pa.size(); ++k)
            probes.row("{},{:.9g},{:.9g},{:.9g},{:.9g}",
                       l,
                       static_cast<double>(k) / traces.rate_Hz,
                       p_Pa[k].real(),
                       p_Pa[k].imag(),
                       radiation_Pa[k]);
        const auto column = static_cast<Eigen::Index>(l);
        places.row("{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}",
                   l,
                   traces.points(0, column),
                   traces.points(1, column),
                   traces.points(2, column),
                   radiation_Pa.mean(),
                   traces.steadyMean_Pa[column]);
        if (radiation_Pa.size() < 2) continue;
        const haptics::Spectrum spectrum = haptics::spectrumOf(radiation_Pa, traces.rate_Hz);
        for (Eigen::Index k = 0; k < spectrum.amplitude.size(); ++k)
            spectra.row("{},{:.9g},{:.9g}",
                        l,
                        static_cast<double>(k) * spectrum.step_Hz,
                        spectrum.amplitude[k]);
    }
    probes.finish();
    spectra.finish();
    places.finish();
}

} // namespace midair::samples
