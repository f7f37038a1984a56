#include "haptics/sequence/FieldMonitor.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/PressureField.h"

#include <algorithm>
#include <chrono>
#include <complex>
#include <exception>
#include <utility>
#include <vector>

#ifdef __linux__
#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#endif

namespace midair::haptics
{

namespace
{

using Clock = std::chrono::steady_clock;

constexpr double kSampleSpacing = 0.18; // wavelengths; gaps are then less than a fifth
constexpr int kMostSamples = 100000;
constexpr std::size_t kMostMeshes = 16;

void takeLowestPriority()
{
#ifdef __linux__
    // The thread then runs only on otherwise idle cores; this needs no privileges. If it fails, the
    // thread runs at its normal priority.
    const sched_param none{};
    pthread_setschedparam(pthread_self(), SCHED_IDLE, &none);
#endif
}

// Restores the normal priority, if permitted, so that a caller waiting for the thread to end does
// not wait for everything else on a busy machine.
void giveBackPriority(std::thread& thread)
{
#ifdef __linux__
    const sched_param none{};
    pthread_setschedparam(thread.native_handle(), SCHED_OTHER, &none);
#else
    (void)thread;
#endif
}

CertificateOptions stoppable(CertificateOptions options, const base::StopSource& source)
{
    options.stop = source.token();
    return options;
}

const FieldMonitor::Options& checked(const FieldMonitor::Options& options)
{
    if (options.interval_s >= 0.0 && options.interval_s <= 1e6) return options;
    throw base::InputError(fmt::format(
        "field monitor: interval_s is {:g}; it must be from 0 to 1e6", options.interval_s));
}

} // namespace

KelvinCost kelvinCost(const ControlPoints& points,
                      const Eigen::VectorXcf& q,
                      const TransducerArray& array,
                      const Medium& medium,
                      int threads,
                      const base::StopToken& stop)
{
    std::vector<Eigen::Index> kept;
    for (Eigen::Index l = 0; l < points.size(); ++l)
        if (points.targets[l] > 0.0) kept.push_back(l);
    KelvinCost cost;
    if (kept.empty() || q.size() != array.size()) return cost;
    const Eigen::Matrix3Xd places = points.positions(Eigen::all, kept);
    Eigen::VectorXd a = points.targets(kept);
    raiseTargets(a);
    const auto pressure_Pa = [&](const Medium& air) -> Eigen::VectorXd
    {
        Eigen::VectorXcd p =
            pressureAt(places, array, air, q, threads, stop).cast<std::complex<double>>();
        if (points.outside_Pa.size() > 0) p += points.outside_Pa(kept);
        return p.cwiseAbs();
    };
    Medium other = medium;
    other.temperature_C += medium.temperature_C + 1.0 <= base::kMostTemperature_C ? 1.0 : -1.0;
    const double level = fittedLevel(pressure_Pa(medium), a);
    const Eigen::VectorXd y = pressure_Pa(other);
    const double otherLevel = fittedLevel(y, a);
    if (!(level > 0.0) || !(otherLevel > 0.0)) return cost;
    cost.level = otherLevel / level;
    cost.rms = relativeErrors(y, a, points.absolute ? 1.0 : otherLevel).rms;
    return cost;
}

FieldMonitor::FieldMonitor(const Options& options) :
    _options(checked(options)),
    _certifier(stoppable(options.certificate, _stopWork)),
    _thread([this] { run(); })
{
}

FieldMonitor::~FieldMonitor()
{
    _stop = true;
    _stopWork.request();
    giveBackPriority(_thread);
    _wake.notifyOne();
    _thread.join();
}

void FieldMonitor::submit(std::shared_ptr<const PlayedField> field)
{
    _field.put(std::move(field));
    _wake.notifyOne();
}

std::shared_ptr<const FieldMonitor::Result> FieldMonitor::latest() const
{
    const base::Lock lock(_latestMutex);
    if (auto result = _published.take()) _latest = std::move(result);
    return _latest;
}

void FieldMonitor::run()
{
    takeLowestPriority();
    const auto interval = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(_options.interval_s));
    while (!_stop)
    {
        _waiting = true;
        sleepUntil(Clock::time_point::max(), true);
        _waiting = false;
        const Clock::time_point next = Clock::now() + interval;
        if (const auto field = _field.take())
            _published.put(std::make_shared<const Result>(examine(*field)));
        sleepUntil(next, false);
    }
}

