#include "tests/referee/PipelineRun.h"

#include "device/ArrayDevice.h"
#include "device/drive/DriveEncoder.h"
#include "haptics/base/Limits.h"
#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/haptics/surface/SphereMesh.h"

#include <stdexcept>

namespace midair::referee
{

namespace
{

constexpr int kEvery = 10;            // updates from one rest to the next
constexpr double kPatience_s = 300.0; // for what must come, of a thread of the lowest priority too
constexpr double kSamePlace_m = 1e-9;

} // namespace

PipelineRun::PipelineRun(const Scene& scene, const std::string& uri, Recorded& recorded) :
    _scene(scene),
    _recorded(recorded)
{
    _object.id = _object.meshId = 1;
    _object.path = scene.name;
    _object.mesh = sphere(scene.radius_m, 8);
    _object.properties.pressureInPa = scene.pressure_Pa > 0.0;
    _recorded.mesh = _object.mesh.get();
    _recorded.cap_Pa = scene.cap_Pa;
    _pipeline = std::make_unique<bridge::HologramPipeline>(options(uri));
    if (_device == nullptr) throw std::runtime_error("no device");
}

bridge::HologramOptions PipelineRun::options(const std::string& uri)
{
    bridge::HologramOptions options;
    options.array = _scene.array;
    options.medium = _recorded.medium;
    options.deviceUri = uri;
    options.solverOptions.phaseOnly = _scene.phaseOnly;
    options.solverOptions.loudness = _scene.loudness;
    options.solverOptions.threads = _scene.threads;
    options.maxPressure = _scene.cap_Pa;
    options.cycle = _scene.cycle;
    options.even = 0; // evened fields are for a surface, and figures of points are not theirs
    options.subsets = _scene.subsets;
    options.monitorInterval = _scene.isMeasured ? base::kLeastMonitorInterval_s : 0.0;
    options.deviceFactory = [this](const std::string& wanted, const device::DeviceLayout& layout)
    {
        auto device = device::openDevice(wanted, layout);
        _device = device.get();
        return device;
    };
    _recorded.skipTolerance_m = options.motionTolerance * options.wavelength_m();
    _recorded.fieldRate_Hz = options.fieldRate;
    return options;
}

/// Fields, or sequences of them, that the device took so far.
std::uint64_t PipelineRun::taken() const
{
    const device::DeviceReport report = _device->report();
    return report.sent - report.refused;
}

// Fields in turn are handed over and written by other threads, in the time that they take to play.
void PipelineRun::waitForFields(std::uint64_t takenBefore) const
{
    const auto fields = static_cast<double>(_last->sequence.fields.size());
    if (!eventually([&] { return taken() != takenBefore; }, kPatience_s))
        throw std::runtime_error(_scene.name + ": the device was not sent the fields in turn");
    if (fields > 1.0) letPass((2.0 * fields + 2.0) / _recorded.fieldRate_Hz);
}

// Of a cycle each set of points has a solver of its own, and stays the same on the mesh.
int PipelineRun::rowsOf(const haptics::ControlPoints& part, std::size_t place)
{
    if (_scene.cycle == 1) return static_cast<int>(place);
    const Eigen::Matrix3Xd onMesh = _assembledAt.inverse() * part.positions;
    for (std::size_t set = 0; set < _sets.size(); ++set)
        if (_sets[set].cols() == onMesh.cols() &&
            (_sets[set] - onMesh).cwiseAbs().maxCoeff() < kSamePlace_m)
            return static_cast<int>(set);
    _sets.push_back(onMesh);
    return static_cast<int>(_sets.size()) - 1;
}

void PipelineRun::keep(const Result& result, bool isJoined)
{
    const haptics::FieldSequence& sequence = result->sequence;
    Update update;
    update.report = result->report();
    update.isRepeat = result == _last;
    update.isJoined = isJoined;
    update.pose = _assembledAt;
    std::vector<device::DriveSignal> claim;
    for (std::size_t k = 0; k < sequence.fields.size(); ++k)
    {
        update.parts.push_back({sequence.parts.at(k), 0, rowsOf(sequence.parts.at(k), k)});
        const Eigen::VectorXcf& q = sequence.fields[k];
        if (!device::encode(q.data(), _scene.array.size(), claim.emplace_back()))
            throw std::runtime_error(_scene.name + ": a field is not finite");
    }
    if (update.isRepeat) // its points stand where they were assembled
        for (Part& part : update.parts)
            part.points.positions = _object.pose * (_assembledAt.inverse() * part.points.positions);
    _recorded.updates.push_back(std::move(update));
    _claims.push_back(std::move(claim));
    _last = result;
}

void PipelineRun::restUntilJoined()
{
    while (_pipeline->rest_s() == 0.0)
    {
        const std::uint64_t before = taken();
        const Result result = _pipeline->attend();
        if (!result) continue;
        if (result->sequence.fields.size() == 1) // the same field, with surface figures
        {
            _recorded.updates.back().report = result->report();
            _last = result;
            continue;
        }
        keep(result, true);
        waitForFields(before);
        return;
    }
}

// The figures are of the newest field that was measured, so they may change until none is left to
// be measured.
void PipelineRun::waitForSurface()
{
    const double end_s = base::steadySeconds() + kPatience_s;
    while (_pipeline->rest_s() < bridge::HologramPipeline::kAttend_s)
    {
        if (base::steadySeconds() > end_s)
            throw std::runtime_error(_scene.name + ": nobody measured the surface");
        letPass(1e-3);
        const Result result = _pipeline->attend();
        if (!result || !result->monitored) continue;
        _recorded.updates.back().report = result->report();
        _last = result;
    }
    if (!_last->monitored) throw std::runtime_error(_scene.name + ": the surface wasn't measured");
}

void PipelineRun::update(int k, const Eigen::Isometry3d& motion)
{
    _object.pose = Eigen::Translation3d(_scene.centre) * motion;
    if (_scene.pressure_Pa > 0.0)
        _object.properties.pressure = _scene.pressure_Pa * swingAt(_scene, k);
    bridge::SceneSnapshot snapshot;
    snapshot.frame = static_cast<std::uint64_t>(k);
    snapshot.time_s = base::steadySeconds();
    snapshot.objects = {_object};
    const std::uint64_t before = taken();
    const Result result = _pipeline->process(snapshot);
    if (result != _last) _assembledAt = _object.pose;
    const bool isNew = result != _last;
    keep(result, false);
    if (isNew) waitForFields(before);
    if (k % kEvery != kEvery - 1) return;
    if (_scene.cycle > 1) restUntilJoined();
    if (_scene.isMeasured) waitForSurface();
}

} // namespace midair::referee
