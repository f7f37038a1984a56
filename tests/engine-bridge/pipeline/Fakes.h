#pragma once

#include "device/ArrayDevice.h"
#include "device/drive/DriveEncoder.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/Halt.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

/// What a fake solver and device did, shared with the test that looks on.
struct FakeLog
{
    std::atomic<int> solves{0};
    std::atomic<int> sends{0};
    std::atomic<int> silences{0};
    std::atomic<int> closed{0};
    std::atomic<bool> refuseSends{false};
    Halt hold; ///< solve() doesn't return while this is set
    std::atomic<bool> throwInSolve{false};
    std::atomic<bool> throwNumber{false}; ///< solve() throws what is no std::exception
    std::atomic<bool> notFinite{false};
    std::atomic<float> amplitude{1.0f};        ///< of all transducers of a field
    std::atomic<float> loudestAmplitude{0.0f}; ///< of all that was sent

    std::mutex mutex;
    midair::haptics::ControlPoints points; ///< of the last solve
    bool absolute = false;
};

/// Solves nothing: all transducers at one amplitude, as late as the test wants.
class FakeSolver : public midair::haptics::HologramSolver
{
public:
    FakeSolver(std::shared_ptr<FakeLog> log, const midair::haptics::SolverOptions& options) :
        _log(std::move(log)),
        _options(options)
    {
    }

    midair::haptics::SolveReport solve(const midair::haptics::ControlPoints& points,
                                       const midair::haptics::TransducerArray& array,
                                       const midair::haptics::Medium&,
                                       Eigen::VectorXcf& q) override
    {
        ++_log->solves;
        if (_log->throwNumber) throw 5;
        if (_log->throwInSolve) throw std::runtime_error("the fake solver throws");
        _log->hold.pass();
        {
            const std::lock_guard<std::mutex> lock(_log->mutex);
            _log->points = points;
            _log->absolute = points.absolute;
        }
        q.setConstant(array.size(),
                      _log->notFinite ? std::numeric_limits<float>::quiet_NaN()
                                      : _log->amplitude.load());
        midair::haptics::SolveReport report;
        report.stop = midair::haptics::StopReason::CONVERGED;
        report.points = points.size();
        return report;
    }

    const midair::haptics::SolverOptions& options() const override { return _options; }

private:
    std::shared_ptr<FakeLog> _log;
    midair::haptics::SolverOptions _options;
};

class FakeDevice : public midair::device::ArrayDevice
{
public:
    FakeDevice(std::shared_ptr<FakeLog> log, int transducers) :
        _log(std::move(log)),
        _played(static_cast<std::size_t>(transducers))
    {
    }
    ~FakeDevice() override { ++_log->closed; }

    bool send(const midair::device::DriveSignal& signal) override
    {
        ++_log->sends;
        if (_log->refuseSends) return false;
        const std::lock_guard<std::mutex> lock(_mutex);
        midair::device::decode(signal, _played);
        for (const std::complex<float> q : _played)
            _log->loudestAmplitude = std::max(_log->loudestAmplitude.load(), std::abs(q));
        return true;
    }
    void silence() override
    {
        ++_log->silences;
        const std::lock_guard<std::mutex> lock(_mutex);
        std::fill(_played.begin(), _played.end(), 0.0f);
    }
    std::string status() const override { return "fake"; }
    midair::device::DeviceReport report() const override { return {}; }
    std::vector<std::complex<float>> played() const override
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _played;
    }

private:
    std::shared_ptr<FakeLog> _log;
    mutable std::mutex _mutex; ///< any thread may silence
    std::vector<std::complex<float>> _played;
};

inline midair::bridge::HologramOptions fakeOptions(const std::shared_ptr<FakeLog>& log)
{
    midair::bridge::HologramOptions options;
    options.array = midair::haptics::TransducerArray::octagonalPrism();
    options.solverFactory = [log](const std::string&, const midair::haptics::SolverOptions& o)
    { return std::make_unique<FakeSolver>(log, o); };
    options.deviceFactory = [log](const std::string&, const midair::device::DeviceLayout& layout)
    { return std::make_unique<FakeDevice>(log, layout.transducers); };
    return options;
}

/// A square of 40 mm in the plane y = 0.
inline std::shared_ptr<const midair::haptics::TriangleMesh> squareMesh(double size_m = 0.04)
{
    auto mesh = std::make_shared<midair::haptics::TriangleMesh>();
    mesh->vertices.resize(3, 4);
    mesh->vertices << -1.0, 1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0, -1.0, 1.0, 1.0;
    mesh->vertices *= 0.5 * size_m;
    mesh->triangles.resize(3, 2);
    mesh->triangles << 0, 0, 1, 2, 2, 3;
    return mesh;
}

inline midair::bridge::SceneSnapshot squareSnapshot(double x_m = 0.0)
{
    midair::bridge::SceneSnapshot snapshot;
    snapshot.time_s = midair::base::steadySeconds();
    midair::bridge::HapticObject object;
    object.id = 1;
    object.path = "Scene/Square";
    object.meshId = 1;
    object.mesh = squareMesh();
    object.pose.translation().x() = x_m;
    snapshot.objects.push_back(object);
    return snapshot;
}

/// Waits until another pipeline has sent \a count fields in turn, at the rate of all here: one that
/// has to send nothing would have sent about as many.
inline bool othersSend(int count)
{
    const auto log = std::make_shared<FakeLog>();
    midair::bridge::HologramOptions options = fakeOptions(log);
    options.modulation.amplitudeRate_Hz = 100.0;
    midair::bridge::HologramPipeline pipeline(options);
    pipeline.process(squareSnapshot());
    return eventually([&] { return log->sends >= count; });
}