void FieldMonitor::sleepUntil(Clock::time_point end, bool orField)
{
    // The caller notifies without the mutex, so a notification can be missed; therefore it also
    // polls.
    constexpr std::chrono::milliseconds kLookAgain(50);
    base::Lock lock(_sleepMutex);
    while (!_stop && !(orField && !_field.isEmpty()) && Clock::now() < end)
        _wake.waitUntil(lock, std::min(end, Clock::now() + kLookAgain));
}

const FieldMonitor::Sampled&
FieldMonitor::sample(const FeltSurface& surface, double spacing_m, bool isBetween)
{
    for (const Sampled& known : _sampled)
        if (known.mesh == surface.mesh && known.sampling == surface.sampling &&
            known.spacing_m == spacing_m && known.isBetween == isBetween)
            return known;
    SamplerOptions options;
    options.spacing_m = spacing_m;
    options.sampling = surface.sampling;
    options.maxPoints = kMostSamples;
    options.stop = _stopWork.token();
    if (_sampled.size() >= kMostMeshes) _sampled.erase(_sampled.begin());
    const SurfaceSamples samples =
        isBetween ? sampleBetween(*surface.mesh, options) : sampleSurface(*surface.mesh, options);
    _sampled.push_back({surface.mesh, surface.sampling, spacing_m, isBetween, samples.positions});
    return _sampled.back();
}

// Returns the samples of all surfaces that are near a control point; the others belong to parts
// left out by the selection.
Eigen::Matrix3Xd FieldMonitor::feltSurface(const PlayedField& field)
{
    const double wavelength_m = field.medium.wavelength(field.array->frequency_Hz);
    Eigen::Matrix3Xd points(3, field.points.size() + field.others.size());
    points << field.points.positions, field.others.positions;
    Eigen::Matrix3Xd felt(3, 0);
    for (const FeltSurface& surface : field.surfaces)
    {
        Eigen::Matrix3Xd part =
            surface.pose * sample(surface, kSampleSpacing * wavelength_m, field.isEvened).positions;
        if (surface.reach_m > 0.0)
            part = samplesNear(part, points, surface.reach_m, _stopWork.token());
        if (felt.cols() + part.cols() > kMostSamples)
            throw base::InputError(
                fmt::format("field monitor: the surfaces take more than {} samples a fifth of a "
                            "wavelength apart; they are not measured",
                            kMostSamples));
        felt.conservativeResize(3, felt.cols() + part.cols());
        felt.rightCols(part.cols()) = part;
    }
    return felt;
}

FieldMonitor::Result FieldMonitor::examine(const PlayedField& field)
{
    Result result;
    result.number = field.number;
    result.isEvened = field.isEvened;
    try
    {
        if (!field.array) throw base::InputError("field monitor: the field has no array");
        if (!field.surfaces.empty())
        {
            const std::vector<Eigen::VectorXcf> alone{field.q};
            SurfaceStatisticsOptions options;
            options.stop = _stopWork.token();
            options.fieldRate_Hz = field.fieldRate_Hz;
            result.surface = surfaceStatistics(feltSurface(field),
                                               *field.array,
                                               field.medium,
                                               field.cycle.empty() ? alone : field.cycle,
                                               options);
        }
        result.kelvin =
            kelvinCost(field.points, field.q, *field.array, field.medium, 1, _stopWork.token());
        if (_options.certify && field.points.size() > 0)
            result.certificate =
                _certifier.certify(field.points, *field.array, field.medium, field.q);
    }
    catch (const std::exception& error)
    {
        result.error = error.what();
    }
    return result;
}

} // namespace midair::haptics
