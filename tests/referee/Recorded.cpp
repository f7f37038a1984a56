#include "tests/referee/Recorded.h"

#include "device/ArrayDevice.h"
#include "device/drive/DriveEncoder.h"
#include "device/recording/Recording.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/HologramSolver.h"
#include "tests/referee/PipelineRun.h"

#include <fstream>
#include <iterator>
#include <stdexcept>

namespace midair::referee
{

namespace
{

/// Fields that the device took so far; the last of them is what is played.
std::uint64_t taken(const device::ArrayDevice& device)
{
    const device::DeviceReport report = device.report();
    return report.sent - report.refused;
}

// The solver by itself: to encode, send and rate the switch is all that the product does with its
// field.
void solveAndSend(const Scene& scene, int updates, const std::string& uri, Recorded& recorded)
{
    haptics::SolverOptions options;
    options.phaseOnly = scene.phaseOnly;
    options.loudness = scene.loudness;
    options.threads = scene.threads;
    recorded.skipTolerance_m =
        options.skipTolerance * recorded.medium.wavelength(scene.array.frequency_Hz);
    recorded.fieldRate_Hz = options.updateRate_Hz;
    const auto solver = haptics::makeSolver(haptics::solverNames().front(), options);
    const auto device = device::openDevice(uri, {scene.array.size(), scene.array.board});
    Eigen::VectorXcf q, last;
    device::DriveSignal signal;
    Motion motion;
    for (int k = 0; k < updates; ++k, motion.next())
    {
        const haptics::ControlPoints points = pointsAt(scene, motion.pose(), k);
        const haptics::SolveReport report = solver->solve(points, scene.array, recorded.medium, q);
        if (!device::encode(q.data(), scene.array.size(), signal) || !device->send(signal))
            throw std::runtime_error(scene.name + ": " + device->status());
        Update update;
        update.parts = {{points, static_cast<std::size_t>(taken(*device)) - 1, 0}};
        haptics::FieldSequence held;
        held.fields = {q};
        held.report = report;
        haptics::rateSwitch(last, options.updateRate_Hz, scene.array.ringing_s, held);
        last = q;
        update.report = held.report;
        recorded.updates.push_back(std::move(update));
    }
}

std::vector<device::DriveSignal> fieldsOf(const std::string& file)
{
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
    device::recording::Reader reader(bytes, file);
    device::recording::Entry entry;
    std::vector<device::DriveSignal> fields;
    device::recording::Stop stop = reader.next(entry);
    for (; stop == device::recording::Stop::MORE; stop = reader.next(entry))
        if (entry.kind == device::recording::Kind::FIELD) fields.push_back(entry.signal);
    if (stop != device::recording::Stop::END)
        throw std::runtime_error(file + " breaks off before its end");
    return fields;
}

/// True if nobody could tell one from the other: a transducer that is off has no phase.
bool soundAlike(const device::DriveSignal& a, const device::DriveSignal& b)
{
    if (a.duty != b.duty) return false;
    for (std::size_t i = 0; i < a.duty.size(); ++i)
        if (a.duty[i] > 0 && a.phase[i] != b.phase[i]) return false;
    return true;
}

/// Gives the parts of \a update their places among \a fields: the first from \a next on where the
/// fields in \a claim follow each other, beginning with any of them. Returns where to go on.
std::size_t locate(const std::vector<device::DriveSignal>& fields,
                   const std::vector<device::DriveSignal>& claim,
                   std::size_t next,
                   Update& update)
{
    const std::size_t K = claim.size();
    for (std::size_t at = next; at + K <= fields.size(); ++at)
        for (std::size_t turn = 0; turn < K; ++turn)
        {
            std::size_t alike = 0;
            while (alike < K && soundAlike(fields[at + alike], claim[(turn + alike) % K]))
                ++alike;
            if (alike < K) continue;
            for (std::size_t k = 0; k < K; ++k)
                update.parts[(turn + k) % K].field = at + k;
            return at + K;
        }
    throw std::runtime_error("the file has no place where the fields of a result are played");
}

void locateAll(const std::vector<std::vector<device::DriveSignal>>& claims, Recorded& recorded)
{
    std::size_t next = 0;
    for (std::size_t k = 0; k < claims.size(); ++k)
    {
        Update& update = recorded.updates[k];
        if (!update.isRepeat)
            next = locate(recorded.fields, claims[k], next, update);
        else
            for (std::size_t part = 0; part < update.parts.size(); ++part)
                update.parts[part].field = recorded.updates[k - 1].parts[part].field;
    }
}

/// Without fields in turn the file has each field that was sent once.
void requireNoOthers(const Scene& scene, const Recorded& recorded)
{
    if (scene.cycle > 1 || scene.subsets > 1) return;
    const std::vector<Update>& all = recorded.updates;
    if (all.empty() || recorded.fields.size() != all.back().parts.front().field + 1)
        throw std::runtime_error(scene.name + ": the file has another number of fields than sent");
}

} // namespace

Recorded record(const Scene& scene, int updates, const std::string& file)
{
    Recorded recorded;
    recorded.array = scene.array;
    const std::string uri = "record:" + file;
    std::vector<std::vector<device::DriveSignal>> claims;
    if (scene.throughPipeline)
    {
        PipelineRun run(scene, uri, recorded);
        Motion motion;
        for (int k = 0; k < updates; ++k, motion.next())
            run.update(k, motion.pose());
        claims = run.claims();
    }
    else
        solveAndSend(scene, updates, uri, recorded);
    recorded.fields = fieldsOf(file);
    locateAll(claims, recorded);
    requireNoOthers(scene, recorded);
    return recorded;
}

} // namespace midair::referee
