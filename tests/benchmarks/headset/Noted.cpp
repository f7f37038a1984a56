#include "tests/benchmarks/headset/Noted.h"

#include "haptics/base/Units.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/benchmarks/Timing.h"

#include <osgMidair/DeviceDriver>
#include <osgMidair/FieldSolver>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <complex>
#include <cstdio>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace midair::bench
{

namespace
{

using Eigen::Vector3d;

struct Notes
{
    std::mutex mutex;
    std::vector<NotedDrive> drives;
    std::atomic<double> solver_ms{0.0};
};

Notes& notes()
{
    static Notes all;
    return all;
}

class NotingDriver : public osgMidair::DeviceDriver
{
public:
    bool open(const std::string& /*path*/,
              const std::map<std::string, std::string>& /*options*/,
              const Layout& layout,
              std::string& /*error*/) override
    {
        _transducers = layout.transducers;
        return true;
    }
    bool play(const unsigned char* phases, const unsigned char* amplitudes) override
    {
        NotedDrive drive;
        drive.time_s = base::steadySeconds();
        drive.phases.assign(phases, phases + _transducers);
        drive.amplitudes.assign(amplitudes, amplitudes + _transducers);
        const std::lock_guard<std::mutex> lock(notes().mutex);
        notes().drives.push_back(std::move(drive));
        return true;
    }
    void silence() override {}

protected:
    ~NotingDriver() override = default;

private:
    unsigned int _transducers = 0;
};

class TimedFoci : public osgMidair::FieldSolver
{
public:
    explicit TimedFoci(bool works) : _works(works) {}

    bool solve(const Problem& problem, std::complex<float>* q, std::string& /*error*/) override
    {
        const double time_ms = notes().solver_ms;
        const double until_ms = cpu_ms() + time_ms;
        if (!_works) std::this_thread::sleep_for(std::chrono::duration<double>(1e-3 * time_ms));
        for (unsigned int i = 0; i < problem.transducers; ++i)
        {
            std::complex<float> sum;
            for (unsigned int l = 0; l < problem.points; ++l)
                sum += std::conj(problem.matrix[l * problem.transducers + i]);
            q[i] = std::polar(0.5F, std::arg(sum));
        }
        while (_works && cpu_ms() < until_ms)
            continue;
        return true;
    }

protected:
    ~TimedFoci() override = default;

private:
    const bool _works;
};

} // namespace

void registerNoted()
{
    using namespace osgMidair;
    std::string error;
    const bool isDone =
        registerDevice(
            "noted", [] { return osg::ref_ptr<DeviceDriver>(new NotingDriver); }, error) &&
        registerSolver(
            "foci-sleeps", [] { return osg::ref_ptr<FieldSolver>(new TimedFoci(false)); }, error) &&
        registerSolver(
            "foci-works", [] { return osg::ref_ptr<FieldSolver>(new TimedFoci(true)); }, error);
    if (!isDone) std::printf("%s\n", error.c_str());
}

void setSolver_ms(double time_ms)
{
    notes().solver_ms = time_ms;
}

std::vector<NotedDrive> takeDrives()
{
    const std::lock_guard<std::mutex> lock(notes().mutex);
    return std::exchange(notes().drives, {});
}

FocusFinder::FocusFinder(const haptics::TransducerArray& array, double wavelength_m) :
    _positions(array.positions),
    _wavenumber_m(base::kTwoPi / wavelength_m)
{
    constexpr Eigen::Index kMost = 400;
    const Eigen::Index step = std::max<Eigen::Index>(1, array.size() / kMost);
    for (Eigen::Index i = 0; i < array.size(); i += step)
        _used.push_back(i);
}

std::optional<Vector3d> FocusFinder::near(const NotedDrive& drive, Vector3d place) const
{
    const auto loudness = [&](const Vector3d& at)
    {
        std::complex<double> sum = 0.0;
        for (const Eigen::Index i : _used)
        {
            const auto k = static_cast<std::size_t>(i);
            const double r = (at - _positions.col(i)).norm();
            const double amplitude = std::sin(base::kPi * drive.amplitudes[k] / 510.0);
            sum += std::polar(amplitude / r,
                              base::kTwoPi * drive.phases[k] / 256.0 - _wavenumber_m * r);
        }
        return std::abs(sum);
    };
    double most = loudness(place);
    if (!(most > 0.0)) return {};
    for (double step_m = 2e-3; step_m > 2e-5;)
    {
        Vector3d best = place;
        for (int axis = 0; axis < 2; ++axis)
            for (const double way : {-step_m, step_m})
            {
                Vector3d tried = place;
                tried[axis] += way;
                const double loud = loudness(tried);
                if (loud <= most) continue;
                most = loud;
                best = tried;
            }
        if (best == place) step_m *= 0.5;
        place = best;
    }
    return place;
}

Frames90::Frames90(osg::Node* root)
{
    _viewer.setUpViewerAsEmbeddedInWindow(0, 0, 64, 64);
    _viewer.setSceneData(root);
}

void Frames90::wait()
{
    _next = std::max(_next + std::chrono::nanoseconds(11111111),
                     std::chrono::steady_clock::now() - std::chrono::milliseconds(11));
    std::this_thread::sleep_until(_next);
}

void Frames90::traverse()
{
    _viewer.advance();
    _viewer.eventTraversal();
    _viewer.updateTraversal();
}

void Frames90::frame(const std::function<void(double time_s)>& before)
{
    wait();
    if (before) before(base::steadySeconds());
    traverse();
}

void Frames90::framesFor(double seconds, const std::function<void(double time_s)>& before)
{
    const double end_s = base::steadySeconds() + seconds;
    while (base::steadySeconds() < end_s)
        frame(before);
}

} // namespace midair::bench
